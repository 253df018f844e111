import type { Hash } from './hash.js';
import { missing } from './missing.js';

/** So long a picture waits for what reads addresses, in ms: what comes later moves the view, if nobody has. */
const PATIENCE = 3000;

/** A view in the page's address: what keeps it there is fetched when somebody asks for it. */
export class Address {
  readonly #text: () => string;
  readonly #show: (text: string) => void;
  #name: string | null = null;
  #hash: Hash | undefined;
  #coming: Promise<void> | undefined;
  /** The view when it was to be read, and could not yet. */
  #asked: string | undefined;

  constructor(text: () => string, show: (text: string) => void) {
    this.#text = text;
    this.#show = show;
  }

  /** Under that name from now on; nowhere where there is none. */
  follow(name: string | null): void {
    this.#name = name;
    this.#hash?.follow(name);
    if (name !== null) this.#coming ??= this.#fetch().catch(missing);
  }

  /** Settled when what was asked for is there, or takes too long. */
  get ready(): Promise<unknown> | undefined {
    return this.#coming && Promise.race([this.#coming, new Promise((go) => setTimeout(go, PATIENCE))]);
  }

  read(): void {
    this.#asked = this.#text();
    this.#hash?.read();
  }

  /** The view has changed. */
  write(): void {
    this.#hash?.write();
  }

  /** Another picture comes, to which the view does not belong. */
  forget(): void {
    this.#hash?.forget();
  }

  async #fetch(): Promise<void> {
    const { Hash } = await import('./hash.js');
    this.#hash = new Hash(this.#text, this.#show);
    this.#hash.follow(this.#name);
    // Who has moved it since wants to be where it is.
    if (this.#asked === this.#text()) this.#hash.read();
  }
}
