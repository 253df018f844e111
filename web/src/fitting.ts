import { type ErrorKind, ViewerError } from './errors.js';

/** What the page and the worker say to each other. An error loses its class and its name on the way. */
export type FittingJob = { id: number; bytes: Uint8Array };
export type FittingResult = { id: number } & ({ bytes: Uint8Array } | { kind: ErrorKind; message: string });

interface Waiting {
  resolve: (bytes: Uint8Array) => void;
  reject: (cause: unknown) => void;
}

/** Where a file says what it carries, and what it says where that is labels: see SPEC.md. */
const PAYLOAD = 15;
const LABELS = 1;

let worker: Worker | undefined;
let jobs = 0;
const waiting = new Map<number, Waiting>();

/** Whether a file holds labels, to which texels have to be fitted before it is drawn. */
export function holdsLabels(bytes: Uint8Array): boolean {
  return bytes[PAYLOAD] === LABELS;
}

/** The file with texels. All figures share one worker; it ends with the last that waits for it. */
export async function fitted(bytes: Uint8Array, signal: AbortSignal): Promise<Uint8Array> {
  const id = jobs++;
  const leave = () => {
    waiting.get(id)?.reject(new ViewerError('aborted', 'Loading was stopped.'));
    waiting.delete(id);
    if (waiting.size === 0) endWorker();
  };
  signal.addEventListener('abort', leave, { once: true });
  try {
    return await new Promise((resolve, reject) => {
      waiting.set(id, { resolve, reject });
      worker ??= startWorker();
      worker.postMessage({ id, bytes } satisfies FittingJob);
    });
  } finally {
    signal.removeEventListener('abort', leave);
  }
}

function startWorker(): Worker {
  // One static literal: bundlers find and copy the file by it.
  const started = new Worker(new URL('./istar-fitter.js', import.meta.url), { type: 'module' });
  started.addEventListener('message', ({ data }: MessageEvent<FittingResult>) => {
    const job = waiting.get(data.id);
    waiting.delete(data.id);
    if ('bytes' in data) job?.resolve(data.bytes);
    else job?.reject(new ViewerError(data.kind, data.message));
    if (waiting.size === 0) endWorker();
  });
  started.addEventListener('error', (event) => {
    event.preventDefault();
    const cause = new ViewerError('unsupported', `The encoder could not be started. ${event.message ?? ''}`);
    for (const job of waiting.values()) job.reject(cause);
    waiting.clear();
    endWorker();
  });
  return started;
}

/** What it took to fit is memory that only its end gives back. */
function endWorker(): void {
  worker?.terminate();
  worker = undefined;
}
