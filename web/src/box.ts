import { make } from './dom.js';

/** The box that a drag with shift spans. */
export class Box {
  readonly root = make('div', 'box');

  constructor() {
    this.hide();
  }

  /** From corner to corner, in CSS pixels of the stage. */
  show(left: number, top: number, width: number, height: number): void {
    this.root.hidden = false;
    this.root.style.cssText = `left:${left}px;top:${top}px;width:${width}px;height:${height}px`;
  }

  hide(): void {
    this.root.hidden = true;
  }
}
