// Draws without a GPU. A module of its own, fetched only then: dist/istar-cpu.js.
import { Frame, initSync, PaintedTile } from '#encoder';
import type { Camera, Tile } from '#wasm';
import type { RawTile } from './archive.js';
import type { Renderer, Scene } from './engine.js';
import type { ErrorKind } from './errors.js';
import { painterWorker } from './fetched.js';
import type { Size } from './screen.js';

/** What the worker is given: a tile, styles of one, the number of one that is no longer needed, or a part of a view to paint. */
export type PaintJob =
  | (RawTile & { tile: number })
  | { tile: number; first: number; words: Uint32Array }
  | { free: number }
  | { frame: number; tiles: number[]; args: FrameArgs };

/** What a frame of the painter is made with. */
type FrameArgs = ConstructorParameters<typeof Frame>;

/** What it says: that it is there, and the module that it has compiled, a painted view, or what went wrong. */
export type PaintAnswer =
  | { ready: true; module: WebAssembly.Module | undefined }
  | { frame: number; image: ImageBitmap }
  | { kind: ErrorKind; message: string };

interface PaintedScene extends Scene {
  tile: number;
  raw: RawTile;
  /** All styles that it was given. */
  words: Uint32Array | undefined;
}

interface Waiting {
  resolve: (image: ImageBitmap) => void;
  reject: (cause: unknown) => void;
}

/** So many pixels for paper are painted at a time. */
const AT_ONCE = 1024 * 1024;

/**
 * One worker a page, which paints one view after the other. Paper waits for nobody: what is drawn for it is painted here, with what the
 * worker has compiled.
 */
class CpuRenderer implements Renderer {
  readonly backend = 'cpu';
  readonly ready: Promise<void>;
  readonly #worker = painterWorker();
  readonly #waiting = new Map<number, Waiting>();
  #last = 0;
  #frame: PaintedScene[] = [];
  /** What was painted for paper, until it is copied. */
  canvas?: OffscreenCanvas;
  #module: WebAssembly.Module | undefined;
  #isStarted = false;
  #fault: Error | undefined;

  constructor() {
    this.ready = new Promise((resolve, reject) => {
      this.#worker.addEventListener('message', ({ data }: MessageEvent<PaintAnswer>) => {
        if ('ready' in data) {
          this.#module = data.module;
          resolve();
        } else if ('image' in data) {
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
    return { tile, raw, words: undefined, bytes: size, free: () => this.#post({ free: tile }) };
  }

  setStyles(scene: PaintedScene, first: number, words: Uint32Array): void {
    // The first time they are those of all regions.
    if (scene.words) scene.words.set(words, 4 * first);
    else scene.words = words.slice();
    this.#post({ tile: scene.tile, first, words });
  }

  place(scene: PaintedScene): void {
    this.#frame.push(scene);
  }

  draw(
    camera: Camera,
    _quick: boolean,
    step: number,
    x: number,
    y: number,
    width: number,
    height: number,
    viewport: Size,
    // biome-ignore lint/suspicious/noConfusingVoidType: as its interface has it.
  ): Promise<ImageBitmap> | void {
    const frame = ++this.#last;
    const rows = (first: number, high: number): FrameArgs => [
      x,
      y + first * step,
      width,
      high,
      step,
      viewport.width,
      viewport.height,
      camera.scale,
      ...camera.place(),
    ];
    const scenes = this.#frame.splice(0);
    // Told by the event that is being dealt with: a listener of its own would hear of it after the figures.
    if (window.event?.type === 'beforeprint' && this.#module && !this.#fault)
      return this.#paintNow(this.#module, scenes, rows, width, height);
    const tiles = scenes.map(({ tile }) => tile);
    return new Promise((resolve, reject) => {
      if (this.#fault) return reject(this.#fault);
      this.#waiting.set(frame, { resolve, reject });
      this.#post({ frame, tiles, args: rows(0, height) });
    });
  }

  /** In strips, so that no more than the picture itself is held. */
  #paintNow(
    module: WebAssembly.Module,
    scenes: PaintedScene[],
    rows: (first: number, high: number) => FrameArgs,
    width: number,
    height: number,
  ): void {
    if (!this.#isStarted) initSync({ module });
    this.#isStarted = true;
    const canvas = new OffscreenCanvas(width, height);
    this.canvas = canvas;
    queueMicrotask(() => {
      delete this.canvas;
    });
    const context = canvas.getContext('2d');
    if (!context) return;
    const tiles: PaintedTile[] = [];
    try {
      for (const { raw, words } of scenes) {
        const tile = PaintedTile.read(raw.head, raw.level, raw.x, raw.y, raw.bytes);
        tiles.push(tile);
        if (words) tile.setStyles(0, words);
      }
      const most = Math.max(1, Math.floor(AT_ONCE / width));
      for (let first = 0; first < height; first += most) {
        const high = Math.min(most, height - first);
        const frame = new Frame(...rows(first, high));
        for (const tile of tiles) frame.paint(tile);
        context.putImageData(new ImageData(new Uint8ClampedArray(frame.pixels()), width, high), 0, first);
      }
    } finally {
      for (const tile of tiles) tile.free();
    }
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
