// The worker that gives texels to the labels of a file, or of a tile, and writes tiles as lines and areas.
import { drawTile, fitTexels, TracedPicture } from '#encoder';
import { loadEncoder } from './encoder.js';
import { viewerError } from './errors.js';
import type { FittingJob, FittingResult, TracingJob } from './fitting.js';

addEventListener('message', async ({ data }: MessageEvent<FittingJob>) => {
  try {
    await loadEncoder();
    answer({ bytes: 'tiles' in data ? traced(data) : texels(data) });
  } catch (cause) {
    // What stops the module itself is that memory ran out.
    const step = cause instanceof WebAssembly.RuntimeError ? 'limit' : 'malformed';
    const { kind, message } = viewerError(cause, step);
    answer({ kind, message });
  }
});

function traced({ tiles, names, type, width, height, scale, centre }: TracingJob): Uint8Array {
  const picture = TracedPicture.open(tiles[0]?.head ?? new Uint8Array());
  for (const { level, x, y, bytes, words } of tiles) picture.add(level, x, y, bytes, words);
  for (const [color, name] of names) picture.name(color, name);
  return picture.write(type, width, height, scale, ...centre);
}

function texels(job: Exclude<FittingJob, TracingJob>): Uint8Array {
  if (job instanceof Uint8Array) return fitTexels(job);
  return drawTile(job.head, job.level, job.x, job.y, job.bytes);
}

function answer(result: FittingResult): void {
  const transfer = 'bytes' in result ? [result.bytes.buffer] : [];
  postMessage(result, { transfer });
}
