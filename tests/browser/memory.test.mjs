// What a figure takes on the GPU and in the module stays the same, however far the view is dragged.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedQuilt, huge } from './pictures.mjs';

const VIEWPORT = { width: 480, height: 360 };
/** At which the viewport shows up to four tiles of the finest level. */
const SCALE = 0.51;
/** What the viewer keeps on a device with as little memory: a tenth of what is dragged across. */
const GIGABYTES = 0.25;
const BUDGET = GIGABYTES * 64 * 1024 * 1024;
const DRAG_MS = 10_000;

let folder;
let server;
let browser;
let files;
let base;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'istar-'));
  const picture = huge(readFileSync(encodedQuilt(folder, 'small', [1024, 1024])));
  server = await harness.serve();
  browser = await harness.launch();
  files = createServer((request, response) => {
    response.setHeader('access-control-allow-origin', '*');
    const [, from, to] = /bytes=(\d+)-(\d+)/.exec(request.headers.range).map(Number);
    const end = Math.min(to + 1, picture.length);
    response.writeHead(206, { 'content-range': `bytes ${from}-${end - 1}/${picture.length}` });
    response.end(picture.slice(from, end));
  });
  await new Promise((ready) => files.listen(0, '127.0.0.1', ready));
  base = `http://127.0.0.1:${files.address().port}/`;
});
after(async () => {
  await browser?.close();
  server?.stop();
  files?.closeAllConnections();
  files?.close();
  rmSync(folder, { recursive: true });
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
    const { page, uncaught, close } = await harness.newPage(browser, {
      viewport: VIEWPORT,
      reducedMotion: 'reduce',
    });
    await page.addInitScript(count, GIGABYTES);
    await page.goto(
      `${server.url}view.html?backend=${backend}&src=${encodeURIComponent(`${base}huge.istar`)}`,
    );
    await harness.event(page, 'load');
    const held = () => page.evaluate(() => window.held());
    await harness.zoomTo(page, 2000, 30_000, SCALE);
    const drag = async () => {
      await page.mouse.move(440, 180);
      await page.mouse.down();
      for (let x = 440; x >= 40; x -= 80) await page.mouse.move(x, 180);
      await page.mouse.up();
      return held();
    };
    // Until the first tiles have to go.
    let before = await held();
    for (let now = await drag(); now.gpu >= before.gpu; now = await drag()) before = now;
    const start = Date.now();
    let most = before;
    while (Date.now() - start < DRAG_MS) {
      const now = await drag();
      most = { gpu: Math.max(most.gpu, now.gpu), wasm: now.wasm, textures: 0 };
    }
    const { x } = await harness.place(page);
    console.log(backend, x, JSON.stringify(before), JSON.stringify(most));
    assert.deepEqual(uncaught, []);
    await close();
  });
}
