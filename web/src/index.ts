// `istar`: for programs, which give the element its name. Importing it changes no page.

export type { LegendAttributes, ViewerAttributes } from './attributes.js';
export type { Backend } from './backend.js';
export { IStarViewer, type PictureOptions } from './element.js';
export type { ErrorKind } from './errors.js';
export type { Failure, NamedRegion, ShownRegion, ViewerEventMap, ViewerEvents } from './events.js';
export { settings } from './fetched.js';
export type { Place } from './place.js';
export type { Progress, RangeResponse, Source } from './source.js';
export type { Outline, Pattern, Style, StyleSheet } from './style.js';
export type { Words } from './words.js';
