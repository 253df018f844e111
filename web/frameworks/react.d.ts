// The elements in JSX. In one file of a project: import type {} from 'istar/react'
import type { DetailedHTMLProps, HTMLAttributes } from 'react';
import type { IStarViewer, LegendAttributes, ViewerAttributes, ViewerEvents } from './index.js';
import type { IStarLegend } from './legend.js';

/** As React 19 listens: `onregionclick` is `addEventListener('regionclick')`. */
type Listeners = { [Name in keyof ViewerEvents as `on${Name}`]?: (event: ViewerEvents[Name]) => void };
type Tag<Element, Attributes> = Omit<DetailedHTMLProps<HTMLAttributes<Element>, Element>, keyof Attributes> &
  Attributes;

declare module 'react' {
  namespace JSX {
    interface IntrinsicElements {
      'istar-viewer': Tag<IStarViewer, ViewerAttributes & Listeners>;
      'istar-legend': Tag<IStarLegend, LegendAttributes>;
    }
  }
}
