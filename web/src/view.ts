import { Camera } from '#wasm';
import type { PictureFile } from './archive.js';
import type { Renderer } from './engine.js';
import { ViewerError, viewerError } from './errors.js';
import { Pace } from './pace.js';
import { type Place, placeText, readPlace } from './place.js';
import { coarser, type Plan, Screen, type Size } from './screen.js';
import { Styles } from './styles.js';
import { type Loaded, Tiles } from './tiles.js';

interface Shown {
  tiles: Tiles;
  /** Gives back what the view has. */
  end: () => void;
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
  readonly styles: Styles;
  readonly #hooks: ViewHooks;
  readonly #observer: ResizeObserver;
  #size: Size = { width: 0, height: 0 };
  /** Pixels for a CSS pixel, where it is not the screen's. */
  readonly #fineness: number | undefined;
  /** Views of the same picture, which go with it. */
  readonly #twins = new Set<View>();
  #shown: Shown | undefined;
  /** The view shows all of the picture and goes on doing so when the figure's size changes. */
  #fitted = true;
  #first = true;
  #frame = 0;
  readonly #redraw = () => this.redraw();
  readonly #redrawAll = () => {
    this.#screen.forget();
    this.redraw();
  };
  readonly #pace = new Pace(this.#redraw);
  readonly #screen = new Screen();
  readonly canvas = this.#screen.canvas;
  /** What a worker paints now, and whether another frame is due after it. */
  #painting: 'nothing' | 'frame' | 'stale' = 'nothing';
  #inSight = true;
  readonly #sight: IntersectionObserver;
  /** What drags still have to move it. */
  #due = [0, 0] as [number, number];
  #waiting: { resolve: () => void; reject: (cause: unknown) => void }[] = [];

  constructor(hooks: ViewHooks, styles = new Styles(), fineness?: number) {
    this.#hooks = hooks;
    this.styles = styles;
    this.#fineness = fineness;
    // A canvas, too, may lose what is on it.
    this.canvas.addEventListener('contextrestored', this.#redrawAll);
    this.#observer = new ResizeObserver((entries) => {
      const entry = entries.at(-1);
      if (entry) this.#resized(deviceSize(entry));
    });
    this.#sight = new IntersectionObserver((entries) => {
      const wasInSight = this.#inSight;
      this.#inSight = entries.at(-1)?.isIntersecting ?? true;
      if (!wasInSight) this.redraw();
    });
  }

  /** Starts or stops following the figure's size. */
  watch(on: boolean): void {
    this.#observer.disconnect();
    this.#sight.disconnect();
    this.#inSight = true;
    if (!on) return;
    this.#sight.observe(this.canvas);
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
    const changed = () => {
      this.redraw();
      for (const twin of this.#twins) if (!twin.#shown?.complete) twin.redraw();
    };
    const tiles = new Tiles(file, renderer, changed, (cause) => this.#hooks.failed(cause));
    this.#begin(tiles, renderer, () => tiles.free());
    this.watch(true);
    this.#listen('add', renderer);
  }

  /**
   * Another view of the same picture, with a canvas of its own, until it or this one is cleared. With a size it has so many pixels,
   * shows the same place, unless `place` moves it, and is drawn at once; else it shows all of the picture in the size that its
   * canvas has on the page.
   */
  twin(size?: Size, fineness?: number, place?: (twin: View) => void): View | undefined {
    const shown = this.#shown;
    if (!shown) return undefined;
    // What goes wrong here goes wrong with the view itself.
    const twin: View = new View({ drawn() {}, failed: (cause) => twin.giveUp(cause) }, this.styles, fineness);
    this.#twins.add(twin);
    twin.#begin(shown.tiles, shown.renderer, () => {
      this.#twins.delete(twin);
      shown.tiles.forget(twin);
      twin.watch(false);
      twin.canvas.remove();
      twin.giveUp(new ViewerError('aborted', 'The picture is gone.'));
    });
    if (size) {
      twin.#shown?.camera.resize(size.width, size.height);
      twin.text = this.text;
      place?.(twin);
      twin.#resized(size);
    } else twin.watch(true);
    return twin;
  }

  #begin(tiles: Tiles, renderer: Renderer, end: () => void): void {
    const { width, height } = tiles.file.archive;
    const camera = new Camera(width, height);
    this.#shown = { tiles, renderer, camera, end, drawn: [], complete: false };
    this.#fitted = true;
    this.#first = true;
    // The figure may take another shape for this picture. Its size is told anew, and with that it is drawn.
    this.#size = { width: 0, height: 0 };
  }

  /** Goes on with another renderer, because the last one lost its device: place and tiles stay. */
  moveTo(renderer: Renderer): void {
    if (!this.#shown) return;
    this.#listen('remove', this.#shown.renderer);
    this.#listen('add', renderer);
    this.#shown.tiles.moveTo(renderer);
    for (const view of [this, ...this.#twins]) {
      if (view.#shown) view.#shown.renderer = renderer;
      view.redraw();
    }
  }

  /** A renderer that lost its device tells so by its canvas; what is drawn next finds it out. */
  #listen(how: 'add' | 'remove', renderer: Renderer): void {
    renderer.canvas?.[`${how}EventListener`]('webglcontextlost', this.#redrawAll);
  }

  clear(): void {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    const shown = this.#shown;
    this.#shown = undefined;
    if (shown) this.#listen('remove', shown.renderer);
    for (const twin of this.#twins) twin.clear();
    shown?.end();
    shown?.camera.free();
    this.#screen.clear();
  }

  /** A region's colour as 0xRRGGBBAA, where it is in view. */
  regionColor(region: number): number | undefined {
    for (const { tile } of this.#shown?.drawn ?? []) {
      const color = tile.regionColor(region);
      if (color !== undefined) return color;
    }
    return undefined;
  }

  /** The regions of the last frame's tiles, in ascending order. */
  get regions(): number[] {
    const told = this.drawn.flatMap(({ tile }) => {
      // Their colours come after them.
      const words = tile.regions();
      return [...words.subarray(0, words.length / 2)];
    });
    return ascending(told);
  }

  /** The tiles of the last frame. */
  get drawn(): Loaded[] {
    return this.#shown?.drawn ?? [];
  }

  get file(): PictureFile | undefined {
    return this.#shown?.tiles.file;
  }

  get tiles(): Tiles | undefined {
    return this.#shown?.tiles;
  }

  get renderer(): Renderer | undefined {
    return this.#shown?.renderer;
  }

  get fitted(): boolean {
    return this.#fitted;
  }

  /** Device pixels per CSS pixel, page zoom and CSS transforms included. */
  get #ratio(): number {
    if (this.#fineness) return this.#fineness;
    const width = this.canvas.getBoundingClientRect().width;
    return width > 0 && this.#size.width > 0 ? this.#size.width / width : devicePixelRatio;
  }

  get place(): Place | undefined {
    const camera = this.#shown?.camera;
    if (!camera) return undefined;
    const [x, y, moreX, moreY, rotation, flipped] = camera.place();
    return { x: x + moreX, y: y + moreY, scale: camera.scale / this.#ratio, rotation, flipped: flipped > 0 };
  }

  /** The place with every digit; empty where there is none. */
  get text(): string {
    const camera = this.#shown?.camera;
    return camera ? placeText(camera.place(), camera.scale / this.#ratio) : '';
  }

  /** Nothing happens where it is no such text. */
  set text(text: string) {
    const [centre, scale] = readPlace(text) ?? [];
    if (!centre || !scale) return;
    const [x, y, moreX, moreY, rotation, flipped] = centre;
    this.turn(rotation, flipped > 0);
    // About whatever that was: all else is said here.
    this.lookAt(x, y, scale, moreX, moreY);
  }

  pan(dx: number, dy: number): void {
    const ratio = this.#ratio;
    this.#move((camera) => camera.pan(dx * ratio, dy * ratio));
  }

  /** The same by whole device pixels, never more than half of one beside: what is drawn is moved then. */
  drag(dx: number, dy: number): void {
    const ratio = this.#ratio;
    const [x, y] = [this.#due[0] + dx * ratio, this.#due[1] + dy * ratio];
    const [right, down] = [Math.round(x), Math.round(y)];
    this.#due = [x - right, y - down];
    this.#move((camera) => camera.pan(right, down));
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

  /** Shows a box of CSS pixels as large as it goes. */
  zoomInto(left: number, top: number, width: number, height: number): void {
    const ratio = this.#ratio;
    const factor = Math.min(this.#size.width / width, this.#size.height / height) / ratio;
    this.pan(
      this.#size.width / ratio / 2 - left - width / 2,
      this.#size.height / ratio / 2 - top - height / 2,
    );
    this.zoomAboutMiddle(factor);
  }

  lookAt(x: number, y: number, scale: number, moreX = 0, moreY = 0): void {
    this.#move((camera) => camera.lookAt(x, y, scale * this.#ratio, moreX, moreY));
  }

  /**
   * Mirrors the picture or not and turns it, clockwise from where it was at first: about a place of the canvas, else about the middle, where
   * a view of all of the picture goes on to be one.
   */
  turn(rotation: number, flipped: boolean, at?: { x: number; y: number }): void {
    const isFitted = this.#fitted && !at;
    const { width, height } = this.#size;
    const ratio = this.#ratio;
    this.#move((camera) =>
      camera.turn(rotation, flipped, at ? at.x * ratio : width / 2, at ? at.y * ratio : height / 2),
    );
    if (isFitted) this.fit();
  }

  /** Turns the picture further. */
  turnBy(degrees: number, at?: { x: number; y: number }): void {
    const { place } = this;
    if (place) this.turn(place.rotation + degrees, place.flipped, at);
  }

  /** Mirrors what is seen, left to right. */
  flip(): void {
    const { place } = this;
    if (place) this.turn(-place.rotation, !place.flipped);
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
      if (region !== undefined) return this.styles.absorbed.get(region) ?? region;
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
    const found = drawn.flatMap(({ tile }) => [...tile.regionsWithin(camera, places)]);
    const { absorbed } = this.styles;
    return ascending(found.map((region) => absorbed.get(region) ?? region));
  }

  redraw(): void {
    if (this.#frame === 0 && this.#shown) this.#frame = requestAnimationFrame(() => this.#draw());
  }

  /** Resolves when the canvas shows the current view, with all of its tiles. */
  settled(): Promise<void> {
    if (this.#shown?.complete && this.#frame === 0 && this.#painting === 'nothing') return Promise.resolve();
    return new Promise((resolve, reject) => {
      this.#waiting.push({ resolve, reject });
      // It may be out of sight.
      this.redraw();
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
    this.#pace.moved();
    this.redraw();
  }

  #resized(size: Size): void {
    if (size.width === this.#size.width && size.height === this.#size.height) return;
    this.#size = size;
    const { width, height } = size;
    if (this.#shown && width > 0 && height > 0) {
      this.#shown.camera.resize(width, height);
      if (this.#fitted) this.#shown.camera.fit();
    }
    // Drawn at once: waiting for the next frame would show a stretched one.
    this.#draw();
  }

  #draw(): void {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
    const { width, height } = this.#size;
    // A hidden figure has no size, and is drawn when it gets one.
    if (!this.#shown || width === 0 || height === 0) return;
    const shown = this.#shown;
    shown.complete = false;
    // Out of sight nothing is drawn but what somebody waits for.
    if (!this.#inSight && !this.#first && this.#waiting.length === 0) return;
    if (this.#painting !== 'nothing') {
      this.#painting = 'stale';
      return;
    }
    let plan: Plan | undefined;
    let later: Promise<ImageBitmap>[] = [];
    try {
      plan = this.#plan(shown);
      if (!plan) return;
      later = this.#drawParts(shown, plan);
    } catch (cause) {
      this.#fail(shown, cause);
      return;
    }
    if (later.length > 0) this.#paintLater(shown, plan, later);
    else this.#painted(shown);
  }

  /** What the next frame is made of; nothing where there is nothing to show. */
  #plan(shown: Shown): Plan | undefined {
    const { renderer, camera } = shown;
    const { tiles, complete } = shown.tiles.frame(camera, this);
    // It may have failed, and all that is shown with it.
    if (this.#shown !== shown) return undefined;
    shown.drawn = tiles;
    if (tiles.length === 0) return undefined;
    const step = this.#fineness ? 1 : this.#pace.next();
    const isQuick = !this.#fineness && this.#pace.isQuick;
    const ratio = this.#ratio;
    const of = [renderer, this.styles.version, ratio];
    const plan = this.#screen.plan(this.#size, camera, of, complete, step, isQuick);
    for (const loaded of tiles)
      if (loaded.scene) this.styles.apply(loaded, loaded.scene, renderer, ratio / plan.step, shown.tiles);
    const { unready } = this.styles;
    unready?.then(this.#redraw);
    // A quick frame is followed by a sharp one, and so is one of fewer pixels.
    shown.complete = complete && plan.step === 1 && !plan.quick && !unready;
    return plan;
  }

  /** Draws what a plan lacks; what a worker draws of it comes later. */
  #drawParts({ renderer, camera, drawn }: Shown, plan: Plan): Promise<ImageBitmap>[] {
    const later: Promise<ImageBitmap>[] = [];
    const { quick, step } = plan;
    for (const part of plan.parts) {
      for (const { tile, scene } of drawn) if (scene) renderer.place(scene, tile);
      const { width, height } = coarser(part, step);
      const image = renderer.draw(camera, quick, step, part.x, part.y, width, height, plan);
      if (image) later.push(image);
      else if (renderer.canvas) {
        if (part === plan.parts[0]) this.#screen.begin(plan);
        // In the same task as the drawing: the renderer's canvas belongs to the next part or figure after it.
        this.#screen.copy(plan, part, renderer.canvas);
      }
    }
    return later;
  }

  async #paintLater(shown: Shown, plan: Plan, later: Promise<ImageBitmap>[]): Promise<void> {
    this.#painting = 'frame';
    const images = await Promise.all(later).catch((cause) => cause);
    const isStale = this.#painting !== 'frame';
    this.#painting = 'nothing';
    const isDrawn = Array.isArray(images);
    if (this.#shown === shown) {
      if (isDrawn) {
        this.#screen.begin(plan);
        for (const [i, part] of plan.parts.entries()) this.#screen.copy(plan, part, images[i]);
        this.#painted(shown);
      } else this.#fail(shown, images);
    }
    // Else their memory waits for the garbage collector.
    if (isDrawn) for (const image of images) image.close();
    if (isStale) this.redraw();
  }

  #painted(shown: Shown): void {
    this.#pace.drawn();
    const first = this.#first;
    this.#first = false;
    this.#hooks.drawn(first);
    if (shown.complete) for (const { resolve } of this.#waiting.splice(0)) resolve();
  }

  #fail(shown: Shown, cause: unknown): void {
    shown.complete = false;
    this.#screen.forget();
    this.#hooks.failed(viewerError(cause, 'gpu'));
  }
}

/** Each once. */
function ascending(numbers: number[]): number[] {
  return [...new Set(numbers)].sort((a, b) => a - b);
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
