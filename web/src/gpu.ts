import { Renderer } from '#wasm';
import { ViewerError } from './errors.js';

// Either back end fetches its own alone.
const wgslShaders = () => import('./webgpu.js');
const glslShaders = () => import('./webgl2.js');

/** Fetches what `takeGpu` will need, while the module is not there yet. */
export function fetchShaders(choice: 'auto' | 'webgpu' | 'webgl2'): void {
  const shaders = choice !== 'webgl2' && 'gpu' in navigator ? wgslShaders() : glslShaders();
  // Whoever needs them hears of it.
  shaders.catch(() => {});
}

/** Takes a GPU for the module to draw with: by WebGPU, else by WebGL2, as far as the choice is free. */
export async function takeGpu(choice: 'auto' | 'webgpu' | 'webgl2'): Promise<Renderer> {
  if (choice === 'webgl2') return webgl2();
  // A browser may offer WebGPU and then have no adapter or device for it.
  return webgpu().catch((cause) => (choice === 'auto' ? webgl2() : Promise.reject(cause)));
}

async function webgpu(): Promise<Renderer> {
  // Not every browser has it.
  const gpu = navigator.gpu as GPU | undefined;
  if (!gpu) throw fault('this browser has no WebGPU');
  const adapter = await gpu.requestAdapter();
  if (!adapter) throw fault('this browser has WebGPU but no GPU for it');
  const device = await adapter.requestDevice();
  const canvas = new OffscreenCanvas(1, 1);
  const faults: string[] = [];
  device.onuncapturederror = ({ error }) => {
    const isMemory = error instanceof GPUOutOfMemoryError;
    faults.push(isMemory ? 'the GPU has too little memory for this picture' : error.message);
  };
  device.lost.then(({ message }) => {
    faults.push(`the GPU device was lost: ${message}`);
    // Told as WebGL2 tells it.
    canvas.dispatchEvent(new Event('webglcontextlost'));
  });
  const format = gpu.getPreferredCanvasFormat();
  const module = device.createShaderModule({ code: (await wgslShaders()).wgsl });
  const pipelines = await Promise.all(Renderer.pipelines(device, format, module));
  const context = canvas.getContext('webgpu' as OffscreenRenderingContextId) as GPUCanvasContext | null;
  if (!context || faults[0]) throw fault(faults[0] ?? 'this browser gave no WebGPU canvas');
  context.configure({ device, format, alphaMode: 'premultiplied' });
  return Renderer.onDevice(canvas, context, device, format, module, pipelines, faults);
}

async function webgl2(): Promise<Renderer> {
  const { glsl } = await glslShaders();
  const canvas = new OffscreenCanvas(1, 1);
  const gl = canvas.getContext('webgl2', { antialias: false, depth: false });
  if (!gl) throw fault('this browser has no WebGL2');
  return Renderer.onContext(canvas, gl, glsl);
}

function fault(message: string): ViewerError {
  return new ViewerError('gpu', message);
}
