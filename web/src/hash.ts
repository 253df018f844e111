const QUIET_MS = 300;

/**
 * Keeps a view in the fragment of the page's address, as `name=x,y,scale`: read when there is a picture and whenever the fragment
 * changes, written a moment after the view has. Other parts of the fragment stay. A view of the whole picture needs no words.
 */
export class Hash {
  readonly #text: () => string;
  readonly #show: (text: string) => void;
  #key: string | undefined;
  #timer: ReturnType<typeof setTimeout> | undefined;
  readonly #read = () => this.read();

  constructor(text: () => string, show: (text: string) => void) {
    this.#text = text;
    this.#show = show;
  }

  /** Under that name from now on; `view` where it is empty, nowhere where there is none. */
  follow(name: string | null): void {
    clearTimeout(this.#timer);
    removeEventListener('hashchange', this.#read);
    this.#key = name === null ? undefined : `${encodeURIComponent(name || 'view')}=`;
    if (this.#key) addEventListener('hashchange', this.#read);
  }

  read(): void {
    const key = this.#key;
    if (!key) return;
    const part = parts().find((part) => part.startsWith(key));
    // Some programs through which links go encode commas.
    const text = part?.slice(key.length).replaceAll('%2C', ',');
    if (text && text !== this.#text()) this.#show(text);
  }

  /** The view has changed. */
  write(): void {
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#write(this.#text()), QUIET_MS);
  }

  /** Another picture comes, to which the view does not belong. */
  forget(): void {
    clearTimeout(this.#timer);
    this.#write('');
  }

  #write(text: string): void {
    const key = this.#key;
    if (!key) return;
    const others = parts().filter((part) => !part.startsWith(key));
    const url = new URL(location.href);
    url.hash = [...others, ...(text ? [key + text] : [])].join('&');
    try {
      // Not a step to go back to.
      history.replaceState(history.state, '', url);
    } catch {
      // Where the address may not be changed, or not as often, it stays.
    }
  }
}

function parts(): string[] {
  return location.hash.slice(1).split('&').filter(Boolean);
}
