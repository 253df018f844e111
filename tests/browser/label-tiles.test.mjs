// Tiles that hold labels: a worker gives each its texels, and only those that a view shows are fetched.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedQuilt } from './pictures.mjs';

const VIEWPORT = { width: 240, height: 180 };

const run = harness.session();
const folder = harness.temporaryFolder();
const file = encodedQuilt(folder, 'quilt', [1024, 768], '--stream', '--tile-size', '128');
const whole = readFileSync(file);
const damaged = Buffer.from(whole);
// In the last tile of the finest level.
damaged[damaged.length - 20] ^= 1;
/** Requests as [from, to] of bytes. */
let asked = [];

const files = harness.serveFiles((request, response) => {
  const picture = request.url.startsWith('/damaged') ? damaged : whole;
  const [, from, last] = /bytes=(\d+)-(\d+)/.exec(request.headers.range).map(Number);
  const to = Math.min(last + 1, picture.length);
  asked.push([from, to]);
  response.setHeader('access-control-expose-headers', 'etag, content-range, content-encoding');
  response.setHeader('cache-control', 'no-store');
  response.writeHead(206, { 'content-range': `bytes ${from}-${to - 1}/${picture.length}` });
  response.end(picture.subarray(from, to));
});

/** Opens the full-window page; `encoder` has the requests for what gives texels to labels. */
async function open(name, backend, answer = (route) => route.continue()) {
  asked = [];
  const tab = await harness.newPage(run.browser, { viewport: VIEWPORT });
  const encoder = [];
  tab.page.context().on('request', (request) => {
    if (/labels\.js|fitter|encoder/.test(request.url())) encoder.push(request.url().split('/').at(-1));
  });
  await tab.page.context().route('**/istar_encoder_bg.wasm', answer);
  const url = `${run.server.url}view.html?backend=${backend}&src=${encodeURIComponent(files.base + name)}`;
  await tab.page.goto(url);
  return { ...tab, encoder };
}

async function settled(page) {
  await harness.event(page, 'load');
  await page.evaluate(() => document.querySelector('istar-viewer').painted);
}

async function looksRight(page, name) {
  const place = await harness.place(page);
  const actual = await harness.shot(page);
  harness.assertAlike(name, actual, harness.oracle(file, place, VIEWPORT));
}

for (const backend of [...harness.BACKENDS, 'cpu']) {
  test(`tiles of labels with ${backend} look like the oracle`, async () => {
    const { page, uncaught, encoder, close } = await open('quilt.istar', backend);
    await settled(page);
    // Almost all of it; where four tiles meet, from close by and from further off; and at a level between.
    for (const [x, y, scale] of [
      [505.3, 380.7, 0.251],
      [256, 256, 1.5],
      [512.25, 384.5, 40],
      [550, 350, 0.4],
    ]) {
      await harness.zoomTo(page, x, y, scale);
      await looksRight(page, `label-tiles-${scale}-${backend}`);
    }
    assert.deepEqual(uncaught, []);
    // One worker has had all tiles; without a GPU another one paints with the same module.
    const once = ['istar-fitter.js', 'istar-labels.js', 'istar_encoder_bg.wasm'];
    const expected = backend === 'cpu' ? [...once, 'istar_encoder_bg.wasm'] : once;
    assert.deepEqual(encoder.sort(), expected);
    await close();
  });
}

test('a view fetches the tiles of labels that it shows, each once', async () => {
  const { page, close } = await open('quilt.istar', 'webgl2');
  await settled(page);
  asked = [];
  await harness.zoomTo(page, 450.5, 450.5, 3);
  const bytes = asked.reduce((sum, [from, to]) => sum + to - from, 0);
  console.log(`a place: ${asked.length} requests, ${bytes} bytes of ${whole.length}`);
  assert.ok(asked.length <= 2 && bytes < whole.length / 6, `${asked.length} requests, ${bytes} bytes`);
  asked = [];
  await harness.zoomTo(page, 455.5, 450.5, 3.5);
  assert.deepEqual(asked, []);
  await close();
});

test('a damaged tile of labels is replaced by what is coarser, and the others are sharp', async () => {
  const { page, uncaught, close } = await open('damaged.istar', 'webgl2');
  await settled(page);
  await harness.zoomTo(page, 960.5, 700.5, 4);
  assert.ok(harness.colors(await harness.shot(page)) > 1);
  await harness.zoomTo(page, 350.5, 250.5, 2);
  await looksRight(page, 'label-tiles-beside-damaged');
  assert.deepEqual(uncaught, []);
  await close();
});

test('what is coarse is shown while the worker is at work, and a figure that goes leaves the next one its turn', async () => {
  const held = [];
  let isHeld = true;
  const { page, uncaught, close } = await open('quilt.istar', 'webgl2', (route) =>
    isHeld ? held.push(route) : route.continue(),
  );
  while (held.length === 0) await page.waitForTimeout(50);
  await page.evaluate((src) => {
    const old = document.querySelector('istar-viewer');
    const figure = old.cloneNode();
    old.remove();
    window.seen = [];
    figure.addEventListener('load', () => window.seen.push({ name: 'load' }));
    figure.src = src;
    document.body.append(figure);
  }, `${files.base}quilt.istar`);
  isHeld = false;
  await page.waitForTimeout(100);
  for (const route of held) await route.continue();
  await settled(page);
  assert.deepEqual(uncaught, []);
  await close();
});

test('an encoder that cannot be fetched is told, and may be tried again', async () => {
  let isGone = true;
  const { page, uncaught, close } = await open('quilt.istar', 'webgl2', (route) =>
    isGone ? route.fulfill({ status: 503 }) : route.continue(),
  );
  assert.equal((await harness.event(page, 'error')).kind, 'http');
  isGone = false;
  await page.evaluate((src) => {
    window.seen = [];
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}quilt.istar?again`);
  await settled(page);
  await harness.zoomTo(page, 350.5, 250.5, 2);
  await looksRight(page, 'label-tiles-again');
  assert.deepEqual(uncaught, []);
  await close();
});
