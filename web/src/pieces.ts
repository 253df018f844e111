// Pictures that are drawn piece by piece.
import type { Place } from './place.js';
import { inPicture, onScreen } from './turn.js';

export type Pair = [along: number, down: number];

/** A part of a picture, in its pixels. */
export interface Piece {
  from: Pair;
  own: Pair;
  /** The middle of what is drawn for it is so far from its own: drawn is so much more on that side, and as much on the other. */
  over: Pair;
}

/**
 * Cuts a picture with a place in its middle into parts of `atOnce`, where there is anything to see. A camera's middle cannot leave what it
 * looks at (`extent` source pixels): a piece whose own does is drawn larger.
 */
export function* pieces(
  [width, height]: Pair,
  [across, down]: Pair,
  place: Place,
  extent: { width: number; height: number },
): Iterable<Piece> {
  for (let y = 0; y < height; y += down) {
    for (let x = 0; x < width; x += across) {
      const own: Pair = [Math.min(across, width - x), Math.min(down, height - y)];
      const middle = { x: x + (own[0] - width) / 2, y: y + (own[1] - height) / 2 };
      const way = inPicture(place, middle);
      const [sourceX, sourceY] = [place.x + way.x, place.y + way.y];
      const back = onScreen(place, {
        x: inside(sourceX, extent.width, place.scale) - sourceX,
        y: inside(sourceY, extent.height, place.scale) - sourceY,
      });
      // Nothing of the picture is much nearer than that.
      if (Math.hypot(back.x, back.y) > Math.hypot(...own) / 2 + 4) continue;
      yield { from: [x, y], own, over: [away(back.x), away(back.y)] };
    }
  }
}

/** The nearest place that is so far inside that whole pixels, in any direction, do not lead out again. */
function inside(along: number, extent: number, scale: number): number {
  const rim = Math.min(2 / scale, extent / 2);
  return Math.min(Math.max(along, rim), extent - rim);
}

/** Whole pixels, away from zero. */
function away(by: number): number {
  return Math.sign(by) * Math.ceil(Math.abs(by));
}
