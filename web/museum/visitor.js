// Who walks through the hall: by keys, by mouse or finger, to a picture, or along a path.
import { DEPTH, DOOR, END, halfSize, PICTURES, ROOMS, WALL, WIDTH } from './hall.js';
import { add, mix, scale, towards } from './vectors.js';

const EYES = 1.62;
/** Metres a second, and radians. */
const WALK = 2.4;
const TURN = 1.5;
/** No nearer to walls than that. */
const BODY = 0.35;
/** Seconds that a way to a picture takes. */
const GOING = 1.8;

/** Where the tour leads: a place, a picture or a place that is looked at, and the seconds until the next. */
const TOUR = [
  { at: [0, -1.2], look: [0, 1.7, -12], seconds: 6 },
  { at: [-1.3, -4.1], look: PICTURES[0].at, seconds: 6 },
  { at: [-3.9, -2.4], look: PICTURES[0].at, seconds: 5 },
  { at: [0.2, -6.4], look: PICTURES[1].at, seconds: 6 },
  { at: [0, -9.6], look: [0, 1.2, -16], seconds: 5 },
  { at: [0.4, -11.4], look: [0, 0, -14.6], seconds: 6 },
  { at: [-3.6, -12], look: PICTURES[2].at, seconds: 6 },
  { at: [3.7, -15.2], look: PICTURES[3].at, seconds: 6 },
  { at: [0, -19.2], look: PICTURES[6].at, seconds: 6 },
  { at: [0.3, -23.2], look: PICTURES[6].at, seconds: 6 },
  { at: [4.3, -27.1], look: [-1, 2.1, END], seconds: 6 },
  { at: [-1.5, -25.6], look: PICTURES[4].at, seconds: 6 },
  { at: [1.5, -22.4], look: PICTURES[5].at, seconds: 6 },
  { at: [0, -18], look: [0, 1.6, -8], seconds: 5 },
  { at: [3.9, -14.5], look: [0, 0, -14.2], seconds: 6 },
  { at: [0, -9.3], look: [0, 1.6, 0], seconds: 6 },
];

/** How one has to turn to look at a place. */
function facing([x, y, z], [toX, toY, toZ]) {
  const flat = Math.hypot(toX - x, toZ - z);
  return { turn: Math.atan2(toX - x, z - toZ), tilt: Math.atan2(toY - y, flat) };
}

/** The angle nearest to another one, of those that are the same. */
function near(angle, other) {
  return angle + 2 * Math.PI * Math.round((other - angle) / (2 * Math.PI));
}

function smooth(t) {
  const kept = Math.min(Math.max(t, 0), 1);
  return kept * kept * (3 - 2 * kept);
}

export class Visitor {
  at = [0, EYES, -1.2];
  turn = 0;
  tilt = 0;
  isOnTour = false;
  /** The picture that was gone to last, until one goes elsewhere or looks away. */
  goal;
  #keys = new Set();
  #tour = 0;
  #going;

  /** Whether it is on the move. */
  get isMoving() {
    return this.isOnTour || this.#keys.size > 0 || this.#going !== undefined;
  }

  /** A key that walks or turns, by its code; whether it is one. */
  key(code, isDown) {
    const known = [
      'KeyW',
      'KeyA',
      'KeyS',
      'KeyD',
      'ArrowUp',
      'ArrowDown',
      'ArrowLeft',
      'ArrowRight',
      'KeyQ',
      'KeyE',
    ];
    if (!known.includes(code)) return false;
    if (isDown) {
      this.stop();
      this.#keys.add(code);
    } else this.#keys.delete(code);
    return true;
  }

  /** No key is held any longer. */
  release() {
    this.#keys.clear();
  }

  stop() {
    this.isOnTour = false;
    this.goal = undefined;
    this.#going = undefined;
  }

  look(turn, tilt) {
    this.stop();
    this.turn += turn;
    this.tilt = Math.min(Math.max(this.tilt + tilt, -1.2), 1.2);
  }

  /** Forwards and to the right, in metres. */
  walk(forwards, right) {
    const [x, , z] = towards(this.turn, 0);
    this.#to(this.at[0] + x * forwards - z * right, this.at[2] + z * forwards + x * right);
  }

  /** Goes before a picture; `atOnce` without a way there. */
  visit(index, atOnce) {
    this.stop();
    this.goal = index;
    const picture = PICTURES[index];
    const [half, halfY] = halfSize(picture);
    const away = picture.flat ? 0 : Math.max(half, halfY * 1.35) * 1.45 + 0.3;
    const before = picture.flat
      ? [0, 0, picture.at[2] + picture.height / 2 + 1]
      : add(picture.at, scale(picture.normal, away));
    const at = [before[0], EYES, before[2]];
    const { turn, tilt } = facing(at, picture.at);
    const going = { from: this.#pose, to: { at, turn: near(turn, this.turn), tilt }, seconds: 0 };
    if (atOnce) this.#stand(going.to);
    else this.#going = going;
  }

  tour() {
    this.stop();
    this.isOnTour = true;
    // From where one is, on with the stop that is nearest.
    const distance = ({ at: [x, z] }) => Math.hypot(x - this.at[0], z - this.at[2]);
    const nearest = TOUR.indexOf(
      TOUR.reduce((best, stop) => (distance(stop) < distance(best) ? stop : best)),
    );
    this.#tour = TOUR.slice(0, nearest).reduce((sum, { seconds }) => sum + seconds, 0);
  }

  /** Time goes by. */
  step(seconds) {
    if (this.isOnTour) this.#stepTour(seconds);
    else if (this.#going) this.#stepGoing(seconds);
    const held = (...codes) => (codes.some((code) => this.#keys.has(code)) ? 1 : 0);
    const forwards = held('KeyW', 'ArrowUp') - held('KeyS', 'ArrowDown');
    const right = held('KeyD') - held('KeyA');
    if (forwards || right) this.walk(forwards * WALK * seconds, right * WALK * seconds);
    this.turn += (held('ArrowRight', 'KeyE') - held('ArrowLeft', 'KeyQ')) * TURN * seconds;
  }

  #stepTour(seconds) {
    this.#tour += seconds;
    const all = TOUR.reduce((sum, { seconds }) => sum + seconds, 0);
    let left = this.#tour % all;
    let i = 0;
    while (left > TOUR[i].seconds) {
      left -= TOUR[i].seconds;
      i++;
    }
    const t = left / TOUR[i].seconds;
    const [a, b, c, d] = [-1, 0, 1, 2].map((k) => TOUR[(i + k + TOUR.length) % TOUR.length]);
    const spline = (of) => {
      const [p, q, r, s] = [a, b, c, d].map(of);
      return q.map(
        (n, k) =>
          n +
          0.5 *
            t *
            (r[k] - p[k] + t * (2 * p[k] - 5 * n + 4 * r[k] - s[k] + t * (3 * (n - r[k]) + s[k] - p[k]))),
      );
    };
    const [x, z] = spline(({ at }) => at);
    const looked = mix(b.look, c.look, smooth(t));
    const at = [x, EYES, z];
    const { turn, tilt } = facing(at, looked);
    // Softly from where one was, where the tour begins.
    const ease = 1 - Math.exp(-2.5 * seconds);
    this.at = mix(this.at, at, ease);
    this.turn += (near(turn, this.turn) - this.turn) * ease;
    this.tilt += (tilt - this.tilt) * ease;
  }

  #stepGoing(seconds) {
    const going = this.#going;
    going.seconds += seconds;
    const t = smooth(going.seconds / GOING);
    const { from, to } = going;
    this.at = mix(from.at, to.at, t);
    this.turn = from.turn + (to.turn - from.turn) * t;
    this.tilt = from.tilt + (to.tilt - from.tilt) * t;
    if (t === 1) this.#going = undefined;
  }

  get #pose() {
    return { at: this.at, turn: this.turn, tilt: this.tilt };
  }

  #stand({ at, turn, tilt }) {
    Object.assign(this, { at, turn, tilt });
  }

  /** As near as walls let one go. */
  #to(x, z) {
    const isFree = (x, z) => {
      const inRoom = ROOMS.some(
        ({ near, far }) => Math.abs(x) <= WIDTH / 2 - BODY && z <= near - BODY && z >= far + BODY,
      );
      const inDoor =
        Math.abs(x) <= DOOR.half - BODY && z <= -BODY && z >= -(ROOMS.length * (DEPTH + WALL)) + WALL + BODY;
      return inRoom || inDoor;
    };
    if (isFree(x, this.at[2])) this.at = [x, EYES, this.at[2]];
    if (isFree(this.at[0], z)) this.at = [this.at[0], EYES, z];
  }
}
