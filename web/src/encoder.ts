import init from '#encoder';
import { ViewerError } from './errors.js';
import { encoderModule } from './fetched.js';

let loaded: Promise<void> | undefined;

/**
 * Brings the encoder's module, which the viewer itself does without. For workers, for absorb.ts and for material.ts. A failed load is
 * forgotten, so that a retry fetches again.
 */
export function loadEncoder(): Promise<void> {
  loaded ??= load().catch((cause) => {
    loaded = undefined;
    throw cause;
  });
  return loaded;
}

async function load(): Promise<void> {
  const response = await encoderModule().catch((cause) => {
    throw new ViewerError('network', 'The encoder could not be fetched.', cause);
  });
  if (!response.ok) throw new ViewerError('http', `The encoder could not be fetched (${response.status}).`);
  await init({ module_or_path: response });
}
