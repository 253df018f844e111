/**
 * Centre in source pixels; `scale` is CSS pixels of the screen per source pixel. `rotation` is degrees clockwise, from 0 to below 360;
 * before it is turned the picture is mirrored, left to right, where it is `flipped`.
 */
export interface Place {
  x: number;
  y: number;
  scale: number;
  rotation: number;
  flipped: boolean;
}

/**
 * Centre of a view: whole source pixels x and y, and the fraction of each, in which every digit of a deep view is; and how the picture
 * lies: degrees, and 1 where it is mirrored.
 */
export type Centre = [x: number, y: number, moreX: number, moreY: number, rotation: number, flipped: number];

const TEXT = /^(\d+)(\.\d+)?,(\d+)(\.\d+)?,([\d.e-]+)(?:,([\d.e-]+)(,flipped)?)?$/;

/** `x,y,scale`, with every digit and no more: a place is written as src/places.rs does. Turned, `,rotation`; then `,flipped`. */
export function placeText([x, y, moreX, moreY, rotation, flipped]: Centre, scale: number): string {
  const text = [decimal(x, moreX), decimal(y, moreY), scale].join();
  return rotation || flipped ? `${text},${rotation}${flipped ? ',flipped' : ''}` : text;
}

/** What a text of `placeText` says: centre and scale; undefined for any other. */
export function readPlace(text: string): [centre: Centre, scale: number] | undefined {
  const parts = TEXT.exec(text)?.map((part) => part ?? 0);
  if (!parts) return undefined;
  const [, x, moreX, y, moreY, scale, rotation] = parts.map(Number) as [0, ...Centre, number];
  return [[x, y, moreX, moreY, rotation, parts[7] ? 1 : 0], scale];
}

function decimal(whole: number, fraction: number): string {
  // `0`, `0.25`, or `2.5e-7`.
  const [digits = '', zeros] = String(fraction).split('e-');
  const more = zeros ? '0'.repeat(Number(zeros) - 1) + digits.replace('.', '') : digits.slice(2);
  return whole + (more && `.${more}`);
}
