// Pictures that are drawn piece by piece.

/** A part of a picture along an axis, in its pixels. */
export interface Piece {
  from: number;
  length: number;
  /** What is drawn for it, of which the first are skipped, and the middle of that from the middle of the picture. */
  drawn: number;
  skipped: number;
  middle: number;
}

/**
 * Cuts a picture into parts of `atOnce`, where there is anything to see; its middle is `at` in the source. A camera's middle cannot leave what it looks at (`extent` source pixels): a piece
 * whose own does is drawn larger.
 */
export function pieces(length: number, atOnce: number, at: number, extent: number, scale: number): Piece[] {
  const found: Piece[] = [];
  for (let from = 0; from < length; from += atOnce) {
    const own = Math.min(atOnce, length - from);
    const middle = from + own / 2 - length / 2;
    const place = at + middle / scale;
    const over = Math.ceil(Math.max(place - extent, -place, 0) * scale);
    if (over > own / 2) continue;
    const isAfter = place > extent;
    found.push({
      from,
      length: own,
      drawn: own + 2 * over,
      skipped: isAfter ? 2 * over : 0,
      middle: middle + (isAfter ? -over : over),
    });
  }
  return found;
}
