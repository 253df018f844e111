// What fetched.ts fetches, inside the script: for pages that cannot have other files beside it.
import encoder from 'inside:encoder';
import fitter from 'inside:fitter';
import painter from 'inside:painter';
import viewer from 'inside:viewer';
import type * as fetched from './fetched.js';
import { unpacked } from './unpack.js';

export const settings: typeof fetched.settings = {};

export function viewerModule(): Promise<Response> {
  return unpacked(viewer);
}

/** For what styles ask of it; workers have their own. */
export function encoderModule(): Promise<Response> {
  return unpacked(encoder);
}

export function fitterWorker(): Worker {
  return worker(fitter);
}

export function painterWorker(): Worker {
  return worker(painter);
}

/** Both workers have the encoder's module from here, so that it is in the script once. */
function worker(text: string): Worker {
  const url = URL.createObjectURL(
    new Blob([`const packedEncoder = "${encoder}";`, text], { type: 'text/javascript' }),
  );
  // The worker has its own reference by then.
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
  return new Worker(url);
}
