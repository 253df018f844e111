import { Camera, type Renderer } from '#wasm';
import type { PictureFile } from './archive.js';
import { viewerError } from './errors.js';
import { Styles } from './styles.js';
import { type Loaded, Tiles } from './tiles.js';

/** Centre in source pixels; `scale` is CSS pixels of the screen per source pixel. */
export interface Place {
  x: number;
  y: number;
  scale: number;
}

/** In device pixels. */
interface Size {
  width: number;
  height: number;
}

interface Shown {
  tiles: Tiles;
  renderer: Renderer;
  camera: Camera;
  /** What the last frame showed, coarser tiles first. */
  drawn: Loaded[];
  /** The last frame showed all of the view. */
  complete: boolean;
}

export interface ViewHooks {
  /** After every drawn frame; `first` after the first one of a picture. */
  drawn(first: boolean): void;
  failed(cause: unknown): void;
}

/**
 * One figure's canvas and camera. Callers speak CSS pixels, the camera speaks device pixels. Draws at most once a frame, and only
 * after a change.
 */
export class View {
  readonly canvas = document.createElement('canvas');
  readonly styles = new Styles();
  readonly #context = this.canvas.getContext('2d');
  readonly #hooks: ViewHooks;
  readonly #observer: ResizeObserver;
  #size: Size = { width: 0, height: 0 };
  #shown: Shown | undefined;
  /** The view shows all of the picture and goes on doing so when the figure's size changes. */
  #fitted = true;
  #first = true;
  #frame = 0;
  #waiting: { resolve: () => void; reject: (cause: unknown) => void }[] = [];

  constructor(hooks: ViewHooks) {
    this.#hooks = hooks;
    this.#observer = new ResizeObserver((entries) => {
      const entry = entries.at(-1);
      if (entry) this.#resized(deviceSize(entry));
    });
  }

  /** Starts or stops following the figure's size. */
  watch(on: boolean): void {
    this.#observer.disconnect();
    if (!on) return;
    try {
      this.#observer.observe(this.canvas, { box: 'device-pixel-content-box' });
    } catch {
      // Safari lacks this box.
      this.#observer.observe(this.canvas);
    }
  }

  /** Takes ownership of the file. Its tiles are fetched as the view needs them. */
  show(file: PictureFile, renderer: Renderer): void {
    this.clear();
    const tiles = new Tiles(
      file,
      renderer,
      () => this.redraw(),
      (cause) => this.#hooks.failed(cause),
    );
    const camera = new Camera(file.archive.width, file.archive.height);
    this.#shown = { tiles, renderer, camera, drawn: [], complete: false };
    this.#fitted = true;
    this.#first = true;
    this.#applySize();
    this.redraw();
  }

  /** Goes on with another renderer, because the last one lost its device: place and tiles stay. */
  moveTo(renderer: Renderer): void {
    if (!this.#shown) return;
    this.#shown.tiles.moveTo(renderer);
    this.#shown.renderer = renderer;
    this.redraw();
  }

  clear(): void {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    const shown = this.#shown;
    this.#shown = undefined;
    shown?.tiles.free();
    shown?.camera.free();
    this.#context?.clearRect(0, 0, this.canvas.width, this.canvas.height);
  }

  /** A region's colour as 0xRRGGBBAA, where it is in view. */
  regionColor(region: number): number | undefined {
    for (const { tile } of this.#shown?.drawn ?? []) {
      const color = tile.regionColor(region);
      if (color !== undefined) return color;
    }
    return undefined;
  }

  get renderer(): Renderer | undefined {
    return this.#shown?.renderer;
  }

  get fitted(): boolean {
    return this.#fitted;
  }

  /** Device pixels per CSS pixel, page zoom and CSS transforms included. */
  get #ratio(): number {
    const width = this.canvas.getBoundingClientRect().width;
    return width > 0 && this.#size.width > 0 ? this.#size.width / width : devicePixelRatio;
  }

  get place(): Place | undefined {
    const camera = this.#shown?.camera;
    return camera && { x: camera.x, y: camera.y, scale: camera.scale / this.#ratio };
  }

  pan(dx: number, dy: number): void {
    const ratio = this.#ratio;
    this.#move((camera) => camera.pan(dx * ratio, dy * ratio));
  }

  /** Whether the view changed. */
  zoom(factor: number, x: number, y: number): boolean {
    const before = this.#shown?.camera.scale;
    const ratio = this.#ratio;
    this.#move((camera) => camera.zoom(factor, x * ratio, y * ratio));
    return this.#shown?.camera.scale !== before;
  }

  zoomAboutMiddle(factor: number): void {
    this.#move((camera) => camera.zoom(factor, this.#size.width / 2, this.#size.height / 2));
  }

  lookAt(x: number, y: number, scale: number): void {
    this.#move((camera) => camera.lookAt(x, y, scale * this.#ratio));
  }

  fit(): void {
    this.#move((camera) => camera.fit());
    this.#fitted = true;
  }

  /** The region under a place of the browser's window. */
  pick(clientX: number, clientY: number): number | undefined {
    if (!this.#shown) return undefined;
    const { drawn, camera } = this.#shown;
    const box = this.canvas.getBoundingClientRect();
    const ratio = this.#ratio;
    const [x, y] = [(clientX - box.left) * ratio, (clientY - box.top) * ratio];
    // The last to be drawn covers the others.
    for (let i = drawn.length - 1; i >= 0; i--) {
      const region = drawn[i]?.tile.pick(camera, x, y);
      if (region !== undefined) return region;
    }
    return undefined;
  }

  /** The regions within an outline of places of the browser's window, as far as their tiles are there; in ascending order. */
  regionsWithin(outline: Iterable<readonly [clientX: number, clientY: number]>): number[] {
    if (!this.#shown) return [];
    const { drawn, camera } = this.#shown;
    const box = this.canvas.getBoundingClientRect();
    const ratio = this.#ratio;
    const places = Float64Array.from(
      [...outline].flatMap(([x, y]) => [(x - box.left) * ratio, (y - box.top) * ratio]),
    );
    const found = new Set(drawn.flatMap(({ tile }) => [...tile.regionsWithin(camera, places)]));
    return [...found].sort((a, b) => a - b);
  }

  redraw(): void {
    if (this.#frame === 0 && this.#shown) this.#frame = requestAnimationFrame(() => this.#draw());
  }

  /** Resolves when the canvas shows the current view, with all of its tiles. */
  settled(): Promise<void> {
    if (this.#shown?.complete && this.#frame === 0 && !this.#first) return Promise.resolve();
    return new Promise((resolve, reject) => {
      this.#waiting.push({ resolve, reject });
    });
  }

  /** There will be no frame to wait for. */
  giveUp(cause: unknown): void {
    for (const { reject } of this.#waiting.splice(0)) reject(cause);
  }

  #move(change: (camera: Camera) => void): void {
    if (!this.#shown) return;
    this.#fitted = false;
    this.#shown.complete = false;
    change(this.#shown.camera);
    this.redraw();
  }

  #resized(size: Size): void {
    if (size.width === this.#size.width && size.height === this.#size.height) return;
    this.#size = size;
    this.#applySize();
    // Drawn at once: waiting for the next frame would show a stretched one.
    this.#draw();
  }

  #applySize(): void {
    const { width, height } = this.#size;
    if (!this.#shown || width === 0 || height === 0) return;
    this.#shown.camera.resize(width, height);
    if (this.#fitted) this.#shown.camera.fit();
  }

  #draw(): void {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    const { width, height } = this.#size;
    // A hidden figure has no size, and is drawn when it gets one.
    if (!this.#shown || !this.#context || width === 0 || height === 0) return;
    const shown = this.#shown;
    const { renderer, camera } = shown;
    try {
      const { tiles, complete } = shown.tiles.frame(camera);
      // It may have failed, and all that is shown with it.
      if (this.#shown !== shown) return;
      Object.assign(shown, { drawn: tiles, complete });
      if (tiles.length === 0) return;
      for (const loaded of tiles) {
        this.styles.apply(loaded, renderer, this.#ratio);
        renderer.place(loaded.scene, loaded.tile);
      }
      renderer.draw(camera);
      if (this.canvas.width !== width || this.canvas.height !== height)
        Object.assign(this.canvas, this.#size);
      this.#context.clearRect(0, 0, width, height);
      // In the same task as the drawing: the renderer's canvas belongs to the next figure after it.
      this.#context.drawImage(renderer.canvas, 0, 0, width, height, 0, 0, width, height);
    } catch (cause) {
      shown.complete = false;
      this.#hooks.failed(viewerError(cause, 'gpu'));
      return;
    }
    const first = this.#first;
    this.#first = false;
    this.#hooks.drawn(first);
    if (shown.complete) for (const { resolve } of this.#waiting.splice(0)) resolve();
  }
}

function deviceSize({ contentRect, devicePixelContentBoxSize }: ResizeObserverEntry): Size {
  const width = contentRect.width * devicePixelRatio;
  const height = contentRect.height * devicePixelRatio;
  const exact = devicePixelContentBoxSize?.[0];
  // The exact box says how the browser rounded. Chromium forgets the pixel ratio in it where it emulates a phone.
  if (exact && Math.abs(exact.inlineSize - width) < 1 && Math.abs(exact.blockSize - height) < 1) {
    return { width: exact.inlineSize, height: exact.blockSize };
  }
  return { width: Math.round(width), height: Math.round(height) };
}
