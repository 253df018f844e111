// Walks from region to region by keyboard, and says where it is. A module of its own, fetched at the first step: dist/istar-walk.js.
import { adopt } from './adopt.js';
import { colorWord } from './colors.js';
import { make } from './dom.js';
import type { Host } from './host.js';
import { middleOf, type Neighbour, nearestTo, nearestTowards, neighboursOf, spotOf } from './neighbours.js';
import { inPicture, onScreen, type Point } from './turn.js';
import css from './walk.css';

/** So many neighbours are told by name. */
const MOST_TOLD = 8;
/** Places of the view along each axis at which is looked for a region, and how many make it seen. */
const LOOKED_AT = 24;
const SEEN = 12;
/** What is nearer to the rim than this part of the view may be under a button. */
const RIM = 0.05;

/** How far apart it is looked on the way ahead, in CSS pixels, and how often. */
const STEP_PX = 2;
const MOST_STEPS = 4000;

const DIRECTIONS: Record<string, Point> = {
  ArrowLeft: { x: -1, y: 0 },
  ArrowRight: { x: 1, y: 0 },
  ArrowUp: { x: 0, y: -1 },
  ArrowDown: { x: 0, y: 1 },
};

/** Where the walk is: a region, and a place in it. */
interface Stop {
  region: number;
  at: Point;
}

/**
 * Arrows go to the neighbour that lies there. Tab and Shift+Tab go through all neighbours of where an arrow led, clockwise, and then on
 * to the rest of the page. Enter and Space click, Escape ends the walk.
 */
export class Walk {
  readonly #host: Host;
  readonly #spoken = make('div', 'spoken');
  /** Where it is, however small the region. */
  readonly #pin = make('div', 'pin');
  #here: Stop | undefined;
  /** Where the last arrow led, and those around it that Tab goes through; -1 is there itself. */
  #home: Stop | undefined;
  #around: Neighbour[] = [];
  #turn = -1;

  constructor(host: Host) {
    this.#host = host;
    adopt(host.root, css);
    this.#spoken.role = 'status';
    host.root.append(this.#spoken);
    host.stage.append(this.#pin);
    this.#pinDown();
    host.element.addEventListener('viewchange', () => this.#pinDown());
    // Before those keys that move the view.
    host.stage.addEventListener('keydown', (event) => this.#key(event), true);
    host.stage.addEventListener('blur', () => this.end());
  }

  /** Begins at the region in the middle of the view. */
  start(): void {
    const { view } = this.#host;
    const { place } = view;
    // Whoever asked may have gone on while this was fetched: no blur would end it.
    if (this.#here || !place || this.#host.root.activeElement !== this.#host.stage) return;
    const box = view.canvas.getBoundingClientRect();
    const middle = view.pick(box.left + box.width / 2, box.top + box.height / 2);
    const region = middle ?? nearestTo(view, place);
    if (region !== undefined) this.#settle(region, place);
  }

  end(): void {
    if (!this.#here) return;
    this.#leave();
    this.#here = undefined;
    this.#mark(undefined);
    this.#host.tell(undefined);
    this.#pinDown();
    this.#spoken.textContent = '';
  }

  #key(event: KeyboardEvent): void {
    if (!this.#here || event.ctrlKey || event.metaKey || event.altKey) return;
    const direction = DIRECTIONS[event.key];
    if (direction) this.#step(direction);
    else if (event.key === 'Tab') {
      if (!this.#goRound(event.shiftKey ? -1 : 1)) {
        // The browser goes on from here.
        this.end();
        return;
      }
    } else if (event.key === 'Enter' || event.key === ' ') {
      this.#host.emit('regionclick', this.#here.region);
    } else if (event.key === 'Escape') this.end();
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }

  #step(towards: Point): void {
    const here = this.#here;
    if (!here) return;
    const { view } = this.#host;
    const around = neighboursOf(view, here.region);
    const ahead = this.#ahead(here, towards);
    // Where that is in the picture.
    const way = view.place ? inPicture({ ...view.place, scale: 1 }, towards) : towards;
    const next = around.find(({ region }) => region === ahead) ?? nearestTowards(around, here.at, way);
    if (next) this.#settle(next.region, next.middle);
    else this.#say(this.#host.say('No region that way'));
  }

  /** The region that is met straight on, as far as there are tiles. */
  #ahead({ region, at }: Stop, towards: Point): number | undefined {
    const { view } = this.#host;
    const { place, file } = view;
    if (!place || !file) return undefined;
    const box = view.canvas.getBoundingClientRect();
    const { width, height } = file.archive;
    const start = onScreen(place, { x: at.x - place.x, y: at.y - place.y });
    const step = inPicture(place, { x: STEP_PX * towards.x, y: STEP_PX * towards.y });
    for (let i = 1; i < MOST_STEPS; i++) {
      const [x, y] = [at.x + i * step.x, at.y + i * step.y];
      if (x < 0 || y < 0 || x > width || y > height) return undefined;
      const met = view.pick(
        box.left + box.width / 2 + start.x + i * STEP_PX * towards.x,
        box.top + box.height / 2 + start.y + i * STEP_PX * towards.y,
      );
      if (met !== region && met !== undefined) return met;
    }
    return undefined;
  }

  /** Goes to a region by an arrow, over a place of its border. */
  #settle(region: number, over: Point): void {
    const home = this.#arrive(region, over);
    const { place } = this.#host.view;
    const angle = ({ middle }: Neighbour) => {
      // Clockwise on the screen, from the top.
      const way = { x: middle.x - home.at.x, y: middle.y - home.at.y };
      const { x, y } = place ? onScreen(place, way) : way;
      const turn = Math.atan2(x, -y);
      return turn < 0 ? turn + 2 * Math.PI : turn;
    };
    const around = neighboursOf(this.#host.view, region);
    this.#home = home;
    this.#around = around.sort((a, b) => angle(a) - angle(b));
    this.#turn = -1;
  }

  /** The next of the neighbours around; whether there is one. */
  #goRound(by: 1 | -1): boolean {
    const turn = this.#turn + by;
    const next = this.#around[turn];
    if (next) this.#arrive(next.region, next.middle);
    else if (turn === -1 && this.#home) this.#arrive(this.#home.region, this.#home.at);
    else return false;
    this.#turn = turn;
    return true;
  }

  #arrive(region: number, over: Point): Stop {
    const host = this.#host;
    const here = { region, at: this.#bringIntoView(region, over) };
    this.#leave();
    this.#here = here;
    this.#mark(region);
    host.tell(this.#name(region), region);
    this.#pinDown();
    host.emit('regionenter', region);
    this.#tell(region);
    return here;
  }

  /** Lifts one region out. */
  #mark(region: number | undefined): void {
    const { view } = this.#host;
    // The pin has it as the page has it now, light or dark, and in forced colours as the user has.
    const color = getComputedStyle(this.#pin).borderTopColor;
    // Not an outline, which costs a frame more wherever it is in sight.
    view.styles.mark(region, { highlight: true, pattern: { motif: 'rising', color } });
    view.redraw();
  }

  #pinDown(): void {
    const { place } = this.#host.view;
    const here = this.#here?.at;
    this.#pin.hidden = !here || !place;
    if (!here || !place) return;
    // From the middle, where it is by itself.
    const { x, y } = onScreen(place, { x: here.x - place.x, y: here.y - place.y });
    this.#pin.style.transform = `translate(${x}px, ${y}px)`;
  }

  #leave(): void {
    if (this.#here) this.#host.emit('regionleave', this.#here.region);
  }

  /**
   * A place of a region that is in view: its own, else, of one that is well in view, the middle of what is seen; else the view
   * goes there.
   */
  #bringIntoView(region: number, over: Point): Point {
    const { view } = this.#host;
    const { place } = view;
    const spot = spotOf(view, region) ?? over;
    if (!place) return spot;
    const box = view.canvas.getBoundingClientRect();
    const inner = 1 - 2 * RIM;
    const isSeen = (at: Point) => {
      const { x, y } = onScreen(place, { x: at.x - place.x, y: at.y - place.y });
      return Math.abs(x) < (inner * box.width) / 2 && Math.abs(y) < (inner * box.height) / 2;
    };
    if (isSeen(spot)) return spot;
    const seen: Point[] = [];
    for (let i = 0; i < LOOKED_AT * LOOKED_AT; i++) {
      const right = RIM + (inner * ((i % LOOKED_AT) + 0.5)) / LOOKED_AT;
      const down = RIM + (inner * (Math.floor(i / LOOKED_AT) + 0.5)) / LOOKED_AT;
      if (view.pick(box.left + right * box.width, box.top + down * box.height) !== region) continue;
      const way = inPicture(place, { x: (right - 0.5) * box.width, y: (down - 0.5) * box.height });
      seen.push({ x: place.x + way.x, y: place.y + way.y });
    }
    const { x, y } = middleOf(seen);
    const away = (at: Point) => Math.hypot(at.x - x, at.y - y);
    const [first, ...others] = seen;
    if (first && seen.length >= SEEN)
      return others.reduce((best, at) => (away(at) < away(best) ? at : best), first);
    view.lookAt(spot.x, spot.y, place.scale);
    return spot;
  }

  #tell(region: number): void {
    const { say, view } = this.#host;
    const around = neighboursOf(view, region);
    const own = this.#name(region);
    // Several regions may have one name.
    const names = [...new Set(around.map((neighbour) => this.#name(neighbour.region)))].filter(
      (name) => name !== own,
    );
    const told = names.slice(0, MOST_TOLD).join(', ');
    const more = names.length - MOST_TOLD;
    if (names.length === 0) this.#say(own);
    else if (more > 0)
      this.#say(say('{name}, borders {others} and {count} more', { name: own, others: told, count: more }));
    else this.#say(say('{name}, borders {others}', { name: own, others: told }));
  }

  /** What a region is called, else its colour and number. */
  #name(region: number): string {
    const { say, view, named } = this.#host;
    const color = view.regionColor(region) ?? 0;
    return named(region) ?? say('{color} region {number}', { color: say(colorWord(color)), number: region });
  }

  #say(text: string): void {
    // Only a change is read out, also where the same is said again.
    this.#spoken.textContent = this.#spoken.textContent === text ? `${text}\u00a0` : text;
  }
}
