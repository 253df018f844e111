import { make, slot } from './dom.js';
import type { ErrorKind, ViewerError } from './errors.js';
import { type Progress, sizeText } from './source.js';
import { say } from './words.js';

const TITLES: Record<ErrorKind, string> = {
  network: 'The picture could not be loaded.',
  http: 'The picture could not be loaded.',
  aborted: 'Loading was stopped.',
  changed: 'The picture could not be loaded.',
  malformed: 'This file is damaged or is not an IStar picture.',
  unsupported: 'This picture cannot be shown here.',
  limit: 'This picture is too large to show.',
  gpu: 'The picture could not be drawn.',
};

/** What stands in place of the picture: progress while it loads, or what went wrong. */
export class Message {
  readonly root: HTMLElement;
  readonly #text = make('span', 'loading');
  readonly #bar = make('div', 'bar', make('div', 'fill'));
  readonly #progress = slot('progress', make('div', 'progress', this.#text, this.#bar));
  readonly #title = make('p', 'title');
  readonly #detail = make('p', 'detail');
  readonly #retry = make('button', 'retry');
  readonly #error = make('div', 'error');

  constructor(retry: () => void) {
    this.#bar.role = 'progressbar';
    // Empty until there is an error: only what is added to an alert is read out.
    this.#error.role = 'alert';
    this.#retry.type = 'button';
    this.#retry.addEventListener('click', retry);
    this.root = make('div', 'message', this.#progress, this.#error);
    this.clear();
  }

  clear(): void {
    this.root.hidden = true;
    this.#progress.hidden = true;
    this.#error.replaceChildren();
  }

  loading(progress: Progress): void {
    const { loaded, total } = progress;
    const share = total ? loaded / total : undefined;
    this.#text.textContent = total
      ? say('Loading: {loaded} of {total}', { loaded: sizeText(loaded), total: sizeText(total) })
      : `${say('Loading')}${loaded > 0 ? `: ${sizeText(loaded)}` : ''}`;
    this.#bar.ariaLabel = say('Loading');
    // Without a value a progress bar is indeterminate.
    this.#bar.ariaValueNow = share === undefined ? null : String(Math.round(share * 100));
    this.#bar.toggleAttribute('data-unknown', share === undefined);
    this.#progress.style.setProperty('--istar-share', String(share ?? 1));
    this.#error.replaceChildren();
    this.#progress.hidden = false;
    this.root.hidden = false;
  }

  error(error: ViewerError): void {
    this.#progress.hidden = true;
    this.#title.textContent = say(TITLES[error.kind]);
    this.#detail.textContent = error.message;
    this.#retry.textContent = say('Retry');
    this.#error.replaceChildren(this.#title, this.#detail, this.#retry);
    this.root.hidden = false;
  }
}
