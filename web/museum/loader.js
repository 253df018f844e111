// The worker that makes materials of pictures, and tells regions.
import { IStarMaterial } from '../istar-material.js';

const materials = new Map();

addEventListener('message', async ({ data }) => {
  try {
    if (data.load) {
      const response = await fetch(data.load);
      if (!response.ok) throw new Error(`${data.load} could not be fetched (${response.status}).`);
      const bytes = new Uint8Array(await response.arrayBuffer());
      const size = bytes.length;
      const material = await IStarMaterial.load(bytes);
      materials.set(data.name, material);
      const textures = material.textures.map(({ name, format, levels }) => ({ name, format, levels }));
      const buffers = textures.flatMap(({ levels }) => levels.map(({ data }) => data.buffer));
      postMessage({ name: data.name, textures, size }, buffers);
    } else {
      const found = materials.get(data.name)?.regionAt(...data.at);
      postMessage({ ask: data.ask, found });
    }
  } catch (cause) {
    postMessage({ name: data.name, ask: data.ask, fault: cause.message });
  }
});
