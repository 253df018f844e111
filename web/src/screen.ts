import type { Camera } from '#wasm';
import type { Centre } from './place.js';

/** In device pixels. */
export interface Size {
  width: number;
  height: number;
}

/** A rectangle of a canvas. */
export interface Part extends Size {
  x: number;
  y: number;
}

type Pair = [right: number, down: number];

/** How a frame comes on the canvas. */
export interface Plan extends Size {
  /** How far what is there is moved; nothing of it stays where nothing is said. */
  by: Pair | undefined;
  /** What is drawn then. */
  parts: Part[];
  /** In fewer pixels, each for so many along each axis. */
  step: number;
  /** A little blurred. */
  quick: boolean;
}

/** A frame on the canvas that the next one may be made of. */
interface Kept {
  /** All that it hangs on but the place. */
  of: unknown[];
  /** Where the view was when all of it was drawn, and how far it has been moved since: what is beside whole pixels does not add up. */
  from: Centre;
  moved: Pair;
  quick: boolean;
}

/** A move is one by whole pixels if it is less than so much of one beside them. */
const WHOLE = 1 / 64;

/** What a view is drawn on. A frame that only moves the last one keeps what stays in sight of it. */
export class Screen {
  readonly canvas = document.createElement('canvas');
  readonly #context = this.canvas.getContext('2d');
  #kept: Kept | undefined;

  /** What to draw for a frame that hangs on `of` and the camera. The next may be made of this one, where all that it shows `stays`. */
  plan(
    { width, height }: Size,
    camera: Camera,
    of: unknown[],
    stays: boolean,
    step: number,
    quick: boolean,
  ): Plan {
    const place = camera.place();
    const now = [width, height, camera.scale, place[4], place[5], ...of];
    const last = this.#kept;
    this.#kept = undefined;
    // A blurred frame is of no use for a sharp one.
    if (last && (quick || !last.quick) && now.every((value, i) => value === last.of[i])) {
      const moved = movedBy(last.from, place, camera.scale);
      const [right, down] = [Math.round(moved[0]), Math.round(moved[1])];
      const by: Pair = [right - last.moved[0], down - last.moved[1]];
      const [wide, high] = [width - Math.abs(by[0]), height - Math.abs(by[1])];
      const isWhole = Math.hypot(moved[0] - right, moved[1] - down) < WHOLE;
      if (isWhole && wide > 0 && high > 0 && 2 * wide * high > width * height) {
        if (stays) this.#kept = { ...last, moved: [right, down] };
        const parts = [
          { x: by[0] > 0 ? 0 : wide, y: 0, width: width - wide, height },
          { x: Math.max(by[0], 0), y: by[1] > 0 ? 0 : high, width: wide, height: height - high },
        ].filter(({ width, height }) => width > 0 && height > 0);
        return { width, height, by, parts, step: 1, quick: last.quick };
      }
    }
    if (stays && step === 1) this.#kept = { of: now, from: place, moved: [0, 0], quick };
    return { width, height, by: undefined, parts: [{ x: 0, y: 0, width, height }], step, quick };
  }

  /** The next frame is drawn anew. */
  forget(): void {
    this.#kept = undefined;
  }

  /** Puts there what stays, before anything is drawn. */
  begin({ width, height, by }: Plan): void {
    const { canvas } = this;
    const context = this.#context;
    if (!context) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    context.globalCompositeOperation = 'copy';
    if (by) context.drawImage(canvas, ...by);
    else context.clearRect(0, 0, width, height);
    context.globalCompositeOperation = 'source-over';
  }

  /** Puts a part there that has been drawn. */
  copy({ step }: Plan, part: Part, image: CanvasImageSource): void {
    const { width, height } = coarser(part, step);
    this.#context?.drawImage(image, 0, 0, width, height, part.x, part.y, width * step, height * step);
  }

  clear(): void {
    this.forget();
    this.#context?.clearRect(0, 0, this.canvas.width, this.canvas.height);
  }
}

/** The pixels that a part is drawn in. */
export function coarser({ width, height }: Size, step: number): Size {
  return { width: Math.ceil(width / step), height: Math.ceil(height / step) };
}

/** How far what a view shows is moved on the screen by the time it is at another place. Of close ones the difference has more digits than they. */
function movedBy(from: Centre, [x, y, moreX, moreY, rotation, flipped]: Centre, scale: number): Pair {
  const along = (from[0] - x + (from[2] - moreX)) * (flipped ? -scale : scale);
  const across = (from[1] - y + (from[3] - moreY)) * scale;
  const angle = (rotation * Math.PI) / 180;
  const [sin, cos] = [Math.sin(angle), Math.cos(angle)];
  return [along * cos - across * sin, along * sin + across * cos];
}
