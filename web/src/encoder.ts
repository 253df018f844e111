import init from '#encoder';
import { ViewerError } from './errors.js';

/** Fetches the encoder's module, which the viewer itself does without. For workers. */
export async function loadEncoder(): Promise<void> {
  // One static literal: bundlers find and copy the file by it.
  const url = new URL('./istar_encoder_bg.wasm', import.meta.url);
  const response = await fetch(url).catch((cause) => {
    throw new ViewerError('network', 'The encoder could not be fetched.', cause);
  });
  if (!response.ok) throw new ViewerError('http', `The encoder could not be fetched (${response.status}).`);
  await init({ module_or_path: response });
}
