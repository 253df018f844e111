// What stands beside the picture: buttons, scale bar, overview. A module of its own, fetched where an attribute asks for one:
// dist/istar-controls.js.
import { adopt } from './adopt.js';
import { Buttons } from './buttons.js';
import css from './controls.css';
import type { Host } from './host.js';
import { Overview } from './overview.js';
import { ScaleBar } from './scalebar.js';

export class Controls {
  readonly #host: Host;
  readonly #buttons: Buttons;
  readonly #scaleBar: ScaleBar;
  readonly #overview: Overview;

  constructor(host: Host) {
    this.#host = host;
    this.#buttons = new Buttons(host);
    this.#scaleBar = new ScaleBar(host);
    this.#overview = new Overview(host);
    adopt(host.root, css);
    host.stage.after(this.#overview.root, this.#scaleBar.root, this.#buttons.root);
  }

  /** After every frame, and where an attribute has changed. */
  update(): void {
    const { element, view } = this.#host;
    // Asked once: the figure is measured for it.
    const { place } = view;
    const wanted = (name: string) => (element.hasAttribute(name) ? place : undefined);
    this.#buttons.update(wanted('controls'));
    this.#scaleBar.update(wanted('scalebar'));
    this.#overview.update(wanted('navigator'));
  }
}
