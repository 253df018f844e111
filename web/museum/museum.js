// The museum: a hall with pictures that are materials of its walls. `?backend=webgpu|webgl2` says what draws it.
import { IStarMaterial } from '../istar-material.js';
import { cards, floor } from './covers.js';
import { PICTURES } from './hall.js';
import { built } from './mesh.js';
import { dot, lens, subtract, towards } from './vectors.js';
import { Visitor } from './visitor.js';

const FOVY = (56 * Math.PI) / 180;
/** Frames of more seconds are drawn in fewer pixels while one moves. */
const SLOW = 0.045;
const LEAST_FINENESS = 0.5;
const MODES = ['IStar', 'Both', 'Texture'];

const stage = document.querySelector('#stage');
const status = document.querySelector('#status');
const found = document.querySelector('#found');
const compare = document.querySelector('#compare');
const tour = document.querySelector('#tour');
const split = document.querySelector('#split');
const quiet = matchMedia('(prefers-reduced-motion: reduce)');

const visitor = new Visitor();
const scene = built();
const files = [...new Set(PICTURES.map(({ file }) => file))];
const sizes = new Map();
let canvas;
let renderer;
let mode = 0;
let fineness = 1;
let frame = 0;
let last = 0;
let slow = 0;
let before = -1;

const loader = new Worker(new URL('./loader.js', import.meta.url), { type: 'module' });
const asked = new Map();

start();

async function start() {
  try {
    renderer = await created(new URLSearchParams(location.search).get('backend'));
  } catch (cause) {
    status.textContent = `The hall cannot be drawn: ${cause.message}`;
    return;
  }
  document.documentElement.dataset.backend = renderer.backend;
  const waiting = new Set(files);
  loader.addEventListener('message', ({ data }) => {
    if (data.textures) {
      renderer.addFile(data.name, data.textures);
      sizes.set(data.name, data.size);
      waiting.delete(data.name);
      status.textContent = waiting.size > 0 ? 'Hanging the pictures …' : '';
      if (waiting.size === 0) document.documentElement.dataset.ready = '';
      redraw();
    } else if (data.fault) status.textContent = data.fault;
    else asked.get(data.ask)?.(data.found);
  });
  for (const name of files)
    loader.postMessage({ name, load: new URL(`../gallery/${name}.istar`, import.meta.url).href });
  new ResizeObserver(resize).observe(stage);
  listen();
  if (!quiet.matches) setTour(true);
  resize();
}

async function created(wanted) {
  const made = async (name) => {
    canvas?.remove();
    canvas = document.createElement('canvas');
    const module = await (name === 'webgpu' ? import('./webgpu.js') : import('./webgl2.js'));
    const material = name === 'webgpu' ? IStarMaterial.wgsl : IStarMaterial.glsl;
    const kilobytes = { emblem: '52 KB', map: '199 KB' };
    const shown = PICTURES.filter(({ flat }) => !flat).map((picture) => ({
      ...picture,
      size: `${picture.file}.istar, ${kilobytes[picture.file]}`,
    }));
    const covers = { floor: floor(), labels: cards(shown) };
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
  const ratio = Math.min(devicePixelRatio, 2) * (visitor.isMoving ? fineness : 1);
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
  const seconds = last > 0 ? Math.min((now - last) / 1000, 0.1) : 1 / 60;
  const wasMoving = visitor.isMoving;
  visitor.step(seconds);
  // Slow ones one after the other, not one that something else held up.
  slow = wasMoving && last > 0 && seconds > SLOW ? slow + 1 : 0;
  if (slow > 4 && fineness > LEAST_FINENESS) {
    fineness = Math.max(fineness * 0.75, LEAST_FINENESS);
    slow = 0;
    resize();
  }
  last = visitor.isMoving ? now : 0;
  // Where the thumb's middle is.
  const thumb = 36 / stage.clientWidth;
  const across = thumb / 2 + Number(split.value) * (1 - thumb);
  const at = [0, canvas.width * across, canvas.width + 1][mode];
  const seen = lens(visitor, canvas.width / canvas.height, FOVY, renderer.isHalf);
  const order = PICTURES.map(({ file, at }, i) => [i, file, Math.hypot(...subtract(at, visitor.at))]);
  renderer.draw(
    seen,
    at,
    order.sort((a, b) => a[2] - b[2]),
  );
  tell();
  if (visitor.isMoving) redraw();
  else if (wasMoving) resize();
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

/** The picture under a place of the window, and the place in it. */
function hit(clientX, clientY) {
  const box = stage.getBoundingClientRect();
  const x = ((clientX - box.left) / box.width) * 2 - 1;
  const y = 1 - ((clientY - box.top) / box.height) * 2;
  const tangent = Math.tan(FOVY / 2);
  const forward = towards(visitor.turn, visitor.tilt);
  const right = [Math.cos(visitor.turn), 0, Math.sin(visitor.turn)];
  const up = towards(visitor.turn, visitor.tilt + Math.PI / 2);
  const ray = forward.map(
    (n, i) => n + x * tangent * (box.width / box.height) * right[i] + y * tangent * up[i],
  );
  let best;
  for (const picture of PICTURES) {
    const facing = dot(ray, picture.normal);
    if (facing >= 0) continue;
    const distance = dot(subtract(picture.at, visitor.at), picture.normal) / facing;
    const way = subtract(
      visitor.at.map((n, i) => n + distance * ray[i]),
      picture.at,
    );
    const [u, v] = [
      dot(way, picture.right) / picture.width + 0.5,
      0.5 - dot(way, picture.up) / picture.height,
    ];
    if (distance < 0 || Math.min(u, v) < 0 || Math.max(u, v) > 1 || distance > (best?.distance ?? 20))
      continue;
    const [left, top, end, lower] = picture.part;
    best = { picture, distance, at: [left + u * (end - left), top + v * (lower - top)] };
  }
  return best;
}

async function ask(clientX, clientY) {
  const under = hit(clientX, clientY);
  found.textContent = '';
  if (!under) return;
  const answer = await new Promise((resolve) => {
    const key = asked.size + 1;
    asked.set(key, resolve);
    loader.postMessage({ name: under.picture.file, ask: key, at: under.at });
  });
  if (!answer) return;
  const color = `#${(answer.color >>> 8).toString(16).padStart(6, '0')}`;
  const swatch = document.createElement('i');
  swatch.style.backgroundColor = color;
  found.replaceChildren(swatch, `Region ${answer.region} of “${under.picture.title}”, ${color}`);
}

function setTour(on) {
  if (on) visitor.tour();
  else visitor.stop();
  tour.setAttribute('aria-pressed', String(on));
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
  const from = before < 0 ? (by > 0 ? -1 : 0) : before;
  visitor.visit((from + by + PICTURES.length) % PICTURES.length, quiet.matches);
  tour.setAttribute('aria-pressed', 'false');
  resize();
}

function listen() {
  const stopped = () => {
    tour.setAttribute('aria-pressed', 'false');
    resize();
  };
  addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches?.('input')) return;
    if (visitor.key(event.code, true)) stopped();
    else if (event.code === 'KeyC') setMode((mode + 1) % MODES.length);
    else if (event.code === 'KeyT') setTour(!visitor.isOnTour);
    else if (event.code === 'KeyN') visit(1);
    else if (event.code === 'KeyP') visit(-1);
    else return;
    event.preventDefault();
  });
  addEventListener('keyup', (event) => visitor.key(event.code, false));
  addEventListener('blur', () => visitor.release());
  let dragged = 0;
  stage.addEventListener('pointerdown', (event) => {
    if (event.target !== canvas || !event.isPrimary) return;
    canvas.setPointerCapture(event.pointerId);
    dragged = 0;
  });
  stage.addEventListener('pointermove', (event) => {
    if (!event.isPrimary || !canvas.hasPointerCapture(event.pointerId)) return;
    dragged += Math.abs(event.movementX) + Math.abs(event.movementY);
    if (dragged < 4) return;
    const angle = FOVY / stage.clientHeight;
    visitor.look(-event.movementX * angle, event.movementY * angle);
    stopped();
  });
  stage.addEventListener('pointerup', (event) => {
    if (canvas.hasPointerCapture(event.pointerId) && dragged < 4) ask(event.clientX, event.clientY);
  });
  stage.addEventListener(
    'wheel',
    (event) => {
      event.preventDefault();
      visitor.stop();
      visitor.walk(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY) / 300, 0.5), 0);
      stopped();
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
    stopTour();
  },
  mode: setMode,
  place: () => visitor.at,
};

function stopTour() {
  tour.setAttribute('aria-pressed', 'false');
  resize();
}
