import { Address } from './address.js';
import { Approach } from './approach.js';
import { type Backend, chosenBackend } from './backend.js';
import { blobOf } from './blob.js';
import { Box } from './box.js';
import type { Controls } from './controls.js';
import { cssColor, make, sheetOf, slot } from './dom.js';
import css from './element.css';
import { dropRenderer, openFile, type Renderer, sharedRenderer } from './engine.js';
import { type ViewerError, viewerError } from './errors.js';
import type { NamedRegion, ShownRegion, ViewerElement, ViewerEvents } from './events.js';
import { Frames } from './frames.js';
import { type Finger, listenForGestures } from './gestures.js';
import type { Host } from './host.js';
import { Hover } from './hover.js';
import { listenForKeys } from './keyboard.js';
import { Message } from './message.js';
import { missing } from './missing.js';
import { Paper } from './paper.js';
import { Poster } from './poster.js';
import { forgetSource, sharedSource } from './shared.js';
import { FileSource, type Source } from './source.js';
import { Status } from './status.js';
import type { Style, StyleSheet } from './style.js';
import { View } from './view.js';
import type { Walk } from './walk.js';
import { listenForWheel } from './wheel.js';
import { say, setWords, type Words, wordsNow } from './words.js';

// A server that renders pages imports this too, and has no HTMLElement.
const Base = (globalThis.HTMLElement ?? class {}) as new () => ViewerElement;

/** Attributes that ask for something beside the picture, and those that say how it is. */
const BESIDE = ['controls', 'navigator', 'scalebar', 'unit', 'unit-per-pixel'];

/** Who turns the picture that near to upright has it upright. */
const NEARLY_DEGREES = 7;

/** What `toBlob` makes of the view. Without a size, what is on the screen; with one side alone the other follows. */
export interface PictureOptions {
  /** Pixels. */
  width?: number;
  height?: number;
  /**
   * `image/png`, or `image/jpeg` or `image/webp`, which have a quality of 0 to 1; or lines and areas: `image/svg+xml`,
   * `application/pdf` or `application/postscript`, whose unit is a CSS pixel.
   */
  type?: string;
  quality?: number;
  /** Lines and areas of all of the picture in place of the view: as large as the source unless told. */
  whole?: boolean;
}

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
 * @attr {string} poster - where an image is that stands in until the first frame
 * @attr {'anonymous' | 'use-credentials'} crossorigin - `use-credentials`: another site's server is sent its cookies, too; said before
 * the picture is fetched
 * @attr {'auto' | 'lazy' | 'eager'} loading - `eager`: the picture is fetched at once; else when the figure comes near the window
 * @attr {boolean} interactive - the region under the pointer is highlighted
 * @attr {string} outline - lines along all boundaries: a width in CSS pixels and a colour, as `2 white`; else 1 and black. Styles come
 * before it
 * @attr {number} rotation - by so many degrees the picture is turned at first, clockwise; and whenever this changes
 * @attr {boolean} flipped - it is mirrored, left to right, before it is turned; likewise
 * @attr {boolean} controls - buttons: zoom, all of it, turn, mirror, full screen, save
 * @attr {boolean} navigator - an overview: a drag in it moves the view
 * @attr {boolean} scalebar - how long something is
 * @attr {string} unit - what the scale bar counts; else source pixels
 * @attr {number} unit-per-pixel - so many of them are a source pixel long
 * @attr {string} hash - the view is kept in the page's address, as `#view=x,y,scale` or under the name that is given; turned, as
 *   `#view=x,y,scale,rotation`, and mirrored with `,flipped` after it
 * @attr {'webgpu' | 'webgl2' | 'cpu'} backend - what draws; else the first that works
 *
 * @fires {CustomEvent} load - the first frame is painted
 * @fires {CustomEvent} progress - bytes have come: `loaded`, and `total` where it is known
 * @fires {CustomEvent} error - there is no picture: `kind` and `message` say why
 * @fires {CustomEvent} viewchange - another view is painted: `x`, `y`, `scale`, `rotation`, `flipped`
 * @fires {CustomEvent} regionenter - the pointer is on a region: `region`, and `name` where the file has one
 * @fires {CustomEvent} regionleave - the pointer has left a region
 * @fires {CustomEvent} regionclick - a region was clicked or tapped
 *
 * @slot - what stands in until the picture is there, and where scripts do not run: an `<img>`
 * @slot poster - likewise
 * @slot progress - what is shown while the picture loads, in place of a bar: in it `--istar-share` is how much has come, from 0 to 1
 * @slot legend - what lies over a corner, and scrolls where it is long: an `<istar-legend>`
 *
 * @csspart poster - the image of that attribute
 * @csspart stage - where the picture is, and what the keys move
 * @csspart box - what a drag with shift spans
 * @csspart pin - where a walk is
 * @csspart spoken - what a walk says, for ears alone
 * @csspart status - the readout in the corner: `region`, `zoom` and `backend`
 * @csspart region - in the readout: `swatch` and `name`
 * @csspart swatch - the colour of the region
 * @csspart name - what the region is called
 * @csspart zoom - the scale
 * @csspart backend - what draws
 * @csspart message - what stands in place of the picture: `progress` or `error`
 * @csspart progress - `loading` and `bar`
 * @csspart loading - how much there is
 * @csspart bar - the way that `fill` has to go
 * @csspart fill - how far it is
 * @csspart error - `title`, `detail` and `retry`
 * @csspart title - what cannot be done
 * @csspart detail - what is wrong
 * @csspart retry - the button for another try
 * @csspart controls - the buttons
 * @csspart control - each of them
 * @csspart overview - all of the picture, small
 * @csspart frame - what of it the view shows
 * @csspart scalebar - the scale bar
 *
 * @cssprop --istar-ink - text
 * @cssprop --istar-paper - what lies under text
 * @cssprop --istar-line - thin lines
 * @cssprop --istar-accent - what can be pressed, and progress
 */
export class IStarViewer extends Base {
  static readonly observedAttributes = [
    'src',
    'alt',
    'loading',
    'backend',
    'poster',
    'outline',
    'hash',
    'rotation',
    'flipped',
    ...BESIDE,
  ];

  /** Of the class: what viewers of the page say, in its language, by the English text. To be set before they show a picture. */
  static get words(): Words {
    return wordsNow();
  }

  static set words(words: Words) {
    setWords(words);
  }

  #view!: View;
  #stage!: HTMLElement;
  #frames = new Frames();
  #status!: Status;
  #message!: Message;
  #hover!: Hover;
  readonly #address: Address;
  readonly #host: Host;
  #walk: Promise<Walk | undefined> | undefined;
  #beside: Promise<Controls | undefined> | undefined;
  readonly #paper: Paper;
  readonly #poster: Poster;
  readonly #box = new Box();
  readonly #approach = new Approach(this);
  #source: Source | undefined;
  #loading: AbortController | undefined;
  #open = false;
  #backend: Backend | undefined;
  /** The view that was told of last. */
  #sent = '';
  /** The first frame of the picture is there. */
  #shown = false;
  /** The file changed while it was read, and is read once more. */
  #again = false;
  /** Why there is no picture. */
  #error: ViewerError | undefined;
  /** The device was lost: a new one is awaited, or there and yet to draw a frame. */
  #lost: 'no' | 'waiting' | 'replaced' = 'no';

  constructor() {
    super();
    this.#view = new View({
      drawn: (first) => this.#drawn(first),
      failed: (cause) => this.#fail(cause),
    });
    this.#address = new Address(
      () =>
        this.#view.fitted && this.#ownTurn.join() === [this.rotation, this.flipped].join()
          ? ''
          : this.#view.text,
      (text) => {
        this.place = text;
      },
    );
    this.#poster = new Poster(this, () => {
      this.#label();
      this.#shape();
    });
    this.#paper = new Paper(this.#view);
    this.#stage = make('div', 'stage', this.#view.canvas, this.#box.root);
    this.#stage.tabIndex = 0;
    this.#stage.role = 'application';
    this.#status = new Status();
    this.#message = new Message(() => {
      // The button is about to go, and would take the focus with it.
      this.#stage.focus();
      this.#load();
    });
    const root = this.attachShadow({ mode: 'open' });
    sheet ??= sheetOf(css);
    root.adoptedStyleSheets = [sheet];
    root.append(this.#poster.root, this.#stage, this.#status.root, slot('legend'), this.#message.root);
    this.#host = {
      element: this,
      root,
      stage: this.#stage,
      view: this.#view,
      say,
      still: () => this.#frames.stop(),
      named: (region) => this.regionName(region),
      emit: (event, region) => this.#emit(event, this.#named(region)),
      tell: (name, region) => this.#tell(name, region),
    };
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

  /** What is shown in place of `src`, if anything: a file that somebody chose, or whatever else gives bytes. */
  get source(): Source | undefined {
    return this.#source;
  }

  set source(source: Source | Blob | null | undefined) {
    this.#source = source instanceof Blob ? new FileSource(source) : (source ?? undefined);
    if (this.#open) this.#change();
  }

  /** What draws, once it is known. */
  get backend(): Backend | undefined {
    return this.#backend;
  }

  /** Resolves when the canvas shows the current view; while loading, after the first frame. Rejects where there is no picture to show. */
  get painted(): Promise<void> {
    // Who asks for the picture gets it, near or far.
    this.#approach.now();
    return this.#error ? Promise.reject(this.#error) : this.#view.settled();
  }

  /** Centre in source pixels; scale is CSS pixels per source pixel. */
  zoomTo(x: number, y: number, scale: number): void {
    this.#still(() => this.#view.lookAt(x, y, scale));
  }

  /**
   * Turns the picture by degrees, clockwise from where it was at first, about the middle of the view; `flipped`: it is mirrored before,
   * left to right. A view of all of the picture goes on to be one.
   */
  turnTo(rotation: number, flipped = this.flipped): void {
    this.#still(() => this.#view.turn(rotation, flipped));
  }

  /** Degrees by which the picture is turned, from 0 to below 360. What it is set to is the attribute's too. */
  get rotation(): number {
    return this.#view.place?.rotation ?? this.#ownTurn[0];
  }

  set rotation(degrees: number) {
    this.setAttribute('rotation', String(degrees));
    this.turnTo(degrees);
  }

  /** Whether the picture is mirrored, left to right, before it is turned. Likewise. */
  get flipped(): boolean {
    return this.#view.place?.flipped ?? this.#ownTurn[1];
  }

  set flipped(flipped: boolean) {
    this.toggleAttribute('flipped', flipped);
    this.turnTo(this.rotation, flipped);
  }

  /**
   * The view as text, `x,y,scale`, with every digit, and `,rotation` and then `,flipped` where it is turned: what it is set to is shown
   * exactly so. Empty while there is no picture.
   */
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

  /** The regions in view, and those of its tiles that are not far from it, in ascending order. */
  get regions(): ShownRegion[] {
    return this.#view.regions.map((region) => ({
      ...this.#named(region),
      color: cssColor(this.#view.regionColor(region) ?? 0),
    }));
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

  /** The current view as a picture, a PNG unless asked otherwise. */
  async toBlob(options: PictureOptions = {}): Promise<Blob> {
    await this.painted;
    const { width, height, type } = options;
    // What makes it in any size or as lines, and puts paper under what knows no transparency, is fetched only then.
    return width || height || /jpeg|svg|app/.test(type ?? '')
      ? (await import('./export.js')).exported(this.#view, options)
      : blobOf(this.#view.canvas, options);
  }

  connectedCallback(): void {
    if (this.#open) return;
    this.#open = true;
    this.#label();
    this.#poster.update();
    this.#outline();
    this.#address.follow(this.getAttribute('hash'));
    this.#paper.watch(true);
    this.#start();
  }

  disconnectedCallback(): void {
    // An element that is only moved is back by then, and keeps its picture.
    queueMicrotask(() => {
      if (this.isConnected) return;
      this.#open = false;
      this.#loading?.abort();
      this.#approach.stop();
      this.#frames.stop();
      this.#view.watch(false);
      this.#address.follow(null);
      this.#paper.watch(false);
      this.#close();
    });
  }

  attributeChangedCallback(name: string, before: string | null, now: string | null): void {
    if (!this.#open || before === now) return;
    if (name === 'alt') this.#label();
    else if (name === 'loading') this.#hasten();
    else if (name === 'poster') this.#poster.update();
    else if (name === 'outline') this.#outline();
    else if (BESIDE.includes(name)) this.#updateBeside();
    else if (name === 'rotation') this.turnTo(this.#ownTurn[0]);
    else if (name === 'flipped') this.turnTo(this.rotation, this.#ownTurn[1]);
    else if (name === 'hash') {
      this.#address.follow(now);
      this.#address.read();
    } else {
      this.#change(name !== 'src');
    }
  }

  /** Shows another picture, or the same in another way. */
  #change(isSame = false): void {
    if (this.#shown && !isSame) this.#address.forget();
    this.#start();
  }

  /** Loads the picture as soon as somebody may see it. */
  #start(): void {
    this.#stop();
    this.#approach.wait(() => this.#load());
    this.#hasten();
  }

  #hasten(): void {
    if (this.getAttribute('loading') === 'eager') this.#approach.now();
  }

  #stop(): void {
    this.#loading?.abort();
    this.#error = undefined;
    this.#close();
  }

  async #load(): Promise<void> {
    this.#again = false;
    this.#stop();
    if (!this.src && !this.#source) return;
    const loading = new AbortController();
    this.#loading = loading;
    this.#message.loading({ loaded: 0, total: undefined });
    let ready: Renderer | undefined;
    try {
      // The renderer starts while the file is on its way. Its error is heard below, also when the file fails first.
      const renderer = sharedRenderer(chosenBackend(this.getAttribute('backend')));
      renderer.catch(() => {});
      const isKnown = this.getAttribute('crossorigin') === 'use-credentials';
      const credentials = isKnown ? 'include' : 'same-origin';
      const source =
        this.#source ??
        sharedSource(this.src, credentials, loading.signal, (progress) => {
          if (loading.signal.aborted || this.#shown) return;
          this.#message.loading(progress);
          this.#emit('progress', progress);
        });
      const file = await openFile(source, loading.signal);
      ready = await renderer.catch((cause) => {
        file.free();
        throw cause;
      });
      await this.#address.ready;
      if (loading.signal.aborted) {
        file.free();
        return;
      }
      this.#backend = ready.backend;
      this.style.setProperty('--istar-aspect', `${file.archive.width} / ${file.archive.height}`);
      this.#view.show(file, ready);
      this.#view.turn(...this.#ownTurn);
      this.#address.read();
    } catch (cause) {
      if (!loading.signal.aborted) this.#fail(cause, ready);
    }
  }

  #close(): void {
    this.#view.clear();
    this.#status.root.hidden = true;
    this.#poster.cover(false);
    this.#message.clear();
    this.#backend = undefined;
    this.#sent = '';
    this.#shown = false;
    this.#lost = 'no';
    this.#hover.update(() => undefined);
    this.#walk?.then((walk) => walk?.end());
    this.#updateBeside();
  }

  #fail(cause: unknown, renderer = this.#view.renderer): void {
    const error = viewerError(cause, 'gpu');
    if (error.kind === 'changed' && !this.#again) {
      forgetSource(this.src);
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
    this.#stop();
    this.#error = error;
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
      this.#poster.cover(true);
      if (!this.#alt)
        console.warn(`istar-viewer: ${this.src} has no alt: say what it shows, for those who do not see it.`);
      this.#emit('load', undefined);
    }
    this.#updateBeside();
    const { text } = this.#view;
    if (text === this.#sent) return;
    this.#sent = text;
    this.#address.write();
    this.#emit('viewchange', place);
  }

  #listen(): void {
    const view = this.#view;
    const actions = {
      pan: (dx: number, dy: number) => view.drag(dx, dy),
      zoom: (factor: number, x: number, y: number) => view.zoom(factor, x, y),
      turn: (degrees: number, about: Finger) => view.turnBy(degrees, about),
      turned: () => {
        if (Math.abs(((this.rotation + 180) % 360) - 180) < NEARLY_DEGREES) view.turn(0, this.flipped);
      },
      grab: () => this.#frames.stop(),
      animate: (step: (seconds: number) => boolean) => this.#frames.run(step),
      box: (from: Finger, to: Finger, over: boolean) => this.#spanBox(from, to, over),
      tap: (event: PointerEvent) => {
        const region = this.pick(event.clientX, event.clientY);
        if (region !== undefined) this.#emit('regionclick', this.#named(region));
      },
    };
    listenForGestures(this.#stage, actions);
    listenForWheel(this.#stage, actions);
    listenForKeys(this.#stage, {
      pan: (dx, dy) => this.#still(() => view.drag(dx, dy)),
      zoomBy: (factor) => this.#still(() => view.zoomAboutMiddle(factor)),
      fit: () => this.fit(),
      turn: (degrees) => this.#still(() => view.turnBy(degrees)),
      flip: () => this.#still(() => view.flip()),
      walk: () => this.#startWalk(),
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
        if (region === undefined) this.#tell(undefined);
        else this.#tell(this.regionName(region) ?? say('region {number}', { number: region }), region);
      },
    );
  }

  #spanBox(from: Finger, to: Finger, over: boolean): void {
    const [left, top] = [Math.min(from.x, to.x), Math.min(from.y, to.y)];
    const [width, height] = [Math.abs(to.x - from.x), Math.abs(to.y - from.y)];
    if (!over) this.#box.show(left, top, width, height);
    else {
      this.#box.hide();
      // One without extent has been given up.
      if (width > 0 && height > 0) this.#view.zoomInto(left, top, width, height);
    }
  }

  async #startWalk(): Promise<void> {
    // Fetched only where somebody walks; without it the other keys do.
    this.#walk ??= import('./walk.js').then(({ Walk }) => new Walk(this.#host)).catch(missing);
    (await this.#walk)?.start();
  }

  /** Brings what is beside the picture up to date; it is fetched only where an attribute asks for it. */
  async #updateBeside(): Promise<void> {
    if (this.#shown && BESIDE.some((name) => this.hasAttribute(name)))
      this.#beside ??= import('./controls.js')
        .then(({ Controls }) => new Controls(this.#host))
        .catch(missing);
    (await this.#beside)?.update();
  }

  /** Says in the corner which region it is. */
  #tell(name: string | undefined, region = 0): void {
    this.#status.region(name, this.#view.regionColor(region));
  }

  #named(region: number): NamedRegion {
    return { region, name: this.regionName(region) };
  }

  /** Moves the view and ends what moves by itself. */
  #still(move: () => void): void {
    this.#frames.stop();
    move();
  }

  #outline(): void {
    this.#view.styles.base = baseStyle(this.getAttribute('outline'));
    this.#view.redraw();
  }

  /** As the page has it. */
  get #ownTurn(): [rotation: number, flipped: boolean] {
    const degrees = Number(this.getAttribute('rotation')) % 360 || 0;
    return [degrees < 0 ? (degrees + 360) % 360 : degrees, this.hasAttribute('flipped')];
  }

  get #alt(): string {
    return this.getAttribute('alt') ?? this.#poster.alt;
  }

  /** What stands in has the shape of the picture, until its file says that. */
  #shape(): void {
    const { shape } = this.#poster;
    if (shape && !this.#view.file) this.style.setProperty('--istar-aspect', shape);
  }

  #label(): void {
    this.#stage.ariaLabel = this.#alt || say('Picture');
    this.#stage.ariaRoleDescription = say('zoomable picture');
    this.#stage.ariaDescription = say(
      'Arrows move it, plus and minus zoom, 0 shows all, R turns, F mirrors. Enter walks regions by arrows until Escape.',
    );
  }

  #emit<Name extends keyof ViewerEvents>(name: Name, detail: ViewerEvents[Name]['detail']): void {
    this.dispatchEvent(new CustomEvent(name, { detail }));
  }
}

/** Of what the attribute `outline` says: a width and a colour, both or one of them. */
function baseStyle(outline: string | null): Style | undefined {
  const [, width, color] = outline?.match(/^\s*([\d.]*)(?:px)?\s*(.*)$/) ?? [];
  return width === undefined ? undefined : { outline: { width: Number(width || 1), color: color || '#000' } };
}

declare global {
  interface HTMLElementTagNameMap {
    'istar-viewer': IStarViewer;
  }
}
