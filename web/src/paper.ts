import type { View } from './view.js';

/** Dots of paper for a CSS pixel: 300 an inch. */
const FINENESS = 300 / 96;
/** What every device can draw. */
const MOST = 8192;

/** Lays a finer picture over a view's own while the page is printed. */
export class Paper {
  readonly #view: View;
  #fine: View | undefined;
  readonly #swap = ({ type }: Event) => {
    this.#fine?.clear();
    this.#fine = undefined;
    if (type === 'beforeprint') this.#lay();
  };

  constructor(view: View) {
    this.#view = view;
  }

  watch(on: boolean): void {
    for (const name of ['beforeprint', 'afterprint'])
      (on ? addEventListener : removeEventListener)(name, this.#swap);
  }

  /** At once: the browser waits for nobody. */
  #lay(): void {
    const { clientWidth, clientHeight } = this.#view.canvas;
    const fineness = Math.min(FINENESS, MOST / Math.max(clientWidth, clientHeight));
    const [width, height] = [Math.round(clientWidth * fineness), Math.round(clientHeight * fineness)];
    this.#fine = this.#view.twin({ width, height }, fineness);
    if (this.#fine) this.#view.canvas.after(this.#fine.canvas);
  }
}
