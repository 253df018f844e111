// The elements' attributes, for those who write them in a framework's templates.
import type { Backend } from './backend.js';

/** Of `<istar-viewer>`. */
export interface ViewerAttributes {
  /** Where the picture is. */
  src?: string | undefined;
  /** What the picture shows, in words. */
  alt?: string | undefined;
  /** Where an image is that stands in until the picture is there. */
  poster?: string | undefined;
  /** `use-credentials`: another site's server is sent its cookies, too. Said before the picture is fetched. */
  crossorigin?: 'anonymous' | 'use-credentials' | '' | undefined;
  /** `eager`: the picture is fetched at once; else when the figure comes near the window. */
  loading?: 'auto' | 'lazy' | 'eager' | undefined;
  /** The region under the pointer is highlighted. */
  interactive?: boolean | '' | undefined;
  /** Lines along all boundaries: a width in CSS pixels and a colour, as `2 white`; else 1 and black. */
  outline?: boolean | string | undefined;
  /** By so many degrees the picture is turned at first, clockwise. */
  rotation?: number | string | undefined;
  /** It is mirrored, left to right, before it is turned. */
  flipped?: boolean | '' | undefined;
  /** Buttons: zoom, all of it, turn, mirror, full screen, save. */
  controls?: boolean | '' | undefined;
  /** An overview: a drag in it moves the view. */
  navigator?: boolean | '' | undefined;
  /** How long something is. */
  scalebar?: boolean | '' | undefined;
  /** What the scale bar counts; else source pixels. */
  unit?: string | undefined;
  /** So many of them are a source pixel long. */
  'unit-per-pixel'?: number | string | undefined;
  /** The view is kept in the page's address, as `#view=x,y,scale` or under the name that is given. */
  hash?: boolean | string | undefined;
  /** What draws; else the first that works. */
  backend?: Backend | undefined;
}

/** Of `<istar-legend>`. */
export interface LegendAttributes {
  /** The id of the viewer; else the one that it is in, or the first of the page. */
  for?: string | undefined;
  /** The viewer's styles are kept in the page's address, under that name; `styles` where it is empty. */
  hash?: string | undefined;
}
