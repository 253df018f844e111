// `<istar-legend>`: what a picture's regions are called. A module of its own, for pages that want it: dist/istar-legend.js.
import { make, sheetOf } from './dom.js';
import type { IStarViewer } from './element.js';
import css from './legend.css';
import type { Style } from './style.js';
import { say, setWords } from './words.js';

// A server that renders pages imports this too, and has no HTMLElement.
const Base = globalThis.HTMLElement ?? (class {} as typeof HTMLElement);

/** So many names are seen at a glance; more are searched. */
const AT_A_GLANCE = 12;

interface Row {
  item: HTMLLIElement;
  name: string;
  /** The name as it is searched. */
  plain: string;
}

/**
 * `<istar-legend for="viewer">`: the names in the file that a viewer shows, each with a box that hides its regions and a field for
 * their colour. The viewer is the one with that id, or the page's first. What is changed is in the viewer's `styles`. Hidden while
 * there is no name.
 *
 * @tag istar-legend
 *
 * @attr {string} for - the id of the viewer
 *
 * @csspart search - the field for a part of a name, where there are many
 *
 * @cssprop --istar-ink - text
 * @cssprop --istar-paper - what lies under text
 * @cssprop --istar-line - thin lines
 * @cssprop --istar-accent - what can be pressed
 */
export class IStarLegend extends Base {
  static readonly observedAttributes = ['for'];

  readonly #search = make('input', 'search');
  readonly #list = make('ul', '');
  #rows: Row[] = [];
  #viewer: IStarViewer | undefined;
  #following: AbortController | undefined;

  constructor() {
    super();
    this.#search.type = 'search';
    this.#search.addEventListener('input', () => this.#filter());
    const root = this.attachShadow({ mode: 'open' });
    root.adoptedStyleSheets = [sheetOf(css)];
    root.append(this.#search, this.#list);
  }

  connectedCallback(): void {
    this.#following?.abort();
    const following = new AbortController();
    const { signal } = following;
    this.#following = following;
    const id = this.getAttribute('for');
    const found = id ? document.getElementById(id) : document.querySelector('istar-viewer');
    this.#viewer = (found as IStarViewer | null) ?? undefined;
    const viewer = this.#viewer;
    this.#show(new Map());
    if (!viewer) return;
    const load = async () => {
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
  }

  attributeChangedCallback(_: string, before: string | null, now: string | null): void {
    if (this.isConnected && before !== now) this.connectedCallback();
  }

  #show(names: ReadonlyMap<number, string>): void {
    this.#rows = [];
    this.#list.replaceChildren();
    this.#search.value = '';
    this.#search.placeholder = say('Search');
    this.#search.ariaLabel = say('Search names');
    this.#search.hidden = names.size <= AT_A_GLANCE;
    this.hidden = names.size === 0;
    const order = new Intl.Collator(undefined, { numeric: true }).compare;
    for (const [color, name] of [...names].sort(([, a], [, b]) => order(a, b))) this.#add(color, name);
  }

  #add(number: number, name: string): void {
    const color = `#${number.toString(16).padStart(8, '0')}`;
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
    const item = make('li', '', swatch, label);
    const light = (on: boolean) => () => this.#style(color, { highlight: on });
    item.addEventListener('pointerenter', light(true));
    item.addEventListener('pointerleave', light(false));
    this.#list.append(item);
    this.#rows.push({ item, name, plain: plain(name) });
  }

  /** Says something of how a colour's regions are drawn, beside what is said of them already. */
  #style(color: string, change: Style): void {
    const viewer = this.#viewer;
    if (!viewer) return;
    const sheet = viewer.styles;
    const { highlight, ...style } = { ...sheet.colors?.[color], ...change };
    viewer.styles = {
      ...sheet,
      colors: { ...sheet.colors, [color]: highlight ? { ...style, highlight } : style },
    };
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
