// What a program may say, and what not.
import { type Failure, type IStarViewer, type NamedRegion, type StyleSheet, settings } from 'istar';
import { IStarViewer as Defined } from 'istar/element';
import { IStarViewer as Inlined } from 'istar/inlined';
import type { IStarLegend } from 'istar/legend';

settings.wasmUrl = new URL('https://example.org/istar_bg.wasm');
export const same: (typeof IStarViewer)[] = [Defined, Inlined];

const viewer = document.createElement('istar-viewer');
export const legend: IStarLegend | null = document.querySelector('istar-legend');
viewer.src = 'map.istar';
viewer.zoomTo(1, 2, 3);
viewer.setStyle([1, 2], { color: 'tomato', pattern: { motif: 'dots' } });
export const styles: StyleSheet = viewer.styles;
export const blob: Promise<Blob> = viewer.toBlob();

const told = ({ region, name }: NamedRegion) => `${region} ${name ?? ''}`;
viewer.addEventListener('regionclick', (event) => told(event.detail));
viewer.addEventListener('viewchange', ({ detail }) => detail.x + detail.scale);
viewer.addEventListener('error', ({ detail }: CustomEvent<Failure>) => detail.kind === 'network');
viewer.addEventListener('click', (event) => event.clientX);
viewer.addEventListener('something-else', () => {});

// @ts-expect-error: a style has no such colour.
viewer.setStyle(1, { color: 3 });
// @ts-expect-error: there is no such motif.
viewer.setStyle(1, { pattern: { motif: 'stars' } });
// @ts-expect-error: that event tells of no region.
viewer.addEventListener('viewchange', (event) => event.detail.region);
// @ts-expect-error: what draws is not set so.
viewer.backend = 'webgpu';
