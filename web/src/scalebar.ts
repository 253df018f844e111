import { make } from './dom.js';
import type { Host } from './host.js';
import type { Place } from './place.js';

/** It is as long as that at most, and 0.4 of it at least. */
const MOST_PX = 110;

/** How long something is: in source pixels, or in the unit that the page gives with `unit` and `unit-per-pixel`. */
export class ScaleBar {
  readonly root = make('div', 'scalebar');
  readonly #host: Host;
  #said = '';

  constructor(host: Host) {
    this.#host = host;
    this.root.role = 'img';
  }

  /** Hidden without a place. */
  update(place: Place | undefined): void {
    const { element, say } = this.#host;
    this.root.hidden = !place;
    if (!place) return;
    const { scale } = place;
    const perPixel = Number(element.getAttribute('unit-per-pixel') ?? 1);
    // Nonsense is as if nothing was said.
    const unit = perPixel > 0 && perPixel < Number.POSITIVE_INFINITY ? perPixel : 1;
    const length = roundLength((MOST_PX / scale) * unit);
    this.root.style.width = `${(length / unit) * scale}px`;
    const text = `${numberText(length, element)} ${element.getAttribute('unit') ?? say('px')}`;
    if (text === this.#said) return;
    this.#said = text;
    this.root.textContent = text;
    this.root.ariaLabel = say('Scale: the bar is {length} long', { length: text });
  }
}

/** The greatest of 1, 2 and 5 times a power of ten that is no more. */
export function roundLength(most: number): number {
  const power = 10 ** Math.floor(Math.log10(most));
  return power * ([5, 2].find((digit) => digit * power <= most) ?? 1);
}

/** In the language of the element, as short as it goes. */
function numberText(number: number, element: HTMLElement): string {
  const isPlain = number >= 1e-3 && number < 1e6;
  const format = {
    maximumSignificantDigits: 1,
    notation: isPlain ? 'standard' : 'scientific',
  } as const;
  const language = element.closest<HTMLElement>('[lang]')?.lang || undefined;
  try {
    return new Intl.NumberFormat(language, format).format(number);
  } catch {
    // There is no such language.
    return new Intl.NumberFormat(undefined, format).format(number);
  }
}
