// The worker that fits texels to the labels of a file.
import { fitTexels } from '#encoder';
import { loadEncoder } from './encoder.js';
import { viewerError } from './errors.js';
import type { FittingJob, FittingResult } from './fitting.js';

addEventListener('message', async ({ data }: MessageEvent<FittingJob>) => {
  try {
    await loadEncoder();
    answer({ bytes: fitTexels(data) });
  } catch (cause) {
    // What stops the module itself is that memory ran out.
    const step = cause instanceof WebAssembly.RuntimeError ? 'limit' : 'malformed';
    const { kind, message } = viewerError(cause, step);
    answer({ kind, message });
  }
});

function answer(result: FittingResult): void {
  const transfer = 'bytes' in result ? [result.bytes.buffer] : [];
  postMessage(result, { transfer });
}
