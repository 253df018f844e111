import { ViewerError } from './errors.js';

export interface Progress {
  /** Bytes so far. */
  loaded: number;
  /** Bytes in all, or undefined where that is not known. */
  total: number | undefined;
}

/** Some bytes of a file: fewer than asked for where it ends before. `etag` says which version of the file they are of. */
export interface RangeResponse {
  data: ArrayBuffer;
  etag?: string | undefined;
}

/**
 * Where the bytes of a file come from; as in PMTiles. With an `etag`, bytes of another version are a ViewerError of kind
 * `changed`.
 */
export interface Source {
  getBytes(offset: number, length: number, signal?: AbortSignal, etag?: string): Promise<RangeResponse>;
  getKey(): string;
}

/** Tries in all, and how long to wait before the second, in ms; four times as long before each further one. */
const TRIES = 3;
const FIRST_WAIT = 200;
/** A server that sends nothing for so long is taken for gone, in ms. */
const SILENCE = 30_000;
/** What a server may send that knows no ranges. */
const MOST_WHOLE = 256 * 1024 * 1024;

/** A file on a server: by ranges, or as a whole where the server knows none. */
export class FetchSource implements Source {
  readonly #url: string;
  readonly #credentials: RequestCredentials;
  readonly #onProgress: ((progress: Progress) => void) | undefined;
  #loaded = 0;
  #whole: RangeResponse | undefined;

  constructor(url: string, credentials: RequestCredentials, onProgress?: (progress: Progress) => void) {
    this.#url = url;
    this.#credentials = credentials;
    this.#onProgress = onProgress;
  }

  getKey(): string {
    return this.#url;
  }

  async getBytes(
    offset: number,
    length: number,
    signal?: AbortSignal,
    etag?: string,
  ): Promise<RangeResponse> {
    let isByRange = true;
    for (let tried = 1, wait = FIRST_WAIT; ; tried++, wait *= 4) {
      try {
        return await this.#bytes(offset, length, isByRange, signal, etag);
      } catch (cause) {
        if (!(cause instanceof ViewerError) || !cause.passing || tried === TRIES) throw cause;
        // A server that packs ranges all the same seems not to be there: browsers refuse what it sends.
        isByRange = cause.kind !== 'network' || offset > 0 || tried + 1 < TRIES;
      }
      await pause(wait, signal);
    }
  }

  async #bytes(
    offset: number,
    length: number,
    isByRange: boolean,
    wanted: AbortSignal | undefined,
    etag: string | undefined,
  ): Promise<RangeResponse> {
    const watch = new Watch(wanted);
    try {
      return await this.#heard(offset, length, isByRange, watch, etag);
    } catch (cause) {
      if (!watch.isSilent || wanted?.aborted) throw cause;
      const text = `The server has sent nothing for ${SILENCE / 1000} seconds: ${this.#url}`;
      throw new ViewerError('network', text, cause);
    } finally {
      watch.end();
    }
  }

  async #heard(
    offset: number,
    length: number,
    isByRange: boolean,
    watch: Watch,
    etag: string | undefined,
  ): Promise<RangeResponse> {
    const whole = this.#whole;
    if (whole) return { ...whole, data: whole.data.slice(offset, offset + length) };
    const range = `bytes=${offset}-${offset + length - 1}`;
    const credentials = this.#credentials;
    const ranged = isByRange ? { headers: { range } } : {};
    let response = await request(this.#url, { credentials, ...ranged }, watch);
    // An empty file has no first byte to send, and a shorter one than it was not these.
    if (response.status === 416) return { data: new ArrayBuffer(0) };
    // A range of packed bytes cannot be unpacked.
    if (response.status === 206 && response.headers.has('content-encoding')) {
      response.body?.cancel().catch(() => {});
      response = await request(this.#url, { credentials }, watch);
    }
    const tag = strong(response.headers.get('etag'));
    if (etag && tag && tag !== etag) throw changed();
    if (response.status === 206)
      return { data: await this.#body(response, undefined, length, watch), etag: tag };
    const data = await this.#body(response, announced(response), MOST_WHOLE, watch);
    this.#whole = { data, etag: tag };
    return { data: data.slice(offset, offset + length), etag: tag };
  }

  async #body(
    response: Response,
    total: number | undefined,
    most: number,
    watch: Watch,
  ): Promise<ArrayBuffer> {
    const chunks: Uint8Array[] = [];
    let loaded = 0;
    const tooMuch = () =>
      new ViewerError('limit', `The server sends more than ${sizeText(most)}: it should know ranges.`);
    try {
      if (total !== undefined && total > most) {
        response.body?.cancel().catch(() => {});
        throw tooMuch();
      }
      const reader = response.body?.getReader();
      for (let step = await reader?.read(); step && !step.done; step = await reader?.read()) {
        watch.hear();
        chunks.push(step.value);
        loaded += step.value.length;
        this.#loaded += step.value.length;
        if (loaded > most) {
          reader?.cancel().catch(() => {});
          throw tooMuch();
        }
        // More than was announced means that the announcement was of something else.
        this.#onProgress?.({
          loaded: this.#loaded,
          total: total !== undefined && loaded <= total ? total : undefined,
        });
      }
    } catch (cause) {
      if (watch.signal.aborted) throw aborted(cause);
      if (cause instanceof ViewerError) throw cause;
      const got = total === undefined ? sizeText(loaded) : `${sizeText(loaded)} of ${sizeText(total)}`;
      throw new ViewerError('network', `The connection broke after ${got}.`, cause, true);
    }
    return joined(chunks, loaded);
  }
}

/** A file that the user chose, or bytes that have no name. */
export class FileSource implements Source {
  readonly #file: Blob;

  constructor(file: Blob) {
    this.#file = file;
  }

  getKey(): string {
    return this.#file instanceof File ? this.#file.name : '';
  }

  async getBytes(offset: number, length: number): Promise<RangeResponse> {
    try {
      return { data: await this.#file.slice(offset, offset + length).arrayBuffer() };
    } catch (cause) {
      throw new ViewerError('network', 'The file can no longer be read.', cause);
    }
  }
}

/** A file that is in memory as a whole. */
export class MemorySource implements Source {
  readonly #bytes: Uint8Array;

  constructor(bytes: Uint8Array) {
    this.#bytes = bytes;
  }

  getKey(): string {
    return '';
  }

  async getBytes(offset: number, length: number): Promise<RangeResponse> {
    return { data: this.#bytes.slice(offset, offset + length).buffer as ArrayBuffer };
  }
}

export function changed(): ViewerError {
  return new ViewerError('changed', 'The file changed on the server while it was read.');
}

function aborted(cause: unknown): ViewerError {
  return new ViewerError('aborted', 'Loading was stopped.', cause);
}

async function request(url: string, init: RequestInit, watch: Watch): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(url, { ...init, signal: watch.signal });
    watch.hear();
  } catch (cause) {
    if (watch.signal.aborted) throw aborted(cause);
    // Browsers do not tell one from the other.
    const isOther = new URL(url, location.href).origin !== location.origin;
    const why = isOther ? ' It may not allow other sites to read it (Access-Control-Allow-Origin).' : '';
    throw new ViewerError('network', `The server could not be reached for ${url}.${why}`, cause, true);
  }
  const { ok, status } = response;
  if (ok || status === 416) return response;
  const reason = status === 404 ? 'The server has no such file' : 'The server answered with an error';
  throw new ViewerError('http', `${reason} (${status}): ${url}`, undefined, status >= 500 || status === 429);
}

/** Ends a request that is no longer wanted, or whose server falls silent. */
class Watch {
  isSilent = false;
  readonly #controller = new AbortController();
  readonly #wanted: AbortSignal | undefined;
  #timer: ReturnType<typeof setTimeout> | undefined;
  readonly #stop = () => this.#controller.abort(this.#wanted?.reason);

  constructor(wanted: AbortSignal | undefined) {
    this.#wanted = wanted;
    wanted?.addEventListener('abort', this.#stop);
    if (wanted?.aborted) this.#stop();
    this.hear();
  }

  get signal(): AbortSignal {
    return this.#controller.signal;
  }

  /** Something came. */
  hear(): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => {
      this.isSilent = true;
      this.#controller.abort();
    }, SILENCE);
  }

  end(): void {
    clearTimeout(this.#timer);
    this.#wanted?.removeEventListener('abort', this.#stop);
  }
}

/** A weak tag is the same for other bytes that mean the same. */
function strong(etag: string | null): string | undefined {
  return etag && !etag.startsWith('W/') ? etag : undefined;
}

/** Content-Length counts packed bytes, and what is read here has been unpacked: no use where the two differ. */
function announced(response: Response): number | undefined {
  const length = Number(response.headers.get('content-length'));
  return length > 0 && !response.headers.get('content-encoding') ? length : undefined;
}

function pause(ms: number, signal: AbortSignal | undefined): Promise<void> {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, ms);
    signal?.addEventListener('abort', () => {
      clearTimeout(timer);
      reject(aborted(signal.reason));
    });
  });
}

function joined(chunks: Uint8Array[], length: number): ArrayBuffer {
  const bytes = new Uint8Array(length);
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return bytes.buffer;
}

/** Bytes as people read them: `812 B`, `41.3 KB`, `2.0 MB`. */
export function sizeText(bytes: number): string {
  if (bytes < 1024) return `${bytes} B`;
  if (bytes < 1024 * 1024) return `${(bytes / 1024).toFixed(1)} KB`;
  return `${(bytes / 1024 / 1024).toFixed(1)} MB`;
}
