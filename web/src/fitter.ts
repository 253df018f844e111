// The worker that fits texels to the labels of a file. It fetches the encoder, which the viewer itself does without.
import init, { fitTexels } from '#encoder';
import { ViewerError, viewerError } from './errors.js';
import type { FittingJob, FittingResult } from './fitting.js';

addEventListener('message', async ({ data }: MessageEvent<FittingJob>) => {
  try {
    await load();
    answer({ bytes: fitTexels(data) });
  } catch (cause) {
    // What stops the module itself is that memory ran out.
    const step = cause instanceof WebAssembly.RuntimeError ? 'limit' : 'malformed';
    const { kind, message } = viewerError(cause, step);
    answer({ kind, message });
  }
});

async function load(): Promise<void> {
  // One static literal: bundlers find and copy the file by it.
  const url = new URL('./istar_encoder_bg.wasm', import.meta.url);
  const response = await fetch(url).catch((cause) => {
    throw new ViewerError('network', 'The encoder could not be fetched.', cause);
  });
  if (!response.ok) throw new ViewerError('http', `The encoder could not be fetched (${response.status}).`);
  await init({ module_or_path: response });
}

function answer(result: FittingResult): void {
  const transfer = 'bytes' in result ? [result.bytes.buffer] : [];
  postMessage(result, { transfer });
}
