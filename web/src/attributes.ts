// The elements' attributes, for those who write them in a framework's templates.
import type { Backend } from './backend.js';

/** Of `<istar-viewer>`. */
export interface ViewerAttributes {
  /** Where the picture is. */
  src?: string | undefined;
  /** What the picture shows, in words. */
  alt?: string | undefined;
  /** The region under the pointer is highlighted. */
  interactive?: boolean | '' | undefined;
  /** The view is kept in the page's address, as `#view=x,y,scale` or under the name that is given. */
  hash?: boolean | string | undefined;
  /** What draws; else the first that works. */
  backend?: Backend | undefined;
}

/** Of `<istar-legend>`. */
export interface LegendAttributes {
  /** The id of the viewer; else the first of the page. */
  for?: string | undefined;
}
