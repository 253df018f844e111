export interface KeyActions {
  pan(dx: number, dy: number): void;
  /** About the middle. */
  zoomBy(factor: number): void;
  fit(): void;
  turn(degrees: number): void;
  flip(): void;
  /** Goes from region to region from now on. */
  walk(): void;
}

const STEP_PX = 64;
export const STEP_ZOOM = 1.5;

/**
 * Arrows move the view (the picture goes the other way), + and − zoom, 0 and Home show all, r and R turn, f mirrors, Enter begins a walk.
 */
export function listenForKeys(stage: HTMLElement, actions: KeyActions): void {
  const keys: Record<string, () => void> = {
    ArrowLeft: () => actions.pan(STEP_PX, 0),
    ArrowRight: () => actions.pan(-STEP_PX, 0),
    ArrowUp: () => actions.pan(0, STEP_PX),
    ArrowDown: () => actions.pan(0, -STEP_PX),
    '+': () => actions.zoomBy(STEP_ZOOM),
    // The key of + without shift on many keyboards.
    '=': () => actions.zoomBy(STEP_ZOOM),
    '-': () => actions.zoomBy(1 / STEP_ZOOM),
    _: () => actions.zoomBy(1 / STEP_ZOOM),
    '0': () => actions.fit(),
    Home: () => actions.fit(),
    r: () => actions.turn(90),
    R: () => actions.turn(-90),
    f: () => actions.flip(),
    Enter: () => actions.walk(),
  };
  stage.addEventListener('keydown', (event) => {
    const act = keys[event.key];
    // With a modifier these are the browser's own: ctrl and + zooms the page, alt and an arrow goes back.
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  });
}
