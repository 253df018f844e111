// Texels for labels, by a worker. A module of its own, fetched only where there are labels: dist/istar-labels.js.
import type { RawTile } from './archive.js';
import type { ErrorKind } from './errors.js';
import { fitterWorker } from './fetched.js';
import type { Centre } from './place.js';

/** Tiles to be written as lines and areas, `width` × `height` of them about a place, in the format of that type. */
export interface TracingJob {
  type: string;
  /** Each with the styles of its regions, if they are not as the file has them: see Style in src/style.rs. */
  tiles: (RawTile & { words: Uint32Array })[];
  /** What regions are called, by their colour as 0xRRGGBBAA. */
  names: ReadonlyMap<number, string>;
  width: number;
  height: number;
  scale: number;
  centre: Centre;
}

/**
 * What the worker is given, a whole file or a tile, or what is to be traced, and what it says. An error loses its class and its name
 * on the way.
 */
export type FittingJob = Uint8Array | RawTile | TracingJob;
export type FittingResult = { bytes: Uint8Array } | { kind: ErrorKind; message: string };

let last: Promise<unknown> = Promise.resolve();
/** It stays for the next tile. */
let worker: Worker | undefined;

/**
 * The file or the tile with texels, or what was traced. One at a time, however many figures ask: each keeps a processor busy. A
 * worker that had more than a tile ends, which gives back the memory that it took; so does one where something went wrong.
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
  const isTile = 'bytes' in job;
  try {
    return await new Promise((resolve, reject) => {
      const until = { signal: ending.signal };
      // A tile is soon done, and another one will be wanted.
      if (!isTile) signal.addEventListener('abort', () => reject(stopped), until);
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
      const sent: FittingJob = isTile ? { ...job, bytes: job.bytes.slice() } : job;
      busy.postMessage(sent);
    });
  } catch (cause) {
    end();
    throw cause;
  } finally {
    ending.abort();
    if (!isTile) end();
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
