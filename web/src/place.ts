/** Centre in source pixels; `scale` is CSS pixels of the screen per source pixel. */
export interface Place {
  x: number;
  y: number;
  scale: number;
}

/** Centre of a view: whole source pixels x and y, and the fraction of each, in which every digit of a deep view is. */
export type Centre = [x: number, y: number, moreX: number, moreY: number];

/** What `Camera.lookAt` takes. */
export type Sight = [x: number, y: number, scale: number, moreX: number, moreY: number];

const TEXT = /^(\d+)(\.\d+)?,(\d+)(\.\d+)?,([\d.e-]+)$/;

/** `x,y,scale`, with every digit and no more: a place is written as src/places.rs does. */
export function placeText([x, y, moreX, moreY]: Centre, scale: number): string {
  return [decimal(x, moreX), decimal(y, moreY), scale].join();
}

/** What a text of `placeText` says; undefined for any other. */
export function readPlace(text: string): Sight | undefined {
  const parts = TEXT.exec(text)?.slice(1);
  if (!parts) return undefined;
  const [x, moreX, y, moreY, scale] = parts.map((part) => Number(part ?? 0)) as Sight;
  return [x, y, scale, moreX, moreY];
}

function decimal(whole: number, fraction: number): string {
  // `0`, `0.25`, or `2.5e-7`.
  const [digits = '', zeros] = String(fraction).split('e-');
  const more = zeros ? '0'.repeat(Number(zeros) - 1) + digits.replace('.', '') : digits.slice(2);
  return whole + (more && `.${more}`);
}
