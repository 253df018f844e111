/** What gestures ask for, in CSS pixels from the stage's top left corner. */
export interface GestureActions {
  pan(dx: number, dy: number): void;
  /** Whether the view changed: false at the end of the zoom range. */
  zoom(factor: number, x: number, y: number): boolean;
  /** Clockwise, about a place. */
  turn(degrees: number, about: Finger): void;
  /** It has been turned. */
  turned(): void;
  /** A drag with shift spans a box between two places; where it is over, for the last time. */
  box(from: Finger, to: Finger, over: boolean): void;
  /** A short press without a drag. */
  tap(event: PointerEvent): void;
  /** The user took hold of the view, so an animation must stop. */
  grab(): void;
  /** Moves by itself: called every frame with the seconds since the last one, until it returns false. */
  animate(step: (seconds: number) => boolean): void;
}

const DRAG_PX = 4;
const DOUBLE_TAP_MS = 300;
const DOUBLE_TAP_PX = 30;
const DOUBLE_TAP_ZOOM = 2;
/** A finger that rested this long before it was lifted throws nothing. */
const REST_MS = 60;
const FRICTION_PER_SECOND = 5;
const STOP_PX_PER_SECOND = 15;

export interface Finger {
  x: number;
  y: number;
}

const reducedMotion = () => matchMedia('(prefers-reduced-motion: reduce)').matches;

/** A pinch turns from so many degrees on: below, nobody meant to. */
const TWIST_DEGREES = 15;

/** Drag with inertia (with shift: a box; with alt or ctrl: turns about the middle), pinch and twist, double tap (shift zooms out). */
export function listenForGestures(stage: HTMLElement, actions: GestureActions): void {
  const fingers = new Map<number, Finger>();
  let dragged = false;
  /** Where a box was begun. */
  let corner: Finger | undefined;
  /** What is turned about. */
  let hub: Finger | undefined;
  /** Degrees that a pinch has twisted, and whether anything turns. */
  let twist = 0;
  let turning = false;
  let velocity = { x: 0, y: 0, at: 0 };
  let lastTap = { x: 0, y: 0, at: Number.NEGATIVE_INFINITY };

  stage.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    actions.grab();
    stage.setPointerCapture(event.pointerId);
    dragged = fingers.size > 0;
    // A second finger pinches.
    if (corner) actions.box(corner, corner, true);
    corner = event.shiftKey && !dragged ? placeIn(stage, event) : undefined;
    hub =
      (event.altKey || event.ctrlKey) && !dragged
        ? { x: stage.clientWidth / 2, y: stage.clientHeight / 2 }
        : undefined;
    twist = 0;
    fingers.set(event.pointerId, placeIn(stage, event));
    velocity = { x: 0, y: 0, at: event.timeStamp };
  });

  stage.addEventListener('pointermove', (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) return;
    const now = placeIn(stage, event);
    // Small tremors during a click are no drag.
    if (!dragged && Math.hypot(now.x - finger.x, now.y - finger.y) < DRAG_PX) return;
    dragged = true;
    if (corner) {
      actions.box(corner, now, false);
      return;
    }
    stage.toggleAttribute('data-dragging', true);
    if (hub) turn(degreesAbout(hub, finger, now), hub);
    else if (fingers.size === 1) drag(finger, now, event.timeStamp);
    else if (fingers.size === 2) pinch(event.pointerId, finger, now);
    fingers.set(event.pointerId, now);
  });

  const lift = (event: PointerEvent) => {
    if (!fingers.delete(event.pointerId)) return;
    if (turning) actions.turned();
    turning = false;
    if (fingers.size > 0) {
      velocity = { x: 0, y: 0, at: event.timeStamp };
      return;
    }
    stage.toggleAttribute('data-dragging', false);
    const from = corner;
    corner = undefined;
    if (from && dragged) actions.box(from, event.type === 'pointerup' ? placeIn(stage, event) : from, true);
    else if (event.type === 'pointercancel') return;
    else if (dragged && !hub) coast(event.timeStamp);
    else if (!dragged) tap(event);
  };
  stage.addEventListener('pointerup', lift);
  stage.addEventListener('pointercancel', lift);

  function drag(from: Finger, to: Finger, at: number): void {
    const seconds = Math.max(at - velocity.at, 1) / 1000;
    // The mean of old and new speed: single events are too jumpy.
    velocity = {
      x: (velocity.x + (to.x - from.x) / seconds) / 2,
      y: (velocity.y + (to.y - from.y) / seconds) / 2,
      at,
    };
    actions.pan(to.x - from.x, to.y - from.y);
  }

  function pinch(id: number, from: Finger, to: Finger): void {
    const other = [...fingers].find(([key]) => key !== id)?.[1];
    if (!other) return;
    const before = Math.hypot(from.x - other.x, from.y - other.y);
    const after = Math.hypot(to.x - other.x, to.y - other.y);
    actions.pan((to.x - from.x) / 2, (to.y - from.y) / 2);
    if (!(before > 0 && after > 0)) return;
    const middle = { x: (to.x + other.x) / 2, y: (to.y + other.y) / 2 };
    actions.zoom(after / before, middle.x, middle.y);
    const degrees = degreesAbout(other, from, to);
    twist += degrees;
    if (turning || Math.abs(twist) > TWIST_DEGREES) turn(degrees, middle);
  }

  function turn(degrees: number, about: Finger): void {
    turning = true;
    actions.turn(degrees, about);
  }

  function coast(at: number): void {
    if (at - velocity.at > REST_MS || reducedMotion()) return;
    let { x, y } = velocity;
    actions.animate((seconds) => {
      actions.pan(x * seconds, y * seconds);
      const left = Math.exp(-FRICTION_PER_SECOND * seconds);
      x *= left;
      y *= left;
      return Math.hypot(x, y) > STOP_PX_PER_SECOND;
    });
  }

  function tap(event: PointerEvent): void {
    const place = placeIn(stage, event);
    const near = Math.hypot(place.x - lastTap.x, place.y - lastTap.y) < DOUBLE_TAP_PX;
    actions.tap(event);
    if (near && event.timeStamp - lastTap.at < DOUBLE_TAP_MS) {
      lastTap.at = Number.NEGATIVE_INFINITY;
      glide(actions, event.shiftKey ? 1 / DOUBLE_TAP_ZOOM : DOUBLE_TAP_ZOOM, place);
    } else {
      lastTap = { ...place, at: event.timeStamp };
    }
  }
}

/** How far a place goes around another, clockwise. */
function degreesAbout(hub: Finger, from: Finger, to: Finger): number {
  const [x, y, toX, toY] = [from.x - hub.x, from.y - hub.y, to.x - hub.x, to.y - hub.y];
  return (Math.atan2(x * toY - y * toX, x * toX + y * toY) * 180) / Math.PI;
}

const GLIDE_SECONDS = 0.2;

/** Zooms about a place within a moment, or at once where motion is unwanted. */
function glide(actions: GestureActions, factor: number, place: Finger): void {
  if (reducedMotion()) {
    actions.zoom(factor, place.x, place.y);
    return;
  }
  let left = GLIDE_SECONDS;
  actions.animate((seconds) => {
    const part = Math.min(seconds, left);
    left -= part;
    actions.zoom(factor ** (part / GLIDE_SECONDS), place.x, place.y);
    return left > 0;
  });
}

function placeIn(stage: HTMLElement, event: MouseEvent): Finger {
  const box = stage.getBoundingClientRect();
  return { x: event.clientX - box.left, y: event.clientY - box.top };
}
