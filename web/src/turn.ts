// From the picture to the screen and back, for what stands beside the picture and what walks in it.
import type { Place } from './place.js';

/** In source pixels, or in CSS pixels of the screen. */
export interface Point {
  x: number;
  y: number;
}

/** A way in the picture as one on the screen, in CSS pixels. */
export function onScreen({ rotation, flipped, scale }: Place, { x, y }: Point): Point {
  const [cos, sin] = unit(rotation);
  const right = flipped ? -x : x;
  return { x: scale * (cos * right - sin * y), y: scale * (sin * right + cos * y) };
}

/** The other way round. */
export function inPicture({ rotation, flipped, scale }: Place, { x, y }: Point): Point {
  const [cos, sin] = unit(rotation);
  const right = cos * x + sin * y;
  return { x: (flipped ? -right : right) / scale, y: (cos * y - sin * x) / scale };
}

/** Cosine and sine, exact for quarters of a turn. */
function unit(degrees: number): [cos: number, sin: number] {
  const angle = (degrees * Math.PI) / 180;
  return degrees % 90 === 0
    ? [Math.round(Math.cos(angle)), Math.round(Math.sin(angle))]
    : [Math.cos(angle), Math.sin(angle)];
}
