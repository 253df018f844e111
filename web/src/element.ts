import { type Backend, chosenBackend } from './backend.js';
import { make, sheetOf } from './dom.js';
import css from './element.css';
import { dropRenderer, openFile, type Renderer, sharedRenderer } from './engine.js';
import { viewerError } from './errors.js';
import type { NamedRegion, ViewerElement, ViewerEvents } from './events.js';
import { Frames } from './frames.js';
import { listenForGestures } from './gestures.js';
import { Hash } from './hash.js';
import { Hover } from './hover.js';
import { listenForKeys } from './keyboard.js';
import { Message } from './message.js';
import { FetchSource } from './source.js';
import { Status } from './status.js';
import type { Style, StyleSheet } from './style.js';
import { View } from './view.js';
import { listenForWheel } from './wheel.js';

// A server that renders pages imports this too, and has no HTMLElement.
const Base = (globalThis.HTMLElement ?? class {}) as new () => ViewerElement;

/** One sheet for all figures. */
let sheet: CSSStyleSheet | undefined;

/**
 * `<istar-viewer src="map.istar" alt="…">`: shows a picture to pan and zoom. An `<img>` inside stands in until the first frame.
 * Coordinates are source pixels, y downwards; scale is CSS pixels per source pixel.
 *
 * @tag istar-viewer
 *
 * @attr {string} src - where the picture is
 * @attr {string} alt - what the picture shows, in words
 * @attr {boolean} interactive - the region under the pointer is highlighted
 * @attr {string} hash - the view is kept in the page's address, as `#view=x,y,scale` or under the name that is given
 * @attr {'webgpu' | 'webgl2' | 'cpu'} backend - what draws; else the first that works
 *
 * @fires {CustomEvent} load - the first frame is painted
 * @fires {CustomEvent} progress - bytes have come: `loaded`, and `total` where it is known
 * @fires {CustomEvent} error - there is no picture: `kind` and `message` say why
 * @fires {CustomEvent} viewchange - another view is painted: `x`, `y`, `scale`
 * @fires {CustomEvent} regionenter - the pointer is on a region: `region`, and `name` where the file has one
 * @fires {CustomEvent} regionleave - the pointer has left a region
 * @fires {CustomEvent} regionclick - a region was clicked or tapped
 *
 * @slot - what stands in until the picture is there, and where scripts do not run: an `<img>`
 *
 * @cssprop --istar-ink - text
 * @cssprop --istar-paper - what lies under text
 * @cssprop --istar-line - thin lines
 * @cssprop --istar-accent - what can be pressed, and progress
 */
export class IStarViewer extends Base {
  static readonly observedAttributes = ['src', 'alt', 'backend', 'hash'];

  #view!: View;
  #stage!: HTMLElement;
  #fallback!: HTMLElement;
  #frames = new Frames();
  #status!: Status;
  #message!: Message;
  #hover!: Hover;
  #hash: Hash;
  #loading: AbortController | undefined;
  #open = false;
  #backend: Backend | undefined;
  /** The view that was told of last. */
  #sent = '';
  /** The first frame of the picture is there. */
  #shown = false;
  /** The file changed while it was read, and is read once more. */
  #again = false;
  /** The device was lost: a new one is awaited, or there and yet to draw a frame. */
  #lost: 'no' | 'waiting' | 'replaced' = 'no';

  constructor() {
    super();
    this.#view = new View({
      drawn: (first) => this.#drawn(first),
      failed: (cause) => this.#fail(cause),
    });
    this.#hash = new Hash(
      () => (this.#view.fitted ? '' : this.#view.text),
      (text) => {
        this.place = text;
      },
    );
    this.#fallback = make('slot', '');
    this.#stage = make('div', 'stage', this.#view.canvas);
    this.#stage.tabIndex = 0;
    this.#stage.role = 'application';
    this.#stage.ariaRoleDescription = 'zoomable picture';
    this.#status = new Status();
    this.#message = new Message(() => {
      // The button is about to go, and would take the focus with it.
      this.#stage.focus();
      this.#load();
    });
    const root = this.attachShadow({ mode: 'open' });
    sheet ??= sheetOf(css);
    root.adoptedStyleSheets = [sheet];
    root.append(this.#fallback, this.#stage, this.#status.root, this.#message.root);
    this.#listen();
    // What a page said before the element was defined lies over its properties.
    for (const [name, value] of Object.entries(this)) {
      Reflect.deleteProperty(this, name);
      if (value !== undefined) Reflect.set(this, name, value);
    }
  }

  get src(): string {
    return this.getAttribute('src') ?? '';
  }

  set src(url: string) {
    this.setAttribute('src', url);
  }

  /** What draws, once it is known. */
  get backend(): Backend | undefined {
    return this.#backend;
  }

  /** Resolves when the canvas shows the current view; while loading, after the first frame. */
  get painted(): Promise<void> {
    return this.#view.settled();
  }

  /** Centre in source pixels; scale is CSS pixels per source pixel. */
  zoomTo(x: number, y: number, scale: number): void {
    this.#still(() => this.#view.lookAt(x, y, scale));
  }

  /** The view as text, `x,y,scale`, with every digit: what it is set to is shown exactly so. Empty while there is no picture. */
  get place(): string {
    return this.#view.text;
  }

  set place(text: string) {
    this.#still(() => {
      this.#view.text = text;
    });
  }

  /** Shows all of the picture. */
  fit(): void {
    this.#still(() => this.#view.fit());
  }

  /** The region under a place of the browser's window (an event's clientX and clientY), undefined beside the picture. */
  pick(clientX: number, clientY: number): number | undefined {
    return this.#view.pick(clientX, clientY);
  }

  /** What the file calls regions, by their colour in it as 0xRRGGBBAA. */
  get names(): Promise<ReadonlyMap<number, string>> {
    return this.#view.file?.named ?? Promise.resolve(new Map());
  }

  /** What a region in view is called, where the file says so. */
  regionName(region: number): string | undefined {
    return this.#view.file?.names.get(this.#view.regionColor(region) ?? -1);
  }

  /**
   * The regions within an outline, a box or a lasso: places of the browser's window, closed by itself. In ascending order; those
   * of tiles that are not there yet are missing.
   */
  regionsWithin(outline: Iterable<readonly [clientX: number, clientY: number]>): number[] {
    return this.#view.regionsWithin(outline);
  }

  /** Gives a region, or several, a style in place of the one they had; null takes it away. */
  setStyle(regions: number | Iterable<number>, style: Style | null): void {
    this.#view.styles.set(typeof regions === 'number' ? [regions] : regions, style);
    this.#view.redraw();
  }

  /** All that `setStyle` has set, and styles for all regions and for colours: plain data, to be saved and set again. */
  get styles(): StyleSheet {
    return this.#view.styles.sheet;
  }

  set styles(sheet: StyleSheet) {
    this.#view.styles.sheet = sheet;
    this.#view.redraw();
  }

  /** The current view as a PNG. */
  async toBlob(): Promise<Blob> {
    await this.painted;
    return new Promise((resolve, reject) => {
      this.#view.canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error('The view is empty.'))));
    });
  }

  connectedCallback(): void {
    if (this.#open) return;
    this.#open = true;
    this.#label();
    this.#hash.follow(this.getAttribute('hash'));
    this.#load();
  }

  disconnectedCallback(): void {
    // An element that is only moved is back by then, and keeps its picture.
    queueMicrotask(() => {
      if (this.isConnected) return;
      this.#open = false;
      this.#loading?.abort();
      this.#frames.stop();
      this.#view.watch(false);
      this.#hash.follow(null);
      this.#close();
    });
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (!this.#open || before === now) return;
    if (name === 'alt') this.#label();
    else if (name === 'hash') {
      this.#hash.follow(now);
      this.#hash.read();
    } else {
      if (name === 'src' && this.#shown) this.#hash.forget();
      this.#load();
    }
  }

  async #load(): Promise<void> {
    this.#again = false;
    this.#loading?.abort();
    this.#close();
    if (!this.src) return;
    const loading = new AbortController();
    this.#loading = loading;
    this.#message.loading({ loaded: 0, total: undefined });
    let ready: Renderer | undefined;
    try {
      // The renderer starts while the file is on its way. Its error is heard below, also when the file fails first.
      const renderer = sharedRenderer(chosenBackend(this.getAttribute('backend')));
      renderer.catch(() => {});
      const source = new FetchSource(this.src, (progress) => {
        if (loading.signal.aborted || this.#shown) return;
        this.#message.loading(progress);
        this.#emit('progress', progress);
      });
      const file = await openFile(source, loading.signal);
      ready = await renderer.catch((cause) => {
        file.free();
        throw cause;
      });
      if (loading.signal.aborted) {
        file.free();
        return;
      }
      this.#backend = ready.backend;
      this.style.setProperty('--istar-aspect', `${file.archive.width} / ${file.archive.height}`);
      this.#view.show(file, ready);
      this.#hash.read();
    } catch (cause) {
      if (!loading.signal.aborted) this.#fail(cause, ready);
    }
  }

  #close(): void {
    this.#view.clear();
    this.#status.root.hidden = true;
    this.#fallback.removeAttribute('data-covered');
    this.#message.clear();
    this.#backend = undefined;
    this.#sent = '';
    this.#shown = false;
    this.#lost = 'no';
    this.#hover.update(() => undefined);
  }

  #fail(cause: unknown, renderer = this.#view.renderer): void {
    const error = viewerError(cause, 'gpu');
    if (error.kind === 'changed' && !this.#again) {
      this.#load();
      this.#again = true;
      return;
    }
    if (renderer && error.kind === 'gpu') {
      if (this.#lost === 'waiting') return;
      if (this.#shown && this.#lost === 'no') {
        this.#replace(renderer);
        return;
      }
      dropRenderer(renderer);
    }
    this.#loading?.abort();
    this.#close();
    this.#view.giveUp(error);
    this.#message.error(error);
    this.#emit('error', { kind: error.kind, message: error.message });
  }

  /** Takes a new device for the one that was lost. What was drawn last stays on the page meanwhile. */
  async #replace(lost: Renderer): Promise<void> {
    this.#lost = 'waiting';
    const loading = this.#loading;
    let ready: Renderer | undefined;
    try {
      await dropRenderer(lost);
      ready = await sharedRenderer(chosenBackend(this.getAttribute('backend')));
      if (loading?.signal.aborted) return;
      this.#lost = 'replaced';
      this.#backend = ready.backend;
      this.#status.backend(ready.backend);
      this.#view.moveTo(ready);
    } catch (cause) {
      if (loading?.signal.aborted) return;
      this.#lost = 'replaced';
      this.#fail(viewerError(cause, 'gpu'), ready);
    }
  }

  #drawn(first: boolean): void {
    if (this.#lost === 'replaced') this.#lost = 'no';
    const { place, fitted } = this.#view;
    if (!place) return;
    this.#stage.toggleAttribute('data-zoomed', !fitted);
    this.#status.zoom(place.scale);
    this.#hover.update((x, y) => this.#view.pick(x, y));
    if (first) {
      this.#shown = true;
      if (this.#backend) this.#status.backend(this.#backend);
      this.#status.root.hidden = false;
      this.#message.clear();
      this.#fallback.toggleAttribute('data-covered', true);
      this.#emit('load', undefined);
    }
    const { text } = this.#view;
    if (text === this.#sent) return;
    this.#sent = text;
    this.#hash.write();
    this.#emit('viewchange', place);
  }

  #listen(): void {
    const view = this.#view;
    const actions = {
      pan: (dx: number, dy: number) => view.pan(dx, dy),
      zoom: (factor: number, x: number, y: number) => view.zoom(factor, x, y),
      grab: () => this.#frames.stop(),
      animate: (step: (seconds: number) => boolean) => this.#frames.run(step),
      tap: (event: PointerEvent) => {
        const region = this.pick(event.clientX, event.clientY);
        if (region !== undefined) this.#emit('regionclick', this.#named(region));
      },
    };
    listenForGestures(this.#stage, actions);
    listenForWheel(this.#stage, actions);
    listenForKeys(this.#stage, {
      pan: (dx, dy) => this.#still(() => view.pan(dx, dy)),
      zoomBy: (factor) => this.#still(() => view.zoomAboutMiddle(factor)),
      fit: () => this.fit(),
    });
    this.#hover = new Hover(
      this.#stage,
      () => this.#hover.update((x, y) => view.pick(x, y)),
      (region, left) => {
        if (left !== undefined) this.#emit('regionleave', this.#named(left));
        if (region !== undefined) this.#emit('regionenter', this.#named(region));
        if (this.hasAttribute('interactive')) {
          view.styles.light(region);
          view.redraw();
        }
        if (region === undefined) this.#status.region(undefined);
        else this.#status.region(this.regionName(region) ?? `region ${region}`, view.regionColor(region));
      },
    );
  }

  #named(region: number): NamedRegion {
    return { region, name: this.regionName(region) };
  }

  /** Moves the view and ends what moves by itself. */
  #still(move: () => void): void {
    this.#frames.stop();
    move();
  }

  #label(): void {
    const alt = this.getAttribute('alt') ?? this.querySelector('img')?.alt;
    this.#stage.ariaLabel = alt || 'Picture';
  }

  #emit<Name extends keyof ViewerEvents>(name: Name, detail: ViewerEvents[Name]['detail']): void {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    'istar-viewer': IStarViewer;
  }
}
