import type { GestureActions } from './gestures.js';

/** Pixels that a browser which counts in lines or pages would have scrolled. */
const LINE_PX = 16;
const PAGE_PX = 400;
/** Doublings per wheel pixel; a trackpad's pinch comes as small steps with ctrl held. */
const WHEEL_RATE = 0.003;
const PINCH_RATE = 0.01;
/** Some mice report a fast turn as one huge step. */
const MAX_STEP_PX = 300;
/** Wheel events closer than this belong to one turn of the wheel. */
const TURN_MS = 250;

let pageScrolledAt = Number.NEGATIVE_INFINITY;
let listening = false;

/**
 * The wheel zooms about the pointer. It leaves the page's own scrolling alone: a turn that began outside goes on scrolling when a
 * figure slides under the pointer, and a turn that can zoom no further scrolls the page.
 */
export function listenForWheel(stage: HTMLElement, actions: GestureActions): void {
  let zoomedAt = Number.NEGATIVE_INFINITY;
  watchPageScroll();
  stage.addEventListener(
    'wheel',
    (event) => {
      if (!event.ctrlKey && event.timeStamp - pageScrolledAt < TURN_MS) {
        pageScrolledAt = event.timeStamp;
        return;
      }
      const box = stage.getBoundingClientRect();
      actions.grab();
      if (actions.zoom(zoomFactor(event), event.clientX - box.left, event.clientY - box.top)) {
        zoomedAt = event.timeStamp;
      }
      // With ctrl held the browser would zoom the whole page.
      if (event.ctrlKey || event.timeStamp - zoomedAt < TURN_MS) event.preventDefault();
    },
    { passive: false },
  );
}

function zoomFactor(event: WheelEvent): number {
  const unit = [1, LINE_PX, PAGE_PX][event.deltaMode] ?? 1;
  const step = Math.max(-MAX_STEP_PX, Math.min(MAX_STEP_PX, event.deltaY * unit));
  return 2 ** (-step * (event.ctrlKey ? PINCH_RATE : WHEEL_RATE));
}

function watchPageScroll(): void {
  if (listening) return;
  listening = true;
  const note = (event: WheelEvent) => {
    if (!event.composedPath().some((node) => (node as Element).localName === 'istar-viewer')) {
      pageScrolledAt = event.timeStamp;
    }
  };
  window.addEventListener('wheel', note, { passive: true, capture: true });
}
