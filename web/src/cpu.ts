// Draws without a GPU. A module of its own, fetched only then: dist/istar-cpu.js.
import type { Camera, Tile } from '#wasm';
import type { RawTile } from './archive.js';
import type { Renderer, Scene } from './engine.js';
import type { ErrorKind } from './errors.js';
import { painterWorker } from './fetched.js';
import type { Centre } from './place.js';

/** What the worker is given: a tile, styles of one, the number of one that is no longer needed, or a view to paint. */
export type PaintJob =
  | (RawTile & { tile: number })
  | { tile: number; first: number; words: Uint32Array }
  | { free: number }
  | { frame: number; tiles: number[]; width: number; height: number; scale: number; centre: Centre };

/** What it says: that it is there, a painted view, or what went wrong. */
export type PaintAnswer =
  | { ready: true }
  | { frame: number; image: ImageBitmap }
  | { kind: ErrorKind; message: string };

interface PaintedScene extends Scene {
  tile: number;
}

interface Waiting {
  resolve: (image: ImageBitmap) => void;
  reject: (cause: unknown) => void;
}

/** One worker a page, which paints one view after the other. */
class CpuRenderer implements Renderer {
  readonly backend = 'cpu';
  readonly ready: Promise<void>;
  readonly #worker = painterWorker();
  readonly #waiting = new Map<number, Waiting>();
  #last = 0;
  #frame: number[] = [];
  #fault: Error | undefined;

  constructor() {
    this.ready = new Promise((resolve, reject) => {
      this.#worker.addEventListener('message', ({ data }: MessageEvent<PaintAnswer>) => {
        if ('ready' in data) resolve();
        else if ('image' in data) {
          this.#waiting.get(data.frame)?.resolve(data.image);
          this.#waiting.delete(data.frame);
        } else reject(this.#stop(data));
      });
      this.#worker.addEventListener('error', (event) => {
        event.preventDefault();
        reject(this.#stop({ kind: 'unsupported', message: 'The painter could not be started.' }));
      });
    });
  }

  upload({ bytes: size }: Tile, raw: RawTile): PaintedScene {
    const tile = ++this.#last;
    // Of its own: what is sent is a whole buffer.
    const bytes = raw.bytes.slice();
    this.#post({ ...raw, tile, bytes }, [bytes.buffer]);
    return { tile, bytes: size, free: () => this.#post({ free: tile }) };
  }

  setStyles({ tile }: PaintedScene, first: number, words: Uint32Array): void {
    this.#post({ tile, first, words });
  }

  place(scene: PaintedScene): void {
    this.#frame.push(scene.tile);
  }

  draw(camera: Camera, _: boolean, step: number, width: number, height: number): Promise<ImageBitmap> {
    const frame = ++this.#last;
    const tiles = this.#frame.splice(0);
    return new Promise((resolve, reject) => {
      if (this.#fault) return reject(this.#fault);
      this.#waiting.set(frame, { resolve, reject });
      this.#post({ frame, tiles, width, height, scale: camera.scale / step, centre: camera.place() });
    });
  }

  #post(job: PaintJob, transfer: Transferable[] = []): void {
    this.#worker.postMessage(job, transfer);
  }

  /** Rust's errors have their kind for a name; so has this one. */
  #stop({ kind, message }: { kind: ErrorKind; message: string }): Error {
    this.#worker.terminate();
    this.#fault ??= Object.assign(new Error(message), { name: kind });
    for (const { reject } of this.#waiting.values()) reject(this.#fault);
    this.#waiting.clear();
    return this.#fault;
  }
}

export async function create(): Promise<Renderer> {
  const renderer = new CpuRenderer();
  await renderer.ready;
  return renderer;
}
