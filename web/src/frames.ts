/** Runs one animation at a time; a new one, or stop(), ends the old. */
export class Frames {
  #frame = 0;

  run(step: (seconds: number) => boolean): void {
    this.stop();
    let last = performance.now();
    const tick = (now: number) => {
      // A tab that was in the background must not jump.
      const seconds = Math.min(Math.max(now - last, 0) / 1000, 0.1);
      last = now;
      this.#frame = step(seconds) ? requestAnimationFrame(tick) : 0;
    };
    this.#frame = requestAnimationFrame(tick);
  }

  stop(): void {
    cancelAnimationFrame(this.#frame);
    this.#frame = 0;
  }
}
