import { make } from './dom.js';
import type { Host } from './host.js';
import type { Place } from './place.js';
import type { View } from './view.js';

/** The longer side, and what a figure must have of room for it to be of use. */
const LONGER_PX = 140;
const LEAST_ROOM = 2;
/** It is drawn anew when no frame has come for so long: all of a picture may take many times as long as a piece of it. */
const REST_MS = 200;

/** All of the picture, small, with a frame around what the view shows: a press or a drag moves the view there. */
export class Overview {
  readonly root = make('div', 'overview');
  readonly #frame = make('div', 'frame');
  readonly #host: Host;
  #small: View | undefined;
  #drawn = -1;
  #timer: ReturnType<typeof setTimeout> | undefined;

  constructor(host: Host) {
    this.#host = host;
    this.root.append(this.#frame);
    // What it is for, keys do on the stage.
    this.root.ariaHidden = 'true';
    const drag = (event: PointerEvent) => {
      if (!this.root.hasPointerCapture(event.pointerId)) return;
      const { place } = host.view;
      const [width, height] = this.#size();
      if (!place || !width || !height) return;
      const box = this.root.getBoundingClientRect();
      const x = ((event.clientX - box.left - this.root.clientLeft) / this.root.clientWidth) * width;
      const y = ((event.clientY - box.top - this.root.clientTop) / this.root.clientHeight) * height;
      host.still();
      host.view.lookAt(x, y, place.scale);
    };
    this.root.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      // No text is selected, and the stage keeps the focus.
      event.preventDefault();
      this.root.setPointerCapture(event.pointerId);
      drag(event);
    });
    this.root.addEventListener('pointermove', drag);
  }

  /** Hidden without a place. */
  update(place: Place | undefined): void {
    const { view } = this.#host;
    const { file } = view;
    // What the pointer lights up is told by the view.
    const look = view.styles.version - view.styles.lights;
    const room = view.canvas.clientWidth;
    const [width, height] = this.#size();
    const isShown = !!place && !!file && room >= LEAST_ROOM * LONGER_PX;
    this.root.hidden = !isShown;
    clearTimeout(this.#timer);
    if (!isShown || !place) {
      this.#small?.clear();
      this.#small = undefined;
      return;
    }
    const shrink = LONGER_PX / Math.max(width, height);
    // A very long one must still be seen.
    const [w, h] = [Math.max(width * shrink, 8), Math.max(height * shrink, 8)];
    this.root.style.width = `${w}px`;
    this.root.style.height = `${h}px`;
    if (this.#small?.file !== file) {
      this.#small?.clear();
      this.#small = view.twin();
      this.#drawn = look;
      if (this.#small) this.root.prepend(this.#small.canvas);
    }
    // Regions may look otherwise than when it was drawn.
    if (this.#drawn !== look)
      this.#timer = setTimeout(() => {
        this.#drawn = look;
        this.#small?.redraw();
      }, REST_MS);
    if (place.rotation || place.flipped) {
      // Turned as the view is, the other way round.
      const [wide, high] = [room, view.canvas.clientHeight].map((seen) => (seen / place.scale) * shrink);
      Object.assign(this.#frame.style, {
        left: `${(100 * place.x) / width}%`,
        top: `${(100 * place.y) / height}%`,
        width: `${wide}px`,
        height: `${high}px`,
        transform: `translate(-50%, -50%) rotate(${place.flipped ? place.rotation : -place.rotation}deg)`,
      });
      return;
    }
    const part = (middle: number, seen: number, all: number) => {
      const from = Math.max(0, (middle - seen / place.scale / 2) / all);
      const to = Math.min(1, (middle + seen / place.scale / 2) / all);
      return [`${100 * from}%`, `${100 * Math.max(to - from, 0)}%`];
    };
    const [left = '', wide = ''] = part(place.x, room, width);
    const [top = '', high = ''] = part(place.y, view.canvas.clientHeight, height);
    Object.assign(this.#frame.style, { left, top, width: wide, height: high, transform: '' });
  }

  /** Source pixels of the picture. */
  #size(): [width: number, height: number] {
    const archive = this.#host.view.file?.archive;
    return [archive?.width ?? 0, archive?.height ?? 0];
  }
}
