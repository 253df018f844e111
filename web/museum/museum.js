// The museum: a hall with pictures that are materials of its walls. `?backend=webgpu|webgl2` says what draws it.
import { IStarMaterial } from '../istar-material.js';
import { hit } from './aim.js';
import { cards, floor } from './covers.js';
import { PICTURES } from './hall.js';
import { dot, lens, subtract, towards } from './vectors.js';
import { Visitor } from './visitor.js';
import { hall, Loader } from './workers.js';

const FOVY = (56 * Math.PI) / 180;
/** Frames of more seconds are drawn in fewer pixels while one moves. */
const SLOW = 0.045;
const LEAST_FINENESS = 0.5;
/** The slider's thumb in rem, as the style sheet has it. */
const THUMB = 2.25;
const MODES = ['IStar', 'Both', 'Texture'];

const stage = document.querySelector('#stage');
const status = document.querySelector('#status');
const found = document.querySelector('#found');
const compare = document.querySelector('#compare');
const tour = document.querySelector('#tour');
const split = document.querySelector('#split');
const quiet = matchMedia('(prefers-reduced-motion: reduce)');

const visitor = new Visitor();
const files = [...new Set(PICTURES.map(({ file }) => file))];
/** Of each file that is there its textures: another renderer may need them again. */
const textures = new Map();
let loader;
let scene;
let canvas;
let renderer;
let fault = '';
let mode = 0;
let fineness = 1;
/** Whether the canvas has fewer pixels than it should, for one moves. */
let isCoarse = false;
let frame = 0;
let last = 0;
let slow = 0;
let before = -1;
let questions = 0;

start();

async function start() {
  try {
    // Files are on their way while the light is worked out.
    loader = new Loader(files, hang, fail);
    scene = await hall();
    await begin();
  } catch (cause) {
    fail(`The hall cannot be drawn: ${cause.message}`);
    return;
  }
  new ResizeObserver(resize).observe(stage);
  listen();
  if (!quiet.matches) setTour(true);
}

/** Puts a renderer into the page, and one more each time that its device is lost. */
async function begin() {
  const made = await created(new URLSearchParams(location.search).get('backend'));
  for (const [name, data] of textures) made.addFile(name, data);
  renderer = made;
  made.lost.then(replace);
  document.documentElement.dataset.backend = made.backend;
  report();
  resize();
}

async function replace() {
  renderer = undefined;
  report();
  try {
    await begin();
  } catch (cause) {
    fail(`The hall can no longer be drawn: ${cause.message}`);
  }
}

function hang(name, data) {
  textures.set(name, data);
  renderer?.addFile(name, data);
  report();
  redraw();
}

function fail(message) {
  fault = message;
  report();
}

function report() {
  const isReady = renderer !== undefined && textures.size === files.length;
  document.documentElement.toggleAttribute('data-ready', isReady);
  status.textContent = fault || (isReady ? '' : 'Hanging the pictures …');
}

async function created(wanted) {
  const made = async (name) => {
    canvas?.remove();
    canvas = document.createElement('canvas');
    const module = await (name === 'webgpu' ? import('./webgpu.js') : import('./webgl2.js'));
    const material = name === 'webgpu' ? IStarMaterial.wgsl : IStarMaterial.glsl;
    // Drawn anew for each: what canvases hold may be lost with a device.
    const covers = { floor: floor(), labels: cards() };
    const renderer = await module.create(canvas, material, scene, covers);
    canvas.setAttribute('role', 'img');
    canvas.ariaLabel = 'A museum of three rooms with pictures on their walls';
    stage.prepend(canvas);
    return renderer;
  };
  if (wanted === 'webgpu' || wanted === 'webgl2') return made(wanted);
  return made('webgpu').catch(() => made('webgl2'));
}

function resize() {
  if (!renderer) return;
  isCoarse = visitor.isMoving && fineness < 1;
  const ratio = Math.min(devicePixelRatio, 2) * (isCoarse ? fineness : 1);
  const [width, height] = [stage.clientWidth, stage.clientHeight].map((n) =>
    Math.max(Math.round(n * ratio), 1),
  );
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  redraw();
}

function redraw() {
  if (frame === 0 && renderer) frame = requestAnimationFrame(draw);
}

function draw(now) {
  frame = 0;
  if (!renderer) return;
  const seconds = last > 0 ? Math.min((now - last) / 1000, 0.1) : 1 / 60;
  visitor.step(seconds);
  // Slow ones one after the other, not one that something else held up.
  slow = last > 0 && seconds > SLOW ? slow + 1 : 0;
  if (slow > 4 && fineness > LEAST_FINENESS) {
    fineness = Math.max(fineness * 0.75, LEAST_FINENESS);
    slow = 0;
    resize();
  }
  last = visitor.isMoving ? now : 0;
  const at = [0, canvas.width * across(), canvas.width + 1][mode];
  const seen = lens(visitor, canvas.width / canvas.height, FOVY, renderer.isHalf);
  const order = PICTURES.map(({ file, at }, i) => [i, file, Math.hypot(...subtract(at, visitor.at))]);
  renderer.draw(
    seen,
    at,
    order.sort((a, b) => a[2] - b[2]),
  );
  tell();
  if (visitor.isMoving) redraw();
  else if (isCoarse) resize();
}

/** Where the middle of the slider's thumb is, of the stage's width. */
function across() {
  const rem = Number.parseFloat(getComputedStyle(document.documentElement).fontSize);
  const thumb = (THUMB * rem) / stage.clientWidth;
  return thumb / 2 + Number(split.value) * (1 - thumb);
}

/** Says which picture one stands before, where it is another than before. */
function tell() {
  const ahead = towards(visitor.turn, visitor.tilt);
  let [best, index] = [0.8, -1];
  for (const [i, { at }] of PICTURES.entries()) {
    const way = subtract(at, visitor.at);
    const distance = Math.hypot(...way);
    if (distance < 6 && dot(way, ahead) / distance > best) [best, index] = [dot(way, ahead) / distance, i];
  }
  if (index === before) return;
  before = index;
  const picture = PICTURES[index];
  document.querySelector('#title').textContent = picture?.title ?? '';
  document.querySelector('#note').textContent = picture?.note ?? '';
}

/** Tells the region at a place of the view: -1 to 1, to the right and upwards. */
async function ask(x, y) {
  const question = ++questions;
  found.textContent = '';
  const under = hit(visitor, [x, y], stage.clientWidth / stage.clientHeight, FOVY);
  if (!under || !textures.has(under.picture.file)) return;
  const { found: region, fault } = await loader.ask(under.picture.file, under.at);
  // Another one was asked meanwhile.
  if (question !== questions) return;
  if (!region) {
    found.textContent = fault ?? '';
    return;
  }
  const color = `#${(region.color >>> 8).toString(16).padStart(6, '0')}`;
  const swatch = document.createElement('i');
  swatch.style.backgroundColor = color;
  found.replaceChildren(swatch, `Region ${region.region} of “${under.picture.title}”, ${color}`);
}

function setTour(on) {
  if (on) visitor.tour();
  else visitor.stop();
  turned();
}

/** After what may have begun or ended the tour, and the way anywhere. */
function turned() {
  tour.setAttribute('aria-pressed', String(visitor.isOnTour));
  resize();
}

function setMode(next) {
  mode = next;
  compare.textContent = `Compare: ${MODES[mode]}`;
  split.hidden = mode !== 1;
  stage.style.setProperty('--split', mode === 1 ? split.value : '-1');
  redraw();
}

function visit(by) {
  // On from where one is going to, if one is not there yet.
  const from = visitor.goal ?? (before < 0 && by > 0 ? -1 : Math.max(before, 0));
  visitor.visit((from + by + PICTURES.length) % PICTURES.length, quiet.matches);
  turned();
}

function listen() {
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.('input')) return;
    if (visitor.key(event.code, true)) turned();
    else if (event.code === 'KeyC') setMode((mode + 1) % MODES.length);
    else if (event.code === 'KeyT') setTour(!visitor.isOnTour);
    else if (event.code === 'KeyN') visit(1);
    else if (event.code === 'KeyP') visit(-1);
    else if (event.key === 'Enter' && (event.target === stage || event.target === document.body)) ask(0, 0);
    else return;
    event.preventDefault();
  });
  addEventListener('keyup', (event) => visitor.key(event.code, false));
  addEventListener('blur', () => visitor.release());
  let dragged = 0;
  stage.addEventListener('pointerdown', (event) => {
    if (event.target !== canvas || !event.isPrimary || event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    dragged = 0;
  });
  stage.addEventListener('pointermove', (event) => {
    if (!event.isPrimary || !canvas.hasPointerCapture(event.pointerId)) return;
    dragged += Math.abs(event.movementX) + Math.abs(event.movementY);
    if (dragged < 4) return;
    const angle = FOVY / stage.clientHeight;
    visitor.look(-event.movementX * angle, event.movementY * angle);
    turned();
  });
  stage.addEventListener('pointerup', (event) => {
    if (!canvas.hasPointerCapture(event.pointerId) || dragged >= 4) return;
    const box = stage.getBoundingClientRect();
    const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    ask(2 * x - 1, 1 - 2 * y);
  });
  stage.addEventListener(
    'wheel',
    (event) => {
      // The browser's own zoom.
      if (event.ctrlKey) return;
      event.preventDefault();
      visitor.stop();
      visitor.walk(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY) / 300, 0.5), 0);
      turned();
    },
    { passive: false },
  );
  compare.addEventListener('click', () => setMode((mode + 1) % MODES.length));
  split.addEventListener('input', () => setMode(1));
  tour.addEventListener('click', () => setTour(!visitor.isOnTour));
  document.querySelector('#next').addEventListener('click', () => visit(1));
  document.querySelector('#previous').addEventListener('click', () => visit(-1));
  quiet.addEventListener('change', () => quiet.matches && setTour(false));
}

/** For tests and for those who try: where one stands. */
globalThis.museum = {
  stand(at, turn, tilt) {
    visitor.stop();
    Object.assign(visitor, { at, turn, tilt });
    turned();
  },
  mode: setMode,
  place: () => visitor.at,
};
