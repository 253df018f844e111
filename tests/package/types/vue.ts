import type {} from 'istar/vue';
import type { GlobalComponents } from 'vue';

type Props = InstanceType<GlobalComponents['istar-viewer']>['$props'];

export const figure: Props = {
  src: 'map.istar',
  alt: 'A map',
  interactive: true,
  class: 'wide',
  onRegionclick: ({ detail }) => detail.region.toFixed(),
};
// @ts-expect-error: there is no such back end.
export const wrong: Props = { backend: 'vulkan' };
export const legend: InstanceType<GlobalComponents['istar-legend']>['$props'] = { for: 'world' };
