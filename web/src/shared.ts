import { ViewerError } from './errors.js';
import { FetchSource, type Progress, type RangeResponse, type Source } from './source.js';

/** Figures of one page open the same file one after the other: what one has got, the next is given for so long. */
const KEEP_MS = 3000;

interface Flight {
  bytes: Promise<RangeResponse>;
  controller: AbortController;
  waiting: number;
}

/** The file at an address, for all figures that show it: what several ask for is fetched once. */
class SharedSource implements Source {
  readonly heard = new Set<(progress: Progress) => void>();
  readonly #source: FetchSource;
  readonly #flights = new Map<string, Flight>();

  constructor(url: string, credentials: RequestCredentials) {
    this.#source = new FetchSource(url, credentials, (progress) => {
      for (const hear of this.heard) hear(progress);
    });
  }

  getKey(): string {
    return this.#source.getKey();
  }

  getBytes(offset: number, length: number, signal?: AbortSignal, etag?: string): Promise<RangeResponse> {
    if (signal?.aborted)
      return Promise.reject(new ViewerError('aborted', 'Loading was stopped.', signal.reason));
    const key = [offset, length, etag].join();
    const flight = this.#flights.get(key) ?? this.#start(key, offset, length, etag);
    flight.waiting++;
    return new Promise((resolve, reject) => {
      // A signal that lives on keeps no bytes.
      const over = new AbortController();
      flight.bytes.then(resolve, reject).finally(() => over.abort());
      const stop = () => {
        reject(new ViewerError('aborted', 'Loading was stopped.', signal?.reason));
        // As long as anybody waits it goes on.
        if (--flight.waiting > 0) return;
        flight.controller.abort();
        this.#end(key, flight);
      };
      signal?.addEventListener('abort', stop, { signal: over.signal });
    });
  }

  #start(key: string, offset: number, length: number, etag: string | undefined): Flight {
    const controller = new AbortController();
    const bytes = this.#source.getBytes(offset, length, controller.signal, etag);
    const flight = { bytes, controller, waiting: 0 };
    this.#flights.set(key, flight);
    const end = () => this.#end(key, flight);
    bytes.then(() => setTimeout(end, KEEP_MS), end);
    return flight;
  }

  #end(key: string, flight: Flight): void {
    if (this.#flights.get(key) === flight) this.#flights.delete(key);
  }
}

/** By whether servers of other sites are told who asks, and the address. */
const sources = new Map<string, SharedSource>();

/** As the page's own address is now: programs change that while tiles are still to come. A link throws at nothing. */
function addressOf(src: string): string {
  return Object.assign(document.createElement('a'), { href: src }).href;
}

/** The file there has changed: whoever asks next is given a source that knows nothing of it. */
export function forgetSource(src: string): void {
  for (const credentials of ['include', 'same-origin']) sources.delete(credentials + addressOf(src));
}

/** The page's one source for an address, as long as somebody has not aborted. Nothing is left of it then. */
export function sharedSource(
  src: string,
  credentials: RequestCredentials,
  signal: AbortSignal,
  hear: (progress: Progress) => void,
): Source {
  const url = addressOf(src);
  const key = credentials + url;
  const source = sources.get(key) ?? new SharedSource(url, credentials);
  sources.set(key, source);
  source.heard.add(hear);
  signal.addEventListener('abort', () => {
    source.heard.delete(hear);
    if (source.heard.size === 0 && sources.get(key) === source) sources.delete(key);
  });
  return source;
}
