/** A frame that comes later than this after it was asked for is late. */
const LATE_MS = 25;
/** A view rests that has not been moved for so long. */
const REST_MS = 120;
const COARSEST = 3;

/**
 * How finely to draw while the view moves: where frames come late, first less sharply, then with fewer pixels; as well as can be
 * once it rests.
 */
export class Pace {
  readonly #rest: () => void;
  #asked = 0;
  #done = Number.NEGATIVE_INFINITY;
  #late = 0;
  #step = 1;
  #timer: ReturnType<typeof setTimeout> | undefined;

  /** `rest` is called when all pixels are due. */
  constructor(rest: () => void) {
    this.#rest = rest;
  }

  /** The view was moved. */
  moved(): void {
    this.#asked ||= performance.now();
  }

  /** A frame is drawn now: so many device pixels are to be as one, along each axis. */
  next(): number {
    const now = performance.now();
    const asked = this.#asked || now;
    if (asked - this.#done > REST_MS) this.#late = 0;
    else if (now - asked > LATE_MS) this.#late++;
    // One late frame says little.
    this.#step = Math.min(1 + (this.#late >> 1), COARSEST);
    this.#asked = 0;
    clearTimeout(this.#timer);
    return this.#step;
  }

  /** The frame that is drawn now is to be quick. */
  get isQuick(): boolean {
    return this.#late > 0;
  }

  /** It is on the screen. */
  drawn(): void {
    this.#done = performance.now();
    if (this.isQuick) this.#timer = setTimeout(this.#rest, REST_MS + 1);
  }
}
