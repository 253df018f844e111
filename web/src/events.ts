// What the viewer tells, by the events' names.
import type { ErrorKind } from './errors.js';
import type { Place } from './place.js';
import type { Progress } from './source.js';

/** A region of the picture, and what the file calls it, if it does. */
export interface NamedRegion {
  region: number;
  name: string | undefined;
}

/** A region that is in view, and its colour in the file, as CSS has it. */
export interface ShownRegion extends NamedRegion {
  color: string;
}

/** What went wrong, and a sentence that says more. */
export interface Failure {
  kind: ErrorKind;
  message: string;
}

/** None of them bubbles. */
export interface ViewerEvents {
  load: CustomEvent<undefined>;
  progress: CustomEvent<Progress>;
  error: CustomEvent<Failure>;
  viewchange: CustomEvent<Place>;
  regionenter: CustomEvent<NamedRegion>;
  regionleave: CustomEvent<NamedRegion>;
  regionclick: CustomEvent<NamedRegion>;
}

/** All events of the element, the browser's own included. */
export type ViewerEventMap = Omit<HTMLElementEventMap, keyof ViewerEvents> & ViewerEvents;

/** An element whose listeners know what they are told. */
export interface ViewerElement extends HTMLElement {
  addEventListener<Name extends keyof ViewerEventMap>(
    type: Name,
    listener: (this: this, event: ViewerEventMap[Name]) => unknown,
    options?: boolean | AddEventListenerOptions,
  ): void;
  addEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | AddEventListenerOptions,
  ): void;
  removeEventListener<Name extends keyof ViewerEventMap>(
    type: Name,
    listener: (this: this, event: ViewerEventMap[Name]) => unknown,
    options?: boolean | EventListenerOptions,
  ): void;
  removeEventListener(
    type: string,
    listener: EventListenerOrEventListenerObject,
    options?: boolean | EventListenerOptions,
  ): void;
}
