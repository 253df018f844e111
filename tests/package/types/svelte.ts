import type {} from 'istar/svelte';
import type { SvelteHTMLElements } from 'svelte/elements';

export const figure: SvelteHTMLElements['istar-viewer'] = {
  src: 'map.istar',
  alt: 'A map',
  interactive: true,
  class: 'wide',
  onregionclick: ({ detail }) => detail.region.toFixed(),
  onload: (event) => event.type,
};
// @ts-expect-error: there is no such back end.
export const wrong: SvelteHTMLElements['istar-viewer'] = { backend: 'vulkan' };
export const legend: SvelteHTMLElements['istar-legend'] = { for: 'world' };
