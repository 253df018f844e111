import { type ErrorKind, ViewerError } from './errors.js';

/** What the worker is given, and what it says. An error loses its class and its name on the way. */
export type FittingJob = Uint8Array;
export type FittingResult = { bytes: Uint8Array } | { kind: ErrorKind; message: string };

let last: Promise<unknown> = Promise.resolve();

/**
 * The file with texels. One at a time, however many figures ask: each keeps a processor busy. Each in a worker of its own, whose
 * end gives back the memory that it took, also where it went wrong.
 */
export function fitted(bytes: Uint8Array, signal: AbortSignal): Promise<Uint8Array> {
  const job = last.then(() => inWorker(bytes, signal));
  last = job.catch(() => {});
  return job;
}

async function inWorker(bytes: Uint8Array, signal: AbortSignal): Promise<Uint8Array> {
  const stopped = new ViewerError('aborted', 'Loading was stopped.');
  if (signal.aborted) throw stopped;
  const worker = start();
  const ending = new AbortController();
  try {
    return await new Promise((resolve, reject) => {
      const until = { signal: ending.signal };
      signal.addEventListener('abort', () => reject(stopped), until);
      const answered = ({ data }: MessageEvent<FittingResult>) => {
        if ('bytes' in data) resolve(data.bytes);
        else reject(new ViewerError(data.kind, data.message));
      };
      const failed = (event: Event) => {
        event.preventDefault();
        reject(new ViewerError('unsupported', 'The encoder could not be started.', event));
      };
      worker.addEventListener('message', answered, until);
      worker.addEventListener('error', failed, until);
      worker.addEventListener('messageerror', failed, until);
      worker.postMessage(bytes satisfies FittingJob);
    });
  } finally {
    ending.abort();
    worker.terminate();
  }
}

function start(): Worker {
  try {
    // One static literal: bundlers find and copy the file by it.
    return new Worker(new URL('./istar-fitter.js', import.meta.url), { type: 'module' });
  } catch (cause) {
    // A worker's script must be of the page's own origin.
    throw new ViewerError('unsupported', 'The encoder must come from the same server as the page.', cause);
  }
}
