// The worker that builds the hall: its light takes seconds, in which the page shall answer.
import { built } from './mesh.js';

try {
  const scene = built();
  const meshes = [...Object.values(scene.meshes), ...scene.pictures];
  const buffers = meshes.flatMap(({ corners, indices }) => [corners.buffer, indices.buffer]);
  postMessage({ scene }, [scene.sheet.texels.buffer, ...buffers]);
} catch (cause) {
  postMessage({ fault: cause.message });
}
