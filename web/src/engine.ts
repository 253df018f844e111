import init, { type Camera, type Tile } from '#wasm';
import { PictureFile, type RawTile } from './archive.js';
import type { Backend, BackendChoice } from './backend.js';
import { ViewerError, viewerError } from './errors.js';
import { viewerModule } from './fetched.js';
import { fetchShaders, takeGpu } from './gpu.js';
import type { Size } from './screen.js';
import type { Source } from './source.js';

/** A tile where it is drawn. */
export interface Scene {
  /** What it takes of memory, the GPU's or that of a worker. */
  readonly bytes: number;
  free(): void;
}

/** What draws: the module's own on a GPU, or that of cpu.ts. */
export interface Renderer {
  readonly backend: Backend;
  /** What `draw` has painted, where it returns nothing: to be copied in the same task. */
  readonly canvas?: OffscreenCanvas;
  upload(tile: Tile, raw: RawTile): Scene;
  /** Gives regions of a tile from its `first` on other styles: four words each, as src/style.rs has them. */
  setStyles(scene: Scene, first: number, words: Uint32Array): void;
  place(scene: Scene, tile: Tile): void;
  /**
   * Draws what was placed since the last frame in a part of the camera's viewport: in so many pixels, each of which stands for `step` of
   * the viewport's along each axis. A quick frame may be a little blurred.
   */
  draw(
    camera: Camera,
    quick: boolean,
    step: number,
    x: number,
    y: number,
    width: number,
    height: number,
    viewport: Size,
    // biome-ignore lint/suspicious/noConfusingVoidType: what wasm returns.
  ): Promise<ImageBitmap> | void;
}

let module: Promise<void> | undefined;
const renderers = new Map<BackendChoice, Promise<Renderer>>();

/** The page's one renderer for that choice: many figures share one device. */
export async function sharedRenderer(choice: BackendChoice): Promise<Renderer> {
  let renderer = renderers.get(choice);
  if (!renderer) {
    if (choice !== 'cpu') fetchShaders(choice);
    renderer = loadModule().then(() => create(choice));
    renderers.set(choice, renderer);
    renderer.catch(() => renderers.delete(choice));
  }
  try {
    return await renderer;
  } catch (cause) {
    throw viewerError(cause, 'gpu');
  }
}

/** WebGPU, else WebGL2, else a worker, as far as the choice is free. */
async function create(choice: BackendChoice): Promise<Renderer> {
  // Fetched only where it is needed.
  const cpu = async () => (await import('./cpu.js')).create();
  if (choice === 'cpu') return cpu();
  return takeGpu(choice).catch((cause) => {
    const fault = () => Promise.reject(cause);
    return choice === 'auto' ? cpu().catch(fault) : fault();
  });
}

/** Called when a renderer fails, so that the next try starts with a new device. Other figures may still hold the old one. */
export async function dropRenderer(failed: Renderer): Promise<void> {
  for (const [choice, renderer] of renderers) {
    if ((await renderer.catch(() => undefined)) === failed) renderers.delete(choice);
  }
}

/** Reads the head of a file, while the module is on its way. */
export async function openFile(source: Source, signal: AbortSignal): Promise<PictureFile> {
  await loadModule();
  return PictureFile.open(source, signal);
}

/** A failed load is forgotten, so that a retry fetches again. */
function loadModule(): Promise<void> {
  module ??= instantiate().catch((cause) => {
    module = undefined;
    throw cause;
  });
  return module;
}

async function instantiate(): Promise<void> {
  let response: Response;
  try {
    response = await viewerModule();
  } catch (cause) {
    throw new ViewerError('network', 'The viewer itself could not be fetched.', cause);
  }
  if (!response.ok)
    throw new ViewerError('http', `The viewer itself could not be fetched (${response.status}).`);
  try {
    await init({ module_or_path: response });
  } catch (cause) {
    throw new ViewerError('unsupported', 'This browser could not start the viewer (WebAssembly).', cause);
  }
}
