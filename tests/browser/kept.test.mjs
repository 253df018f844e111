// A view that moves by whole pixels: what stays in sight is kept, what comes into sight is drawn, and both look as if all were drawn.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedQuilt } from './pictures.mjs';

const SIZE = { width: 480, height: 360 };
const ALL = SIZE.width * SIZE.height;
/** A worker paints within two levels of the reference, as a GPU draws. */
const ALIKE = { channel: 3, share: 0.004 };

const run = harness.session();
const folder = harness.temporaryFolder();
const quilt = encodedQuilt(folder, 'quilt', [600, 300], '--texel-size', '8');
const tiles = encodedQuilt(folder, 'tiles', [1024, 768], '--tile-size', '128', '--texel-size', '4');
/** What tiles wait for before they are sent. */
let held = Promise.resolve();
const files = harness.serveFiles(async (request, response) => {
  const bytes = readFileSync(join(folder, request.url.slice(1)));
  const range = /bytes=(\d+)-(\d+)/.exec(request.headers.range ?? '');
  if (!range) return response.end(bytes);
  const [from, to] = [Number(range[1]), Math.min(Number(range[2]) + 1, bytes.length)];
  if (from > 0) await held;
  response.setHeader('access-control-expose-headers', 'content-range');
  response.writeHead(206, { 'content-range': `bytes ${from}-${to - 1}/${bytes.length}` });
  response.end(bytes.subarray(from, to));
});

/** The full-window page with a picture at a place. What is put on the figure's canvas is noted: its pixels, and moves of what is there. */
async function open({ name = 'quilt', backend = 'webgl2', place = '300,150,2', ...options } = {}) {
  const tab = await harness.newPage(run.browser, { viewport: SIZE, reducedMotion: 'reduce', ...options });
  await tab.page.addInitScript(() => {
    window.drawn = [];
    const { drawImage } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.drawImage = function (image, ...at) {
      if (this.canvas.getRootNode() instanceof ShadowRoot)
        window.drawn.push(image === this.canvas ? { by: at } : { pixels: at[2] * at[3] });
      return drawImage.call(this, image, ...at);
    };
  });
  const src = `${files.base}${name}.istar`;
  await harness.openViewer(tab.page, run.server.url, { src, backend, place });
  await tab.page.evaluate(() => document.querySelector('istar-viewer').painted);
  return tab;
}

/** Drags through places, and gives back what was put on the canvas meanwhile. */
async function drag(page, [first, ...rest]) {
  await page.evaluate(() => {
    window.drawn = [];
  });
  await page.mouse.move(...first);
  await page.mouse.down();
  for (const to of rest) {
    await page.mouse.move(...to);
    await page.evaluate(() => document.querySelector('istar-viewer').painted);
  }
  await page.mouse.up();
  return page.evaluate(async () => {
    await document.querySelector('istar-viewer').painted;
    return window.drawn;
  });
}

const pixels = (drawn) => drawn.reduce((sum, { pixels = 0 }) => sum + pixels, 0);

async function looksRight(page, label, file, { styles, size = SIZE } = {}) {
  const place = await harness.place(page);
  const expected = harness.oracle(
    file,
    { ...place, scale: place.scale * (size.width / SIZE.width) },
    size,
    styles,
  );
  harness.assertAlike(label, await harness.shot(page), expected, ALIKE);
}

/** To all sides, along one axis and along both. */
const ABOUT = [
  [240, 180],
  [233, 183],
  [240, 160],
  [240, 190],
  [260, 190],
  [221, 177],
  [225, 177],
];

const PLACES = ['300,150,2', '310.3,148.8,0.45', '290,160,2,30', '290,160,3,270,flipped'];

for (const backend of [...harness.BACKENDS, 'cpu'])
  test(`a drag with ${backend} draws what comes into sight`, async () => {
    const { page, uncaught, close } = await open({ backend });
    const check = async (place) => {
      const drawn = await drag(page, ABOUT);
      assert.equal(drawn.filter(({ by }) => by).length, ABOUT.length - 1);
      assert.ok(pixels(drawn) < (ABOUT.length - 1) * 0.15 * ALL, `${pixels(drawn)} pixels`);
      await looksRight(page, `kept-${backend}-${place}`, quilt);
    };
    for (const place of PLACES) {
      await page.evaluate(async (place) => {
        const viewer = document.querySelector('istar-viewer');
        viewer.place = place;
        await viewer.painted;
      }, place);
      await check(place);
    }
    // The rim of a disc, from close by.
    await page.evaluate(() => document.querySelector('istar-viewer').turnTo(0, false));
    let aim = { x: 300, y: 150 };
    for (const scale of [2, 60, 1500]) {
      await harness.zoomTo(page, aim.x, aim.y, scale);
      aim = await harness.boundaryInSight(page);
    }
    await harness.zoomTo(page, aim.x, aim.y, 1500);
    await check('1500');
    assert.deepEqual(uncaught, []);
    await close();
  });

test('a drag on a screen with parts of pixels goes by whole ones, and stays with the pointer', async () => {
  const { page, close } = await open({ deviceScaleFactor: 1.3 });
  const before = await harness.place(page);
  const drawn = await drag(page, ABOUT);
  assert.equal(drawn.filter(({ by }) => by).length, ABOUT.length - 1);
  for (const { by } of drawn) assert.ok(!by || by.every(Number.isInteger), `moved by ${by}`);
  await looksRight(page, 'kept-parts', quilt, { size: { width: 624, height: 468 } });
  const { x, y } = await harness.place(page);
  const off = Math.hypot((before.x - x) * 2 - (225 - 240), (before.y - y) * 2 - (177 - 180));
  assert.ok(off < 1, `${off} pixels off`);
  await close();
});

test('what a view is moved by beside whole pixels does not add up', async () => {
  const { page, close } = await open();
  const drawn = await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    window.drawn = [];
    // A hundredth of a pixel more each time than three.
    for (let i = 1; i <= 100; i++) {
      viewer.zoomTo(300 + (3.01 / 2) * (i % 20), 150, 2);
      await viewer.painted;
    }
    return window.drawn;
  });
  assert.ok(pixels(drawn) > 20 * ALL, `${pixels(drawn)} pixels`);
  await looksRight(page, 'kept-beside', quilt);
  await close();
});

test('what is not the same any more is drawn anew', async () => {
  const { page, uncaught, close } = await open();
  const styles = { all: { outline: { color: '#000', width: 3 } } };
  const change = (what, value) =>
    page.evaluate(
      async ([what, value]) => {
        const viewer = document.querySelector('istar-viewer');
        window.drawn = [];
        // In the same frame as a move.
        viewer[what] = value;
        const [x, y, scale] = viewer.place.split(',').map(Number);
        viewer.zoomTo(x + 4, y, scale);
        await viewer.painted;
        return window.drawn;
      },
      [what, value],
    );
  // Frames that come late are drawn once more, sharply.
  const isAll = (drawn) => drawn.length > 0 && drawn.every(({ pixels }) => pixels === ALL);
  assert.ok(isAll(await change('styles', styles)));
  await looksRight(page, 'kept-styles', quilt, { styles });
  assert.equal(pixels(await change('title', 'nothing')), 8 * SIZE.height);
  await looksRight(page, 'kept-title', quilt, { styles });
  // A browser may have taken what was on the canvas.
  const restored = await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    window.drawn = [];
    viewer.shadowRoot.querySelector('.stage canvas').dispatchEvent(new Event('contextrestored'));
    await viewer.painted;
    return window.drawn;
  });
  assert.ok(isAll(restored));
  // So is all of it where little would be kept.
  await harness.zoomTo(page, 150, 150, 2);
  await page.evaluate(() => {
    window.drawn = [];
  });
  await harness.zoomTo(page, 150 + 150, 150, 2);
  assert.ok(isAll(await page.evaluate(() => window.drawn)));
  assert.deepEqual(uncaught, []);
  await close();
});

for (const backend of [...harness.BACKENDS, 'cpu'])
  test(`tiles that come are seen with ${backend}, also where coarser ones stood in`, async () => {
    const { page, uncaught, close } = await open({ name: 'tiles', backend, place: '200,200,3' });
    let release;
    held = new Promise((resolve) => {
      release = resolve;
    });
    await page.mouse.move(450, 330);
    await page.mouse.down();
    for (let i = 1; i <= 6; i++) {
      await page.mouse.move(450 - 60 * i, 330 - 30 * i);
      await page.waitForTimeout(100);
    }
    await page.mouse.up();
    const drawn = await page.evaluate(() => window.drawn);
    assert.ok(drawn.some(({ by }) => by));
    release();
    await looksRight(page, `kept-tiles-${backend}`, tiles);
    assert.deepEqual(uncaught, []);
    await close();
  });

test('a figure that only draws again what is there asks no GPU', async () => {
  const { page, close } = await open();
  await page.evaluate(() => {
    window.drawn = [];
  });
  await harness.zoomTo(page, 300, 150, 2);
  assert.deepEqual(await page.evaluate(() => window.drawn), []);
  await close();
});
