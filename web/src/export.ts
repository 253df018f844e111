// The view as a picture of any size, or as lines. A module of its own, fetched where one is asked for: dist/istar-export.js.
import { blobOf } from './blob.js';
import type { PictureOptions } from './element.js';
import { ViewerError } from './errors.js';
import type { Place } from './place.js';
import { tracedView } from './tracing.js';
import { inPicture, onScreen } from './turn.js';
import type { View } from './view.js';

/** What every browser has as a canvas, and every device draws at once. */
const MOST = 16384;
const AT_ONCE = 2048;

export async function exported(view: View, options: PictureOptions): Promise<Blob> {
  return /svg|app/.test(options.type ?? '')
    ? tracedView(view, options)
    : blobOf(await pictureOf(view, options), options);
}

/** The view in the middle of a picture: as large as fits, and more around where the shape is another; as large as on the screen unless told. */
async function pictureOf(view: View, options: PictureOptions): Promise<HTMLCanvasElement> {
  const { clientWidth, clientHeight } = view.canvas;
  const shape = clientWidth / clientHeight;
  const width = Math.round(options.width ?? (options.height ?? view.canvas.height) * shape);
  const height = Math.round(options.height ?? width / shape);
  for (const side of [width, height]) {
    if (!(side >= 1 && side <= MOST)) {
      const message = `A picture of ${width} × ${height} pixels cannot be made: each side has 1 to ${MOST}.`;
      throw new ViewerError('limit', message);
    }
  }
  const picture = document.createElement('canvas');
  Object.assign(picture, { width, height });
  const context = picture.getContext('2d');
  if (options.type === 'image/jpeg' && context) {
    // It has no transparency, and black is nobody's paper.
    context.fillStyle = '#fff';
    context.fillRect(0, 0, width, height);
  }
  const fineness = Math.min(width / clientWidth, height / clientHeight);
  // The view may be moved meanwhile.
  const { text, place, file } = view;
  if (!place || !file) throw new Error('There is no picture.');
  const drawn = { ...place, scale: place.scale * fineness };
  for (const { from, own, over } of pieces([width, height], drawn, file.archive)) {
    const size = { width: own[0] + 2 * Math.abs(over[0]), height: own[1] + 2 * Math.abs(over[1]) };
    const piece = view.twin(size, fineness, (twin) => {
      twin.text = text;
      twin.pan(
        (width / 2 - from[0] - own[0] / 2 - over[0]) / fineness,
        (height / 2 - from[1] - own[1] / 2 - over[1]) / fineness,
      );
    });
    if (!piece) throw new Error('There is no picture.');
    try {
      await piece.settled();
      const [x, y] = from;
      const skipped = [Math.max(-2 * over[0], 0), Math.max(-2 * over[1], 0)] as const;
      context?.drawImage(piece.canvas, ...skipped, ...own, x, y, ...own);
    } finally {
      piece.clear();
    }
  }
  return picture;
}

type Pair = [along: number, down: number];

/** A part of a picture, in its pixels. */
interface Piece {
  from: Pair;
  own: Pair;
  /** The middle of what is drawn for it is so far from its own: drawn is so much more on that side, and as much on the other. */
  over: Pair;
}

/**
 * Cuts a picture where there is anything to see. A camera's middle cannot leave what it looks at: a piece whose own does is drawn
 * larger.
 */
function* pieces(
  [width, height]: Pair,
  place: Place,
  extent: { width: number; height: number },
): Iterable<Piece> {
  for (let y = 0; y < height; y += AT_ONCE) {
    for (let x = 0; x < width; x += AT_ONCE) {
      const own: Pair = [Math.min(AT_ONCE, width - x), Math.min(AT_ONCE, height - y)];
      const middle = { x: x + (own[0] - width) / 2, y: y + (own[1] - height) / 2 };
      const way = inPicture(place, middle);
      const [sourceX, sourceY] = [place.x + way.x, place.y + way.y];
      const back = onScreen(place, {
        x: inside(sourceX, extent.width, place.scale) - sourceX,
        y: inside(sourceY, extent.height, place.scale) - sourceY,
      });
      // The picture is convex: its nearest place is that far, and the piece reaches half of itself that way.
      const far = Math.hypot(back.x, back.y);
      const reach = (Math.abs(back.x) * own[0] + Math.abs(back.y) * own[1]) / 2;
      if (far * far > reach + 4 * far) continue;
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
