import init from '#encoder';
import { ViewerError } from './errors.js';
import { encoderModule } from './fetched.js';

/** Fetches the encoder's module, which the viewer itself does without. For workers, and for absorb.ts. */
export async function loadEncoder(): Promise<void> {
  const response = await encoderModule().catch((cause) => {
    throw new ViewerError('network', 'The encoder could not be fetched.', cause);
  });
  if (!response.ok) throw new ViewerError('http', `The encoder could not be fetched (${response.status}).`);
  await init({ module_or_path: response });
}
