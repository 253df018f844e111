// The script of pages, and `istar/element`: `<istar-viewer>` as a tag.
import { IStarViewer } from './element.js';

if (globalThis.customElements && !customElements.get('istar-viewer')) {
  customElements.define('istar-viewer', IStarViewer);
}

export type * from './index.js';
export { IStarViewer };
