// The worker that makes materials of pictures, and tells regions.
import { IStarMaterial } from '../istar-material.js';

const materials = new Map();

addEventListener('message', async ({ data }) => {
  try {
    if (data.load) {
      const material = await IStarMaterial.load(data.load);
      materials.set(data.name, material);
      const textures = material.textures.map(({ name, format, levels }) => ({ name, format, levels }));
      const buffers = textures.flatMap(({ levels }) => levels.map(({ data }) => data.buffer));
      postMessage({ name: data.name, textures }, buffers);
    } else {
      const found = materials.get(data.name)?.regionAt(...data.at);
      postMessage({ ask: data.ask, found });
    }
  } catch (cause) {
    postMessage({ name: data.name, ask: data.ask, fault: cause.message });
  }
});
