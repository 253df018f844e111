/** Follows which region is under the pointer, also while the view moves under a resting pointer. */
export class Hover {
  #pointer: { x: number; y: number } | undefined;
  #region: number | undefined;
  readonly #changed: (region: number | undefined, left: number | undefined) => void;

  constructor(
    stage: HTMLElement,
    moved: () => void,
    changed: (region: number | undefined, left: number | undefined) => void,
  ) {
    this.#changed = changed;
    stage.addEventListener('pointermove', (event) => {
      this.#pointer = { x: event.clientX, y: event.clientY };
      moved();
    });
    stage.addEventListener('pointerleave', () => {
      this.#pointer = undefined;
      moved();
    });
  }

  update(pick: (clientX: number, clientY: number) => number | undefined): void {
    const region = this.#pointer && pick(this.#pointer.x, this.#pointer.y);
    if (region === this.#region) return;
    const left = this.#region;
    this.#region = region;
    this.#changed(region, left);
  }
}
