import type { IStarViewer } from './element.js';
import type { View } from './view.js';
import type { say } from './words.js';

/** What a part of the viewer that is fetched later may use of it. */
export interface Host {
  readonly element: IStarViewer;
  readonly root: ShadowRoot;
  readonly stage: HTMLElement;
  readonly view: View;
  readonly say: typeof say;
  /** Ends what moves by itself. */
  still(): void;
  /** What the file calls a region. */
  named(region: number): string | undefined;
  /** Tells the page of a region. */
  emit(event: 'regionenter' | 'regionleave' | 'regionclick', region: number): void;
  /** Says in the corner which region it is. */
  tell(name: string | undefined, region?: number): void;
}
