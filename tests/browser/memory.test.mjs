// What a figure takes on the GPU and in the module stays the same, however far the view is dragged.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedLargeQuilt, huge } from './pictures.mjs';

/** Small, because it is software that draws: what is counted here are tiles. */
const VIEWPORT = { width: 160, height: 120 };
/** The smallest at which tiles of the finest level are shown: they are 522 pixels wide then. */
const SCALE = 0.51;
/** A pointer that was pressed in a figure may be dragged far out of it: from left to right in 16 steps. */
const STEP = 2000;
const ROW = 1024;
/** A device with so little memory keeps some twenty tiles. */
const GIGABYTES = 0.25;
const MIB = 1024 * 1024;
const BUDGET = GIGABYTES * 64 * MIB;
/** Free memory of the module lies in pieces: it may grow by some of them, but not by every tile. */
const MOST_GROWN = 3 * MIB;
const MOST_TO_WARM = 80;
/** Each passes four tiles: so many at least, and for so many milliseconds. */
const DRAGS = 30;
const DRAGGED = 10_000;

const run = harness.session();
const picture = huge(
  readFileSync(encodedLargeQuilt(harness.temporaryFolder(), 'small', [1024, 1024], '--texel-size', '8')),
);
const files = harness.serveFiles((request, response) => {
  const [, from, to] = /bytes=(\d+)-(\d+)/.exec(request.headers.range).map(Number);
  const end = Math.min(to + 1, picture.length);
  response.writeHead(206, { 'content-range': `bytes ${from}-${end - 1}/${picture.length}` });
  response.end(picture.slice(from, end));
});

/** Counts the textures that there are and their bytes, and looks into the module's memory: `window.held()`. */
function count(gigabytes) {
  Object.defineProperty(navigator, 'deviceMemory', { value: gigabytes });
  const textures = new Map();
  const bytesOf = (format) => (/RGBA32UI|rgba32uint/.test(format) ? 16 : 4);
  const { prototype: gl } = WebGL2RenderingContext;
  let bound;
  const wrapped = (object, name, before) => {
    const original = object[name];
    object[name] = function (...rest) {
      const result = original.apply(this, rest);
      before.call(this, result, ...rest);
      return result;
    };
  };
  wrapped(gl, 'createTexture', (texture) => textures.set(texture, 0));
  wrapped(gl, 'deleteTexture', (_, texture) => textures.delete(texture));
  wrapped(gl, 'bindTexture', (_, __, texture) => {
    bound = texture;
  });
  wrapped(gl, 'texStorage2D', (_, __, ___, format, width, height) => {
    const name = Object.keys(WebGL2RenderingContext).find((key) => WebGL2RenderingContext[key] === format);
    textures.set(bound, width * height * bytesOf(name));
  });
  wrapped(GPUDevice.prototype, 'createTexture', (texture, { size: [width, height], format }) => {
    textures.set(texture, width * height * bytesOf(format));
  });
  wrapped(GPUTexture.prototype, 'destroy', function () {
    textures.delete(this);
  });
  let memory;
  const instantiate = WebAssembly.instantiateStreaming;
  WebAssembly.instantiateStreaming = async (...rest) => {
    const result = await instantiate(...rest);
    memory = result.instance.exports.memory;
    return result;
  };
  window.held = () => ({
    textures: textures.size,
    gpu: [...textures.values()].reduce((sum, bytes) => sum + bytes, 0),
    wasm: memory.buffer.byteLength,
  });
}

for (const backend of harness.BACKENDS) {
  test(`memory is flat while a large picture is dragged, with ${backend}`, { timeout: 180_000 }, async () => {
    const { page, uncaught, close } = await harness.newPage(run.browser, {
      viewport: VIEWPORT,
      reducedMotion: 'reduce',
    });
    await page.addInitScript(count, GIGABYTES);
    await page.goto(
      `${run.server.url}view.html?backend=${backend}&src=${encodeURIComponent(`${files.base}huge.istar`)}`,
    );
    await harness.event(page, 'load');
    const held = () => page.evaluate(() => window.held());
    let [row, step] = [0, 0];
    const drag = async () => {
      if (step++ % 14 === 0) await harness.zoomTo(page, 1000, 1000 + ROW * row++, SCALE);
      await page.mouse.move(80, 60);
      await page.mouse.down();
      await page.mouse.move(80 - STEP, 60);
      await page.mouse.up();
      await page.evaluate(() => document.querySelector('istar-viewer').painted);
      return held();
    };
    // Until tiles have to go for others.
    let before = await held();
    for (let same = 0; same < 5 && step < MOST_TO_WARM; ) {
      const now = await drag();
      same = now.textures > before.textures ? 0 : same + 1;
      if (same === 0) before = now;
    }
    const [warm, most] = [step, { ...before }];
    const start = performance.now();
    while (step < warm + DRAGS || performance.now() < start + DRAGGED) {
      const now = await drag();
      for (const what of Object.keys(most)) most[what] = Math.max(most[what], now[what]);
    }
    const tell = ({ textures, gpu, wasm }) => `${textures} textures of ${gpu} bytes, ${wasm} in the module`;
    console.log(`${backend}: ${tell(before)}; after ${step - warm} more drags at most ${tell(most)}`);
    assert.ok(before.gpu > BUDGET / 2, 'what was seen is kept');
    assert.ok(most.gpu <= BUDGET && most.gpu <= 1.2 * before.gpu);
    assert.ok(most.textures <= 1.2 * before.textures);
    assert.ok(most.wasm <= before.wasm + MOST_GROWN);
    assert.deepEqual(uncaught, []);
    await close();
  });
}
