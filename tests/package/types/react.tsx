import type {} from 'istar/react';

export const figure = (
  <istar-viewer
    src="map.istar"
    alt="A map"
    interactive
    hash="map"
    className="wide"
    ref={(viewer) => viewer?.fit()}
    onregionclick={({ detail }) => detail.region.toFixed()}
    onload={(event) => event.type}
  >
    <img src="map.png" alt="A map" />
  </istar-viewer>
);
export const legend = <istar-legend for="world" />;
// @ts-expect-error: there is no such back end.
export const wrong = <istar-viewer src="map.istar" backend="vulkan" />;
