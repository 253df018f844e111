import type { Tile } from '#wasm';
import type { Point } from './turn.js';
import type { View } from './view.js';

/** A region that another one borders on, and where. */
export interface Neighbour {
  region: number;
  /** The middles of the cells in which both are. */
  border: Point[];
  /** The middle of these. */
  middle: Point;
}

/** A place of a region: the middle of a cell that is all its own, where there is one, and of those the nearest to the middle of all. */
interface Spot extends Point {
  /** Source pixels of such cells; less than one where there is none. */
  area: number;
}

interface Border {
  regions: [number, number];
  cells: Point[];
}

/** What cells tell of a tile, asked once. */
interface Known {
  spots: Map<number, Spot>;
  borders: Border[];
}

/** In place of the region of a ghost, which is none. */
const NONE = 2 ** 32 - 1;
/** Two regions as one number: there are fewer than so many. */
const REGIONS = 2 ** 25;
/** What a pixel counts that several regions may have, beside one that a region surely has. */
const DOUBTFUL = 1e-6;

const known = new WeakMap<Tile, Known>();

function ask(view: View): Known[] {
  const { file, drawn } = view;
  if (!file) return [];
  return drawn.map(({ tile }) => {
    const found = known.get(tile) ?? survey(tile, file.archive);
    known.set(tile, found);
    return found;
  });
}

/** Goes through a tile's cells twice: the second time it is known where the middle of each region is. */
function survey(tile: Tile, picture: { width: number; height: number }): Known {
  const cells = tile.cells();
  const sums = new Map<number, Spot>();
  const spots = new Map<number, Spot & { away: number }>();
  const borders = new Map<number, Border>();
  for (const [a, b] of pairs(tile.edges())) {
    if (a === NONE || b === NONE || a === b) continue;
    borders.set(keyOf(a, b), { regions: [a, b], cells: [] });
  }
  each(cells, picture, (middle, area, regions) => {
    for (const [i, region] of regions.entries()) {
      const sum = sums.get(region) ?? { x: 0, y: 0, area: 0 };
      const weight = regions.length === 1 ? area : area * DOUBTFUL;
      sums.set(region, {
        x: sum.x + weight * middle.x,
        y: sum.y + weight * middle.y,
        area: sum.area + weight,
      });
      for (const other of regions.subarray(i + 1)) {
        borders.get(keyOf(region, other))?.cells.push(middle);
      }
    }
  });
  each(cells, picture, (middle, _, regions) => {
    for (const region of regions) {
      const { x = 0, y = 0, area = 1 } = sums.get(region) ?? {};
      // A doubtful cell is further away than any that is not.
      const doubt = regions.length === 1 ? 0 : 1e12;
      const away = Math.hypot(middle.x - x / area, middle.y - y / area) + doubt;
      if (away < (spots.get(region)?.away ?? Number.POSITIVE_INFINITY))
        spots.set(region, { ...middle, area, away });
    }
  });
  return { spots, borders: [...borders.values()].filter(({ cells }) => cells.length > 0) };
}

/** Tells the middle of each cell, its area and whose it may be. The last cells may reach beyond the picture. */
function each(
  cells: Uint32Array,
  { width, height }: { width: number; height: number },
  tell: (middle: Point, area: number, regions: Uint32Array) => void,
): void {
  for (let at = 0; at < cells.length; ) {
    const [x = 0, y = 0, side = 0, count = 0] = cells.subarray(at, at + 4);
    const [right, lower] = [Math.min(x + side, width), Math.min(y + side, height)];
    const regions = cells.subarray(at + 4, at + 4 + count).filter((region) => region !== NONE);
    if (x < right && y < lower)
      tell({ x: (x + right) / 2, y: (y + lower) / 2 }, (right - x) * (lower - y), regions);
    at += 4 + count;
  }
}

function* pairs(edges: Uint32Array): Generator<[number, number]> {
  for (let at = 0; at < edges.length; at += 2) yield [edges[at] ?? NONE, edges[at + 1] ?? NONE];
}

function keyOf(a: number, b: number): number {
  return Math.min(a, b) * REGIONS + Math.max(a, b);
}

/** A place in a region, in the tile that has most of it. */
export function spotOf(view: View, region: number): Point | undefined {
  const spots = ask(view).flatMap(({ spots }) => spots.get(region) ?? []);
  return spots.sort((a, b) => b.area - a.area)[0];
}

/** The region whose place is nearest to a point. */
export function nearestTo(view: View, { x, y }: Point): number | undefined {
  let least = Number.POSITIVE_INFINITY;
  let nearest: number | undefined;
  for (const [region, spot] of ask(view).flatMap(({ spots }) => [...spots])) {
    const away = Math.hypot(spot.x - x, spot.y - y);
    if (away >= least) continue;
    least = away;
    nearest = view.styles.absorbed.get(region) ?? region;
  }
  return nearest;
}

/** The regions on which one borders, those with the longest border first. */
export function neighboursOf(view: View, region: number): Neighbour[] {
  const { absorbed } = view.styles;
  const found = new Map<number, Point[]>();
  for (const { regions, cells } of ask(view).flatMap(({ borders }) => borders)) {
    const [a = NONE, b = NONE] = regions.map((one) => absorbed.get(one) ?? one);
    if (a === b || (a !== region && b !== region)) continue;
    const other = a === region ? b : a;
    found.set(other, [...(found.get(other) ?? []), ...cells]);
  }
  const around = [...found].map(([region, border]) => ({ region, border, middle: middleOf(border) }));
  return around.sort((a, b) => b.border.length - a.border.length);
}

export function middleOf(cells: Point[]): Point {
  const mean = (axis: 'x' | 'y') => cells.reduce((sum, cell) => sum + cell[axis], 0) / cells.length;
  return { x: mean('x'), y: mean('y') };
}

/** The neighbour nearest in a direction (one of x and y is 1 or -1), within 45° of it. */
export function nearestTowards(around: Neighbour[], from: Point, towards: Point): Neighbour | undefined {
  let least = Number.POSITIVE_INFINITY;
  let best: Neighbour | undefined;
  for (const neighbour of around) {
    for (const { x, y } of neighbour.border) {
      const along = (x - from.x) * towards.x + (y - from.y) * towards.y;
      const aside = Math.abs((x - from.x) * towards.y + (y - from.y) * towards.x);
      if (aside > along || along + aside >= least) continue;
      least = along + aside;
      best = neighbour;
    }
  }
  return best;
}
