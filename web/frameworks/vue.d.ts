// The elements in templates. In one file of a project: import type {} from 'istar/vue'
import type { DefineComponent, HTMLAttributes } from 'vue';
import type { LegendAttributes, ViewerAttributes, ViewerEvents } from './index.js';

/** As templates listen: `@regionclick`. */
type Listeners = {
  [Name in keyof ViewerEvents as `on${Capitalize<Name>}`]?: (event: ViewerEvents[Name]) => void;
};
type Tag<Attributes> = DefineComponent<Omit<HTMLAttributes, keyof Attributes> & Attributes>;

declare module 'vue' {
  interface GlobalComponents {
    'istar-viewer': Tag<ViewerAttributes & Listeners>;
    'istar-legend': Tag<LegendAttributes>;
  }
}
