// The shaders for WebGL2: of each draw, for vertices and for pixels.
export { glsl } from '#shaders';
