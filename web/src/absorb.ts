// Which regions absorb others. A module of its own, fetched only where styles ask for it: dist/istar-absorb.js. Who absorbs whom is told
// by the encoder's module: src/absorb.rs.
import { Borders } from '#encoder';
import { loadEncoder } from './encoder.js';
import type { Renderer, Scene } from './engine.js';
import { ABSORBED } from './style.js';
import type { Styles } from './styles.js';
import type { Loaded, Tiles } from './tiles.js';

/** What is known of a tile: how long boundaries are, and the last answer. */
interface Known {
  borders: Borders;
  absorbed: Uint32Array;
  told: Uint32Array;
  /** Regions and their absorbers, in turn. */
  pairs: Uint32Array;
}

const knowledge = new WeakMap<object, Known>();
/** What `styles.absorbed` was made for. */
const made = new WeakMap<Styles, { version: number; tiles: Tiles }>();

/** Brings what tells. */
export async function ready(): Promise<typeof absorb> {
  await loadEncoder();
  return absorb;
}

/**
 * Completes the records of a tile's regions that are absorbed, and says in `styles.absorbed` by which others. The coarsest tiles tell
 * first, so that all others agree; what these do not show the tile tells itself.
 */
export function absorb(
  words: Uint32Array,
  loaded: Loaded,
  tiles: Tiles,
  styles: Styles,
  ratio: number,
): void {
  const { version } = styles;
  const before = made.get(styles);
  if (before?.version !== version || before.tiles !== tiles) styles.absorbed.clear();
  made.set(styles, { version, tiles });
  const last = tiles.file.archive.levels - 1;
  const coarsest =
    loaded.id.level === last ? [] : [...tiles.there.values()].filter(({ id }) => id.level === last);
  // Once they are there, this is done again.
  if (loaded.id.level !== last && coarsest.length === 0) delete loaded.styled;
  const ids = regionsOf(loaded);
  const places = new Map<number, number>();
  ids.forEach((region, i) => void places.set(region, i));
  const told: number[] = [];
  /** What has its absorber in another tile, and who that is: it is drawn by a record of its own that says the same. */
  const elsewhere = new Map<number, number>();
  /** Of several the first stands for it, lest there be outlines between them. */
  const standIns = new Map<number, number>();
  for (const { pairs, recordOf } of coarsest.map((other) => tellingOf(other, tiles, styles, ratio))) {
    for (const [region, absorber] of inTwos(pairs)) {
      const place = places.get(region);
      if (place === undefined) continue;
      styles.absorbed.set(region, absorber);
      const standIn = places.has(absorber) ? absorber : standIns.get(absorber);
      if (standIn !== undefined) told.push(region, standIn);
      else {
        standIns.set(absorber, region);
        words.set(recordOf(absorber), 4 * place);
        elsewhere.set(region, absorber);
      }
    }
  }
  const own = new Map(inTwos(pairsOf(loaded, words, told)));
  for (const [region, absorber] of own) styles.absorbed.set(region, elsewhere.get(absorber) ?? absorber);
  ids.forEach((region, i) => {
    if (words[4 * i + 2] !== ABSORBED) return;
    const place = places.get(own.get(region) ?? -1);
    // Nobody absorbs it: it is not seen.
    if (place === undefined) words[4 * i + 2] = 0;
    else words[4 * i] = place;
  });
}

/** What a coarse tile tells: who absorbs whom, and the records of those. It may not be drawn: its records go nowhere. */
function tellingOf(
  other: Loaded,
  tiles: Tiles,
  styles: Styles,
  ratio: number,
): { pairs: Uint32Array; recordOf: (region: number) => Uint32Array } {
  const { styled, ...unstyled } = other;
  let records = new Uint32Array();
  const nowhere = {
    setStyles(_: Scene, __: number, words: Uint32Array<ArrayBuffer>) {
      records = words;
    },
  };
  styles.apply(unstyled, {} as Scene, nowhere as unknown as Renderer, ratio, tiles);
  const ids = regionsOf(other);
  const recordOf = (region: number) => {
    const at = 4 * ids.indexOf(region);
    return records.subarray(at, at + 4);
  };
  return { pairs: knowledge.get(other.tile)?.pairs ?? new Uint32Array(), recordOf };
}

function* inTwos(numbers: Uint32Array): Generator<[number, number]> {
  for (let i = 0; i < numbers.length; i += 2) yield [numbers[i] ?? 0, numbers[i + 1] ?? 0];
}

function pairsOf(loaded: Loaded, words: Uint32Array, alreadyTold: number[]): Uint32Array {
  const absorbed = regionsOf(loaded).filter((_, i) => words[4 * i + 2] === ABSORBED);
  const told = Uint32Array.from(alreadyTold);
  const { tile, id } = loaded;
  const known = knowledge.get(tile);
  if (absorbed.length === 0 && !known) return absorbed;
  if (known && isSame(known.absorbed, absorbed) && isSame(known.told, told)) return known.pairs;
  const borders = known?.borders ?? Borders.read(id.head, id.level, id.x, id.y, id.bytes);
  const pairs = borders.absorbers(absorbed, told);
  knowledge.set(tile, { borders, absorbed, told, pairs });
  return pairs;
}

function regionsOf(loaded: Loaded): Uint32Array {
  loaded.regions ??= loaded.tile.regions();
  return loaded.regions.subarray(0, loaded.regions.length / 2);
}

function isSame(a: Uint32Array, b: Uint32Array): boolean {
  return a.length === b.length && a.every((number, i) => number === b[i]);
}
