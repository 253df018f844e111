// Texels for labels, by a worker. A module of its own, fetched only where there are labels: dist/istar-labels.js.
import type { RawTile } from './archive.js';
import type { ErrorKind } from './errors.js';
import { fitterWorker } from './fetched.js';

/** What the worker is given, a whole file or a tile, and what it says. An error loses its class and its name on the way. */
export type FittingJob = Uint8Array | RawTile;
export type FittingResult = { bytes: Uint8Array } | { kind: ErrorKind; message: string };

let last: Promise<unknown> = Promise.resolve();
/** It stays for the next tile. */
let worker: Worker | undefined;

/**
 * The file or the tile with texels. One at a time, however many figures ask: each keeps a processor busy. A worker that had a
 * file ends, which gives back the memory that it took; so does one where something went wrong.
 */
export function fitted(job: FittingJob, signal: AbortSignal): Promise<Uint8Array> {
  const done = last.then(() => inWorker(job, signal));
  last = done.catch(() => {});
  return done;
}

async function inWorker(job: FittingJob, signal: AbortSignal): Promise<Uint8Array> {
  const stopped = fault('aborted', 'Loading was stopped.');
  if (signal.aborted) throw stopped;
  worker ??= start();
  const busy = worker;
  const ending = new AbortController();
  const end = () => {
    busy.terminate();
    worker = undefined;
  };
  const isFile = job instanceof Uint8Array;
  try {
    return await new Promise((resolve, reject) => {
      const until = { signal: ending.signal };
      // A tile is soon done, and another one will be wanted.
      if (isFile) signal.addEventListener('abort', () => reject(stopped), until);
      const answered = ({ data }: MessageEvent<FittingResult>) => {
        if ('bytes' in data) resolve(data.bytes);
        else reject(fault(data.kind, data.message));
      };
      const failed = (event: Event) => {
        event.preventDefault();
        reject(fault('unsupported', 'The encoder could not be started.', event));
      };
      busy.addEventListener('message', answered, until);
      busy.addEventListener('error', failed, until);
      busy.addEventListener('messageerror', failed, until);
      // Of its own: what is sent is a whole buffer.
      const sent: FittingJob = isFile ? job : { ...job, bytes: job.bytes.slice() };
      busy.postMessage(sent);
    });
  } catch (cause) {
    end();
    throw cause;
  } finally {
    ending.abort();
    if (isFile) end();
  }
}

function start(): Worker {
  try {
    return fitterWorker();
  } catch (cause) {
    // A worker's script must be of the page's own origin.
    throw fault('unsupported', 'The encoder must come from the same server as the page.', cause);
  }
}

/** Rust's errors have their kind for a name; so have those of a module beside the viewer's. */
function fault(kind: ErrorKind, message: string, cause?: unknown): Error {
  return Object.assign(new Error(message, { cause }), { name: kind });
}
