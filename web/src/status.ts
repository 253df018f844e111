import type { Backend } from './backend.js';
import { cssColor, make } from './dom.js';

const BACKENDS: Record<Backend, string> = { webgpu: 'WebGPU', webgl2: 'WebGL2', cpu: 'CPU' };

/** The readout in the corner: zoom, region under the pointer, back end. */
export class Status {
  readonly root: HTMLElement;
  readonly #zoom = make('span', 'zoom');
  readonly #swatch = make('span', 'swatch');
  readonly #name = make('span', 'name');
  readonly #region = make('span', 'region', this.#swatch, this.#name);
  readonly #backend = make('span', 'backend');

  constructor() {
    this.root = make('div', 'status', this.#region, this.#zoom, this.#backend);
    this.root.hidden = true;
    this.region(undefined);
  }

  /** CSS pixels of the screen per source pixel. */
  zoom(scale: number): void {
    this.#zoom.textContent = zoomText(scale);
  }

  region(name: string | undefined, color = 0): void {
    this.#region.hidden = !name;
    if (!name) return;
    this.#name.textContent = name;
    this.#swatch.style.backgroundColor = cssColor(color);
  }

  backend(name: Backend): void {
    this.#backend.textContent = BACKENDS[name];
  }
}

/** Three digits are plenty: `0.217×`, `12.5×`, `1240×`. */
export function zoomText(scale: number): string {
  const digits = scale >= 100 ? Math.round(scale) : Number(scale.toPrecision(3));
  return `${digits}×`;
}
