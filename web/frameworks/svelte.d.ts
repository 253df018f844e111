// The elements in Svelte's markup. In one file of a project: import type {} from 'istar/svelte'
import type { HTMLAttributes } from 'svelte/elements';
import type { IStarViewer, LegendAttributes, ViewerAttributes, ViewerEvents } from './index.js';
import type { IStarLegend } from './legend.js';

/** As Svelte 5 listens: `onregionclick`. */
type Listeners = { [Name in keyof ViewerEvents as `on${Name}`]?: (event: ViewerEvents[Name]) => void };
type Tag<Element, Attributes> = Omit<HTMLAttributes<Element & EventTarget>, keyof Attributes> & Attributes;

declare module 'svelte/elements' {
  interface SvelteHTMLElements {
    'istar-viewer': Tag<IStarViewer, ViewerAttributes & Listeners>;
    'istar-legend': Tag<IStarLegend, LegendAttributes>;
  }
}
