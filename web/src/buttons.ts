import { download, make } from './dom.js';
import type { Host } from './host.js';
import { STEP_ZOOM } from './keyboard.js';
import type { Place } from './place.js';

/** As paths in a square of 16. */
const ICONS = {
  in: 'M8 3v10M3 8h10',
  out: 'M3 8h10',
  whole: 'M3 6V3h3M10 3h3v3M13 10v3h-3M6 13H3v-3',
  turn: 'M12.5 10A5 5 0 1 1 13 6.5M13 3v3.5H9.5',
  mirror: 'M8 2v12M5.5 4.5L2 11.5h3.5zM10.5 4.5L14 11.5h-3.5z',
  upright: 'M8 2.5L4.5 13 8 11l3.5 2z',
  full: 'M9 7l4-4m-3.5 0H13v3.5M7 9l-4 4m3.5 0H3V9.5',
  leave: 'M13 3L9 7m0-3.5V7h3.5M3 13l4-4m0 3.5V9H3.5',
  save: 'M8 2v8m-3-3l3 3 3-3M3 13h10',
};

/** Zoom, all of the picture, how it lies, full screen, and the view as a file. */
export class Buttons {
  readonly root = make('div', 'controls');
  readonly #host: Host;
  readonly #upright: HTMLButtonElement;
  readonly #full: HTMLButtonElement;

  constructor(host: Host) {
    this.#host = host;
    const { element, view, say } = host;
    this.root.role = 'group';
    this.root.ariaLabel = say('Controls');
    this.#add('in', 'Zoom in', () => view.zoomAboutMiddle(STEP_ZOOM));
    this.#add('out', 'Zoom out', () => view.zoomAboutMiddle(1 / STEP_ZOOM));
    this.#add('whole', 'Show all', () => view.fit());
    this.#add('turn', 'Turn clockwise', () => view.turnBy(90));
    this.#add('mirror', 'Mirror', () => view.flip());
    this.#upright = this.#add('upright', 'Upright again', () => view.turn(0, false));
    this.#full = this.#add('full', 'Full screen', () => this.#toggleFull());
    this.#add('save', 'Save as picture', () => this.#save());
    // Telephones have none for elements.
    this.#full.hidden = !document.fullscreenEnabled;
    element.addEventListener('fullscreenchange', () => {
      const isFull = element.matches(':fullscreen');
      this.#dress(this.#full, isFull ? 'leave' : 'full', isFull ? 'Leave full screen' : 'Full screen');
    });
  }

  /** Shows whether, and how far, the picture is turned. Hidden without a place. */
  update(place: Place | undefined): void {
    this.root.hidden = !place;
    if (!place) return;
    const { rotation, flipped } = place;
    const isUpright = rotation === 0 && !flipped;
    // It would take the focus with it.
    if (isUpright && this.#host.root.activeElement === this.#upright) this.#host.stage.focus();
    this.#upright.hidden = isUpright;
    // Where its top has gone.
    this.#upright.style.setProperty('--turn', `${rotation}deg`);
    const said = `${this.#host.say('Upright again')} (${Math.round(rotation)}°)`;
    this.#upright.title = said;
    this.#upright.ariaLabel = said;
  }

  #add(icon: keyof typeof ICONS, label: string, act: () => void): HTMLButtonElement {
    const button = make('button', 'control');
    button.type = 'button';
    button.addEventListener('click', () => {
      this.#host.still();
      act();
    });
    this.#dress(button, icon, label);
    this.root.append(button);
    return button;
  }

  #dress(button: HTMLButtonElement, icon: keyof typeof ICONS, label: string): void {
    const [svg, path] = ['svg', 'path'].map((name) =>
      document.createElementNS('http://www.w3.org/2000/svg', name),
    );
    if (!svg || !path) return;
    svg.setAttribute('viewBox', '0 0 16 16');
    svg.setAttribute('aria-hidden', 'true');
    path.setAttribute('d', ICONS[icon]);
    svg.append(path);
    button.replaceChildren(svg);
    button.title = this.#host.say(label);
    button.ariaLabel = button.title;
  }

  async #toggleFull(): Promise<void> {
    const { element } = this.#host;
    try {
      if (element.matches(':fullscreen')) await document.exitFullscreen();
      else await element.requestFullscreen();
    } catch (cause) {
      // A frame may not be allowed to.
      console.warn(cause);
    }
  }

  async #save(): Promise<void> {
    const { element } = this.#host;
    try {
      download(await element.toBlob(), `${fileName(element.source?.getKey() ?? element.src)}.png`);
    } catch (cause) {
      console.warn(cause);
    }
  }
}

/** Of an address the last part, without its ending. */
function fileName(url: string): string {
  const last = url.split(/[?#]/)[0]?.split('/').at(-1) ?? '';
  return last.replace(/\.\w+$/, '') || 'picture';
}
