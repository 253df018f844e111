/** What is as far from the window as that is near: of the window's size, in each direction. */
const NEAR = '100%';

/** Waits until a figure comes near the window. */
export class Approach {
  readonly #figure: Element;
  readonly #observer: IntersectionObserver;
  #then: (() => void) | undefined;

  constructor(figure: Element) {
    this.#figure = figure;
    this.#observer = new IntersectionObserver(
      (entries) => {
        if (entries.at(-1)?.isIntersecting) this.now();
      },
      { rootMargin: NEAR },
    );
  }

  wait(then: () => void): void {
    this.#then = then;
    this.#observer.observe(this.#figure);
  }

  /** Does what was waited with, if anything is. */
  now(): void {
    const then = this.#then;
    this.stop();
    then?.();
  }

  stop(): void {
    this.#then = undefined;
    this.#observer.disconnect();
  }
}
