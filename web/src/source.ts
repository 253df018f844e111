import { ViewerError } from './errors.js';

export interface Progress {
  /** Bytes so far. */
  loaded: number;
  /** Bytes in all, or undefined where the server does not say. */
  total: number | undefined;
}

/** Fetches a whole file. Every way to fail is a ViewerError. */
export async function fetchBytes(
  url: string,
  signal: AbortSignal,
  onProgress: (progress: Progress) => void,
): Promise<Uint8Array> {
  const response = await request(url, signal);
  const announced = announcedLength(response);
  const chunks: Uint8Array[] = [];
  let loaded = 0;
  try {
    const reader = response.body?.getReader();
    for (let step = await reader?.read(); step && !step.done; step = await reader?.read()) {
      chunks.push(step.value);
      loaded += step.value.length;
      // More than was announced means that the announcement was of something else.
      onProgress({ loaded, total: announced !== undefined && loaded <= announced ? announced : undefined });
    }
  } catch (cause) {
    if (signal.aborted) throw aborted(cause);
    const got = announced === undefined ? sizeText(loaded) : `${sizeText(loaded)} of ${sizeText(announced)}`;
    throw new ViewerError('network', `The connection broke after ${got}.`, cause);
  }
  return joined(chunks, loaded);
}

async function request(url: string, signal: AbortSignal): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(url, { signal });
  } catch (cause) {
    if (signal.aborted) throw aborted(cause);
    throw new ViewerError('network', `The server could not be reached for ${url}.`, cause);
  }
  if (!response.ok) {
    const reason =
      response.status === 404 ? 'The server has no such file' : 'The server answered with an error';
    throw new ViewerError('http', `${reason} (${response.status}): ${url}`);
  }
  return response;
}

/** Content-Length counts compressed bytes, and what is read here has been unpacked: no use where the two differ. */
function announcedLength(response: Response): number | undefined {
  const length = Number(response.headers.get('content-length'));
  return length > 0 && !response.headers.get('content-encoding') ? length : undefined;
}

function aborted(cause: unknown): ViewerError {
  return new ViewerError('aborted', 'Loading was stopped.', cause);
}

function joined(chunks: Uint8Array[], length: number): Uint8Array {
  const bytes = new Uint8Array(length);
  let at = 0;
  for (const chunk of chunks) {
    bytes.set(chunk, at);
    at += chunk.length;
  }
  return bytes;
}

/** Bytes as people read them: `812 B`, `41.3 KB`, `2.0 MB`. */
export function sizeText(bytes: number): string {
  if (bytes < 1024) return `${bytes} B`;
  if (bytes < 1024 * 1024) return `${(bytes / 1024).toFixed(1)} KB`;
  return `${(bytes / 1024 / 1024).toFixed(1)} MB`;
}
