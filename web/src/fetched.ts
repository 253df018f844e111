// What the viewer fetches beside its own script. The inlined build takes inlined.ts in its place, which has all of it inside.

/** For programs that keep the module elsewhere: to be set before the first figure is on a page. */
export const settings: { wasmUrl?: string | URL } = {};

// Static literals, each there once: bundlers find and copy the files by them.

export function viewerModule(): Promise<Response> {
  return fetch(settings.wasmUrl ?? new URL('./istar_bg.wasm', import.meta.url));
}

/** For workers, and where styles have regions absorbed: the viewer itself does without. */
export function encoderModule(): Promise<Response> {
  return fetch(new URL('./istar_encoder_bg.wasm', import.meta.url));
}

export function fitterWorker(): Worker {
  return new Worker(new URL('./istar-fitter.js', import.meta.url), { type: 'module' });
}

export function painterWorker(): Worker {
  return new Worker(new URL('./istar-painter.js', import.meta.url), { type: 'module' });
}
