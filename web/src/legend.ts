// `<istar-legend>`: what a picture's regions are called. A module of its own, for pages that want it: dist/istar-legend.js.
import { Address } from './address.js';
import { cssColor, download, make, sheetOf } from './dom.js';
import type { IStarViewer } from './element.js';
import css from './legend.css';
import type { Style, StyleSheet } from './style.js';
import { say, setWords } from './words.js';

// A server that renders pages imports this too, and has no HTMLElement.
const Base = globalThis.HTMLElement ?? (class {} as typeof HTMLElement);

/** So many names are seen at a glance; more are searched. */
const AT_A_GLANCE = 12;
/** The widest outline, in pixels. */
const WIDEST = 127;

interface Row {
  item: HTMLLIElement;
  name: string;
  /** The name as it is searched. */
  plain: string;
}

/**
 * `<istar-legend for="viewer">`: the names in the file that a viewer shows, each with a box that hides its regions, a field for their
 * colour, and behind a button their opacity and outline. The viewer is the one with that id, or the one that it is in (`slot="legend"`), or
 * the page's first. What is changed is in the viewer's `styles`, which a button saves. Hidden while there is no name.
 *
 * @tag istar-legend
 *
 * @attr {string} for - the id of the viewer; else the one that it is in, or the first of the page
 * @attr {string} hash - the viewer's styles are kept in the page's address, as `#styles=…` or under the name that is given, when they
 * are changed here, and read from there
 *
 * @csspart search - the field for a part of a name, where there are many
 * @csspart more - the button of a name that shows its `detail`
 * @csspart detail - the opacity and outline of what has a name
 * @csspart save - the button that saves the styles
 *
 * @cssprop --istar-ink - text
 * @cssprop --istar-paper - what lies under text
 * @cssprop --istar-line - thin lines
 * @cssprop --istar-accent - what can be pressed
 */
export class IStarLegend extends Base {
  static readonly observedAttributes = ['for', 'hash'];

  readonly #search = make('input', 'search');
  readonly #list = make('ul', '');
  readonly #save = make('button', 'save');
  readonly #address = new Address(
    () => this.#text(),
    (text) => this.#take(text),
  );
  #names: ReadonlyMap<number, string> = new Map();
  #rows: Row[] = [];
  /** The colour whose name the pointer is over. */
  #lit: string | undefined;
  #viewer: IStarViewer | undefined;
  #following: AbortController | undefined;

  constructor() {
    super();
    this.#search.type = 'search';
    this.#search.addEventListener('input', () => this.#filter());
    this.#save.type = 'button';
    this.#save.addEventListener('click', () => this.#download());
    const root = this.attachShadow({ mode: 'open' });
    root.adoptedStyleSheets = [sheetOf(css)];
    root.append(this.#search, this.#list, this.#save);
  }

  connectedCallback(): void {
    this.#following?.abort();
    // Of the viewer that it was.
    this.#light(undefined);
    const following = new AbortController();
    const { signal } = following;
    this.#following = following;
    const id = this.getAttribute('for');
    const found = id
      ? document.getElementById(id)
      : (this.closest('istar-viewer') ?? document.querySelector('istar-viewer'));
    this.#viewer = (found as IStarViewer | null) ?? undefined;
    const viewer = this.#viewer;
    const part = this.getAttribute('hash');
    this.#address.follow(part === '' ? 'styles' : part);
    this.#show(new Map());
    if (!viewer) return;
    const load = async () => {
      this.#address.read();
      const names = await viewer.names;
      if (signal.aborted || !names) return;
      // They are the viewer's, whose module has them for itself.
      setWords((viewer.constructor as typeof IStarViewer).words);
      this.#show(names);
    };
    viewer.addEventListener('load', load, { signal });
    viewer.addEventListener('regionenter', ({ detail }) => this.#mark(detail.name, true), { signal });
    viewer.addEventListener('regionleave', ({ detail }) => this.#mark(detail.name, false), { signal });
    // It may be there already; before its element is defined it has no names.
    if (viewer.localName.includes('-')) customElements.whenDefined(viewer.localName).then(load);
  }

  disconnectedCallback(): void {
    this.#following?.abort();
    this.#address.follow(null);
  }

  attributeChangedCallback(_: string, before: string | null, now: string | null): void {
    if (this.isConnected && before !== now) this.connectedCallback();
  }

  #show(names: ReadonlyMap<number, string>): void {
    this.#names = names;
    this.#rows = [];
    // The pointer leaves no row that goes away under it.
    this.#light(undefined);
    this.#list.replaceChildren();
    this.#save.textContent = say('Save styles');
    this.#search.value = '';
    this.#search.placeholder = say('Search');
    this.#search.ariaLabel = say('Search names');
    this.#search.hidden = names.size <= AT_A_GLANCE;
    this.hidden = names.size === 0;
    const order = new Intl.Collator(undefined, { numeric: true }).compare;
    for (const [color, name] of [...names].sort(([, a], [, b]) => order(a, b))) this.#add(color, name);
  }

  #add(number: number, name: string): void {
    const color = cssColor(number);
    const set = this.#viewer?.styles.colors?.[color];
    const shown = make('input', '');
    shown.type = 'checkbox';
    shown.checked = set?.visible !== false;
    shown.addEventListener('change', () => this.#style(color, { visible: shown.checked }));
    const swatch = make('input', '');
    swatch.type = 'color';
    swatch.value = set?.color ?? color.slice(0, 7);
    swatch.ariaLabel = say('Colour of {name}', { name });
    swatch.addEventListener('input', () => this.#style(color, { color: swatch.value }));
    const label = make('label', '', shown, name);
    const item = make('li', '', swatch, label, this.#more(color, name));
    item.addEventListener('pointerenter', () => this.#light(color));
    item.addEventListener('pointerleave', () => this.#light(undefined));
    this.#list.append(item);
    this.#rows.push({ item, name, plain: plain(name) });
  }

  /** The button that shows, below a name, what is seldom changed. */
  #more(color: string, name: string): HTMLButtonElement {
    const more = make('button', 'more');
    more.type = 'button';
    more.ariaLabel = more.title = say('Opacity and outline of {name}', { name });
    more.ariaExpanded = 'false';
    // Of hundreds of names few are asked for it.
    let detail: HTMLElement | undefined;
    more.addEventListener('click', () => {
      if (!detail) {
        detail = this.#detail(color);
        more.after(detail);
        detail.hidden = true;
      }
      detail.hidden = !detail.hidden;
      more.ariaExpanded = String(!detail.hidden);
    });
    return more;
  }

  #detail(color: string): HTMLElement {
    const set = this.#viewer?.styles.colors?.[color];
    const opacity = make('input', '');
    Object.assign(opacity, { type: 'range', min: '0', max: '1', step: '0.05' });
    opacity.value = String(set?.opacity ?? 1);
    opacity.addEventListener('input', () => this.#style(color, { opacity: Number(opacity.value) }));
    const width = make('input', '');
    Object.assign(width, { type: 'number', min: '0', max: String(WIDEST) });
    width.value = String(set?.outline?.width ?? 0);
    width.ariaLabel = say('Width of the outline');
    const line = make('input', '');
    line.type = 'color';
    line.value = set?.outline?.color ?? '#000000';
    line.ariaLabel = say('Colour of the outline');
    const outlined = () => {
      const { outline } = this.#viewer?.styles.colors?.[color] ?? {};
      const wide = Math.min(Math.max(Number(width.value), 0), WIDEST);
      this.#style(color, { outline: { ...outline, color: line.value, width: wide } });
    };
    width.addEventListener('input', outlined);
    line.addEventListener('input', outlined);
    const fields = make('span', '', say('Outline'), line, width);
    return make('div', 'detail', make('label', '', say('Opacity'), opacity), fields);
  }

  /** Lights what has a colour, in place of the last. */
  #light(color: string | undefined): void {
    if (this.#lit) this.#restyle(this.#lit, { highlight: false });
    this.#lit = color;
    if (color) this.#restyle(color, { highlight: true });
  }

  /** What somebody changed: it is kept in the address, too. */
  #style(color: string, change: Style): void {
    this.#restyle(color, change);
    this.#address.write();
  }

  /** Says something of how a colour's regions are drawn, beside what is said of them already. */
  #restyle(color: string, change: Style): void {
    const viewer = this.#viewer;
    if (!viewer) return;
    const sheet = viewer.styles;
    const { highlight, ...style } = { ...sheet.colors?.[color], ...change };
    viewer.styles = {
      ...sheet,
      colors: { ...sheet.colors, [color]: highlight ? { ...style, highlight } : style },
    };
  }

  /** What is said of regions, without what only the pointer does and where nothing is said. */
  #sheet(): StyleSheet {
    const { all = {}, colors = {}, regions = {} } = this.#viewer?.styles ?? {};
    const lit = this.#lit && colors[this.#lit];
    if (lit) delete lit.highlight;
    const isSaid = (things: object) => Object.keys(things).length > 0;
    const said = (styles: Record<string, Style>) =>
      Object.fromEntries(Object.entries(styles).filter(([, style]) => isSaid(style)));
    const sheet = { all, colors: said(colors), regions: said(regions) };
    return Object.fromEntries(Object.entries(sheet).filter(([, part]) => isSaid(part)));
  }

  /** The same for an address; nothing where nothing is said. */
  #text(): string {
    const text = JSON.stringify(this.#sheet());
    // As addresses are read.
    return text === '{}' ? '' : encodeURIComponent(text).replaceAll('%2C', ',');
  }

  /** Styles as an address has them. Anybody may have written it. */
  #take(text: string): void {
    const viewer = this.#viewer;
    if (!viewer) return;
    const before = viewer.styles;
    try {
      viewer.styles = JSON.parse(decodeURIComponent(text));
    } catch (cause) {
      viewer.styles = before;
      console.warn(`istar-legend: the styles in the page's address cannot be read: ${cause}`);
    }
    this.#show(this.#names);
  }

  #download(): void {
    const text = JSON.stringify(this.#sheet(), undefined, 2);
    download(new Blob([text], { type: 'application/json' }), 'styles.json');
  }

  #filter(): void {
    const wanted = plain(this.#search.value.trim());
    for (const { item, plain } of this.#rows) item.hidden = !plain.includes(wanted);
  }

  /** Marks the name of the region under the pointer. */
  #mark(name: string | undefined, on: boolean): void {
    for (const row of this.#rows) if (row.name === name) row.item.toggleAttribute('data-current', on);
  }
}

/** A name without accents and capitals. */
function plain(name: string): string {
  return name.normalize('NFD').replace(/\p{M}/gu, '').toLowerCase();
}

declare global {
  interface HTMLElementTagNameMap {
    'istar-legend': IStarLegend;
  }
}

if (globalThis.customElements && !customElements.get('istar-legend')) {
  customElements.define('istar-legend', IStarLegend);
}
