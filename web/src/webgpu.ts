// The shaders for WebGPU.
export { wgsl } from '#shaders';
