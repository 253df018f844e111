import type { Renderer, Scene } from './engine.js';
import { ABSORBED, type Pattern, type Style, type StyleSheet } from './style.js';
import type { Loaded, Tiles } from './tiles.js';

const SIDES = ['inside', 'centre', 'outside'];
const MOTIFS: Pattern['motif'][] = ['rising', 'falling', 'horizontal', 'vertical', 'cross', 'grid', 'dots'];

/** As many regions may change one by one, before all are written anew. */
const FEW = 64;

/** A style whose colours are numbers, red lowest. */
type Prepared = Style & { fill?: number; words: [outline: number, pattern: number] };

/** How a picture's regions are drawn, beyond what the file says. */
export class Styles {
  #sheet: Required<StyleSheet> = { all: {}, colors: {}, regions: {} };
  #all: Prepared | undefined;
  /** Of all regions, after all that is said. */
  #base: Prepared | undefined;
  readonly #colors = new Map<number, Prepared>();
  readonly #regions = new Map<number, Prepared>();
  /** The region that is highlighted beside what styles say. */
  #lit: number | undefined;
  /** A region that has a style before all that is said. */
  #marked: number | undefined;
  #mark: Prepared | undefined;
  /** Regions that are drawn as others, in what is shown. */
  absorbed = new Map<number, number>();
  /** What tells by which others regions are absorbed, once one is and it is there; and while it is fetched. */
  #absorb: typeof import('./absorb.js').absorb | undefined;
  unready: Promise<void> | undefined;
  /** Grows with each change. */
  version = 0;
  /** How many of these were no more than the highlight. */
  lights = 0;
  /** What changed in the last versions; undefined for more than few regions. */
  #changes: (number[] | undefined)[] = [];

  get sheet(): StyleSheet {
    return structuredClone(this.#sheet);
  }

  set sheet({ all = {}, colors = {}, regions = {} }: StyleSheet) {
    this.#sheet = structuredClone({ all, colors, regions });
    this.#all = prepared(all);
    this.#colors.clear();
    for (const [color, style] of Object.entries(colors)) this.#colors.set(rgba(color), prepared(style));
    this.#regions.clear();
    for (const [region, style] of Object.entries(regions)) this.#regions.set(Number(region), prepared(style));
    this.#changed(undefined);
  }

  set base(style: Style | undefined) {
    // As the file has all of it, nothing need be written.
    if (!this.#base && !style) return;
    this.#base = style && prepared(style);
    this.#changed(undefined);
  }

  /** Gives regions a style, in place of the one they had; null takes it away. */
  set(regions: Iterable<number>, style: Style | null): void {
    const changed = [...regions];
    const ready = style && prepared(style);
    for (const region of changed) {
      if (style && ready) {
        this.#regions.set(region, ready);
        this.#sheet.regions[region] = style;
      } else {
        this.#regions.delete(region);
        delete this.#sheet.regions[region];
      }
    }
    this.#changed(changed);
  }

  /** Highlights one region in place of the last. */
  light(region: number | undefined): void {
    this.lights++;
    const changed = [this.#lit, region].filter((one) => one !== undefined);
    this.#lit = region;
    this.#changed(changed);
  }

  /** Gives one region in place of the last a style before all that is said. */
  mark(region: number | undefined, style: Style): void {
    const changed = [this.#marked, region].filter((one) => one !== undefined);
    this.#marked = region;
    this.#mark = prepared(style);
    this.#changed(changed);
  }

  /** Brings a tile that is on the GPU up to date. */
  apply(
    loaded: Loaded,
    scene: Scene,
    renderer: Pick<Renderer, 'setStyles'>,
    ratio: number,
    tiles: Tiles,
  ): void {
    const { tile, styled } = loaded;
    if (this.version === 0 || (styled?.version === this.version && styled.ratio === ratio)) return;
    loaded.styled = { version: this.version, ratio };
    loaded.regions ??= tile.regions();
    const half = loaded.regions.length / 2;
    const ids = loaded.regions.subarray(0, half);
    const colors = loaded.regions.subarray(half);
    // Who absorbs a region may hang on all that are absorbed.
    const few = styled?.ratio === ratio && !this.#absorb ? this.#since(styled.version) : undefined;
    if (few) {
      const words = new Uint32Array(4);
      for (const region of few) {
        const at = place(ids, region);
        if (at === undefined) continue;
        this.#write(words, 0, region, colors[at] ?? 0, ratio);
        renderer.setStyles(scene, at, words);
      }
    } else {
      const words = new Uint32Array(4 * half);
      for (let i = 0; i < half; i++) this.#write(words, 4 * i, ids[i] ?? 0, colors[i] ?? 0, ratio);
      try {
        this.#absorb?.(words, loaded, tiles, this, ratio);
      } catch (cause) {
        // Better to see the rest.
        console.warn(cause);
        for (let i = 2; i < words.length; i += 4) if (words[i] === ABSORBED) words[i] = 0;
      }
      renderer.setStyles(scene, 0, words);
    }
  }

  async #fetch(): Promise<void> {
    try {
      this.#absorb = await (await import('./absorb.js')).ready();
      this.#changed(undefined);
    } catch (cause) {
      console.warn(cause);
    }
    this.unready = undefined;
  }

  /** The regions that changed since a version; undefined where they are many. */
  #since(version: number): Set<number> | undefined {
    const changes = this.#changes.slice(version - this.version);
    if (changes.length < this.version - version) return undefined;
    const few = new Set<number>();
    for (const regions of changes) {
      if (!regions) return undefined;
      for (const region of regions) few.add(region);
    }
    return few;
  }

  #changed(regions: number[] | undefined): void {
    this.version++;
    this.#changes.push(regions && regions.length <= FEW ? regions : undefined);
    if (this.#changes.length > FEW) this.#changes.shift();
  }

  /** Writes a region's record: see Style in src/style.rs. */
  #write(words: Uint32Array, at: number, region: number, own: number, ratio: number): void {
    const mark = region === this.#marked ? this.#mark : undefined;
    const layers = [mark, this.#regions.get(region), this.#colors.get(own), this.#all, this.#base];
    const first = <T>(value: (style: Prepared) => T | undefined): T | undefined => {
      for (const layer of layers) {
        const found = layer && value(layer);
        if (found !== undefined) return found;
      }
      return undefined;
    };
    words.fill(0, at, at + 4);
    const visible = first((style) => style.visible);
    if (visible === false) return;
    if (visible === 'absorbed') {
      if (this.#absorb) {
        words[at + 2] = ABSORBED;
        return;
      }
      // Until then it is drawn as itself.
      this.unready ??= this.#fetch();
    }
    let fill = first((style) => style.fill) ?? own;
    const opacity = first((style) => style.opacity) ?? 1;
    if (region === this.#lit || first((style) => style.highlight)) {
      const lighter = (shift: number) => Math.round(((fill >>> shift) & 255) * 0.65 + 89) << shift;
      fill = (fill & 0xff000000) | lighter(16) | lighter(8) | lighter(0);
    }
    const alpha = Math.round((fill >>> 24) * Math.min(Math.max(opacity, 0), 1));
    words[at] = (fill & 0xffffff) | (alpha << 24);
    const outlined = layers.find((layer) => layer?.outline);
    if (outlined?.outline) {
      const { width = 1, unit = 'screen', side = 'centre', group = 0 } = outlined.outline;
      const pixels = unit === 'source' ? width : width * ratio;
      words[at + 1] = outlined.words[0];
      words[at + 2] =
        Math.min(Math.max(Math.round(pixels * 16), 0), 2047) |
        (Math.max(SIDES.indexOf(side), 0) << 11) |
        (unit === 'source' ? 1 << 13 : 0) |
        (Math.min(group, 8191) << 19);
    }
    const patterned = layers.find((layer) => layer?.pattern);
    if (patterned?.pattern) {
      const { motif, spacing = 8 } = patterned.pattern;
      words[at + 2] =
        (words[at + 2] ?? 0) |
        ((MOTIFS.indexOf(motif) + 1) << 14) |
        (Math.min(Math.max(Math.round(Math.log2(spacing)) - 2, 0), 3) << 17);
      words[at + 3] = patterned.words[1];
    }
  }
}

function prepared(style: Style): Prepared {
  const words: Prepared['words'] = [
    style.outline ? rgba(style.outline.color ?? '#000') : 0,
    style.pattern ? rgba(style.pattern.color ?? '#000') : 0,
  ];
  return style.color === undefined ? { ...style, words } : { ...style, fill: rgba(style.color), words };
}

let context: CanvasRenderingContext2D | null | undefined;

/** A CSS colour as a number, red lowest; one that is none is transparent. */
function rgba(css: string): number {
  context ??= document.createElement('canvas').getContext('2d', { willReadFrequently: true });
  if (!context) return 0;
  context.fillStyle = '#0000';
  context.fillStyle = css;
  context.clearRect(0, 0, 1, 1);
  context.fillRect(0, 0, 1, 1);
  const { data } = context.getImageData(0, 0, 1, 1);
  return new DataView(data.buffer).getUint32(0, true);
}

/** Where a number is among others in ascending order. */
function place(numbers: Uint32Array, wanted: number): number | undefined {
  let [low, high] = [0, numbers.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((numbers[middle] ?? 0) < wanted) low = middle + 1;
    else high = middle;
  }
  return numbers[low] === wanted ? low : undefined;
}
