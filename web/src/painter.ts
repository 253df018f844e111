// The worker that paints where there is no GPU. Its module is the encoder's, which has the painter too.
import { compiled, Frame, PaintedTile } from '#encoder';
import type { PaintAnswer, PaintJob } from './cpu.js';
import { loadEncoder } from './encoder.js';
import { viewerError } from './errors.js';

const tiles = new Map<number, PaintedTile>();

addEventListener('message', ({ data }: MessageEvent<PaintJob>) => attempt(() => work(data)));
attempt(async () => {
  await loadEncoder();
  answer({ ready: true, module: compiled });
});

/** What goes wrong here goes wrong again: the viewer starts another worker, or gives up. */
async function attempt(step: () => void | Promise<void>): Promise<void> {
  try {
    await step();
  } catch (cause) {
    const { kind, message } = viewerError(cause, 'gpu');
    answer({ kind, message });
  }
}

async function work(job: PaintJob): Promise<void> {
  if ('free' in job) {
    tiles.get(job.free)?.free();
    tiles.delete(job.free);
  } else if ('bytes' in job) {
    tiles.set(job.tile, PaintedTile.read(job.head, job.level, job.x, job.y, job.bytes));
  } else if ('words' in job) {
    tiles.get(job.tile)?.setStyles(job.first, job.words);
  } else {
    const [, , width, height] = job.args;
    const frame = new Frame(...job.args);
    for (const id of job.tiles) {
      const tile = tiles.get(id);
      if (tile) frame.paint(tile);
    }
    const pixels = new ImageData(new Uint8ClampedArray(frame.pixels()), width, height);
    const image = await createImageBitmap(pixels);
    answer({ frame: job.frame, image });
  }
}

function answer(result: PaintAnswer): void {
  postMessage(result, { transfer: 'image' in result ? [result.image] : [] });
}
