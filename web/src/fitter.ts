// The worker that gives texels to the labels of a file, or of a tile.
import { drawTile, fitTexels } from '#encoder';
import { loadEncoder } from './encoder.js';
import { viewerError } from './errors.js';
import type { FittingJob, FittingResult } from './fitting.js';

let loaded: Promise<void> | undefined;

addEventListener('message', async ({ data }: MessageEvent<FittingJob>) => {
  try {
    loaded ??= loadEncoder();
    await loaded;
    answer({ bytes: texels(data) });
  } catch (cause) {
    // What stops the module itself is that memory ran out.
    const step = cause instanceof WebAssembly.RuntimeError ? 'limit' : 'malformed';
    const { kind, message } = viewerError(cause, step);
    answer({ kind, message });
  }
});

function texels(job: FittingJob): Uint8Array {
  if (job instanceof Uint8Array) return fitTexels(job);
  return drawTile(job.head, job.level, job.x, job.y, job.bytes);
}

function answer(result: FittingResult): void {
  const transfer = 'bytes' in result ? [result.bytes.buffer] : [];
  postMessage(result, { transfer });
}
