// The view, or all of the picture, as lines and areas. A part of dist/istar-export.js.
import type { PictureOptions } from './element.js';
import type { Scene } from './engine.js';
import { ViewerError } from './errors.js';
import type { TracingJob } from './fitting.js';
import { type Centre, placeText, readPlace } from './place.js';
import type { View } from './view.js';

/** Of all of a picture the tiles are taken that would be drawn in so many pixels a side. */
const MOST_DRAWN = 4096;
/** Where nothing is drawn. */
const NOWHERE: Scene = { bytes: 0, free() {} };
/** Pixels of a side that a page may have. */
const MOST = 65_536;

export async function tracedView(view: View, options: PictureOptions): Promise<Blob> {
  const { file, canvas } = view;
  const sight = readPlace(view.text);
  if (!file || !sight) throw new Error('There is no picture.');
  const { type = '', whole } = options;
  const [fullWidth, fullHeight] = [file.archive.width, file.archive.height];
  const [ownWidth, ownHeight] = whole ? [fullWidth, fullHeight] : [canvas.clientWidth, canvas.clientHeight];
  const shape = ownWidth / ownHeight;
  const width = Math.round(options.width ?? (options.height ? options.height * shape : ownWidth));
  const height = Math.round(options.height ?? width / shape);
  for (const side of [width, height]) {
    if (!(side >= 1 && side <= MOST)) {
      const message = `A page of ${width} × ${height} pixels cannot be made: each side has 1 to ${MOST}.`;
      throw new ViewerError('limit', message);
    }
  }
  const fineness = Math.min(width / ownWidth, height / ownHeight);
  const [centre, ownScale]: [Centre, number] = whole
    ? [[fullWidth / 2, fullHeight / 2, 0, 0, 0, 0], 1]
    : sight;
  const scale = ownScale * fineness;
  const part = Math.min(1, MOST_DRAWN / (whole ? Math.max(fullWidth, fullHeight) : Math.max(width, height)));
  const drawn = whole ? { width: fullWidth, height: fullHeight } : { width, height };
  const tiles = await tilesOf(
    view,
    Math.ceil(drawn.width * part),
    Math.ceil(drawn.height * part),
    placeText(centre, (whole ? 1 : scale) * part),
    whole ? 1 : fineness,
  );
  const names = await file.named;
  const module = await import('./fitting.js').catch((cause) => {
    throw new ViewerError('network', 'The encoder could not be fetched.', cause);
  });
  const job: TracingJob = { type, tiles, names, width, height, scale, centre };
  const bytes = await module.fitted(job, new AbortController().signal);
  return new Blob([bytes as Uint8Array<ArrayBuffer>], { type });
}

/** The finest tiles of a view in so many pixels, once they are there, with their styles. */
async function tilesOf(
  view: View,
  width: number,
  height: number,
  place: string,
  fineness: number,
): Promise<TracingJob['tiles']> {
  // It draws in CSS pixels.
  const all = view.tiles;
  const twin = view.twin({ width, height }, 1, (twin) => {
    twin.text = place;
  });
  if (!twin || !all) throw new Error('There is no picture.');
  try {
    await twin.settled();
    const finest = Math.min(...twin.drawn.map(({ id }) => id.level));
    return twin.drawn
      .filter(({ id }) => id.level === finest)
      .map((loaded) => {
        const { level, x, y, key, head, bytes } = loaded.id;
        let words = new Uint32Array();
        const setStyles = (_: Scene, __: number, records: Uint32Array) => {
          words = records.slice();
        };
        // As if for another renderer.
        const anew = { ...loaded };
        delete anew.styled;
        view.styles.apply(anew, NOWHERE, { setStyles }, fineness, all);
        return { level, x, y, key, head, bytes: bytes.slice(), words };
      });
  } finally {
    twin.clear();
  }
}
