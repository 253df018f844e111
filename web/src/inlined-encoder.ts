// For the workers of the inlined build, in place of fetched.ts.
import { unpacked } from './unpack.js';

/** Said by inlined.ts, in front of the worker's text. */
declare const packedEncoder: string;

export function encoderModule(): Promise<Response> {
  return unpacked(packedEncoder);
}
