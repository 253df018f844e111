import { make, slot } from './dom.js';

/** What stands in for the picture until it is there: an image inside the element, or one that its attribute names. */
export class Poster {
  readonly root: HTMLElement;
  readonly #element: HTMLElement;
  readonly #image = make('img', 'poster');

  /** `changed`: there is another image, or it is known how large it is. */
  constructor(element: HTMLElement, changed: () => void) {
    this.#element = element;
    // What the picture shows, the stage says.
    this.#image.alt = '';
    this.#image.loading = 'lazy';
    this.#image.addEventListener('load', changed);
    this.root = make('div', '', this.#image, slot('poster'), slot(''));
    this.root.addEventListener('slotchange', changed);
    this.update();
  }

  /** The attribute may have changed. */
  update(): void {
    const url = this.#element.getAttribute('poster');
    this.#image.hidden = !url;
    if (url) this.#image.src = url;
    else this.#image.removeAttribute('src');
  }

  /** The picture is there, or is not. */
  cover(on: boolean): void {
    this.root.toggleAttribute('data-covered', on);
  }

  get alt(): string {
    return this.#inside?.alt ?? '';
  }

  /** Its shape, which is the picture's, as CSS has it; undefined where it is not known. */
  get shape(): string | undefined {
    const inside = this.#inside;
    const sides = inside
      ? ['width', 'height'].map((name) => Number(inside.getAttribute(name)))
      : [this.#image.naturalWidth, this.#image.naturalHeight];
    return sides.every((side) => side > 0) ? sides.join(' / ') : undefined;
  }

  get #inside(): HTMLImageElement | undefined {
    const images = [...this.#element.querySelectorAll('img')];
    return images.find((image) => !image.closest('[slot]:not([slot="poster"])'));
  }
}
