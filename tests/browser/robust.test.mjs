// Figures of odd sizes, out of sight, taken away while they load, on machines that are too slow.
import assert from 'node:assert/strict';
import { afterEach, beforeEach, test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedLands, encodedQuilt } from './pictures.mjs';

const VIEWPORT = { width: 480, height: 360 };

const run = harness.session();
const folder = harness.temporaryFolder();
const file = encodedQuilt(folder, 'quilt', [600, 300], '--texel-size', '8');
encodedLands(folder);
const files = harness.serveFolder(folder);
let page;
let uncaught;
let close;
beforeEach(async () => {
  await start({});
});
afterEach(async () => {
  assert.deepEqual(uncaught, []);
  await close();
});

async function start(options) {
  ({ page, uncaught, close } = await harness.newPage(run.browser, {
    viewport: VIEWPORT,
    reducedMotion: 'reduce',
    ...options,
  }));
  // What figures copy to the page, frame by frame, as [width, height] of what was drawn.
  await page.addInitScript(() => {
    window.copied = [];
    const { prototype } = CanvasRenderingContext2D;
    const { drawImage } = prototype;
    prototype.drawImage = function (...rest) {
      window.copied.push(rest.slice(3, 5));
      return drawImage.apply(this, rest);
    };
  });
}

const open = () => harness.openViewer(page, run.server.url, { src: `${files.base}quilt.istar` });
const frames = () => page.evaluate(() => window.copied.splice(0));
// Styles the figure, and waits until it has heard of its size: what is drawn sooner has the size before.
const style = (css) =>
  page.evaluate(async (css) => {
    document.querySelector('istar-viewer').style.cssText = css;
    for (let frame = 0; frame < 2; frame++) await new Promise(requestAnimationFrame);
  }, css);
const names = () => page.evaluate(() => window.seen.map(({ name }) => name));

async function looksRight(name, size) {
  const place = await harness.place(page);
  const actual = await harness.shot(page);
  const ratio = await page.evaluate(() => devicePixelRatio);
  const expected = harness.oracle(file, { ...place, scale: place.scale * ratio }, size);
  harness.assertAlike(`robust-${name}`, actual, expected);
}

test('a figure of another size shows the same place at the same scale, sharp', async () => {
  await open();
  await harness.zoomTo(page, 308, 150, 1.5);
  const before = await harness.place(page);
  for (const [width, height] of [
    [301, 123],
    [480, 1],
    [37, 200],
  ]) {
    await style(`width: ${width}px; height: ${height}px`);
    await page.waitForFunction(
      (height) => document.querySelector('istar-viewer').shadowRoot.querySelector('canvas').height === height,
      height,
    );
    assert.deepEqual(await harness.place(page), before);
    if (height > 1) await looksRight(`${width}`, { width, height });
  }
});

test('a screen of one and a half pixels a pixel gets all of them', async () => {
  await close();
  await start({ deviceScaleFactor: 1.5 });
  await open();
  await harness.zoomTo(page, 308, 150, 2);
  await looksRight('dense', { width: 720, height: 540 });
});

test('a figure without a size is no fault, and is drawn when it gets one', async () => {
  await page.addInitScript(() => {
    addEventListener('DOMContentLoaded', () => {
      document.querySelector('istar-viewer').style.cssText = 'width: 0; height: 0';
    });
  });
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${files.base}quilt.istar`);
  await page.waitForFunction(() => document.querySelector('istar-viewer')?.backend === 'webgl2');
  await page.evaluate(() => {
    const viewer = document.querySelector('istar-viewer');
    viewer.zoomTo(308, 150, 2);
    viewer.pick(0, 0);
    viewer.regionsWithin([[0, 0]]);
  });
  await page.waitForTimeout(200);
  assert.deepEqual(await frames(), []);
  assert.ok(!(await names()).some((name) => name !== 'progress'));
  await style('');
  await harness.event(page, 'load');
  await looksRight('appeared', VIEWPORT);
  await frames();
  for (const none of ['width: 0', 'height: 0', 'display: none', 'width: 0; height: 0']) {
    await style(none);
    await page.evaluate(() => document.querySelector('istar-viewer').zoomTo(309, 151, 2));
    await page.waitForTimeout(100);
  }
  assert.deepEqual(await frames(), []);
  await style('');
  await looksRight('came-back', VIEWPORT);
  assert.ok(!(await names()).includes('error'));
});

test('out of sight nothing is drawn but what is waited for', async () => {
  await open();
  await style('width: 480px; height: 360px; margin-bottom: 3000px');
  await page.evaluate(() => document.documentElement.classList.remove('full'));
  // The figure hears of it when others do.
  await page.evaluate(() => {
    scrollTo(0, 1500);
    return new Promise((unseen) => {
      const observer = new IntersectionObserver((entries) => {
        if (!entries.at(-1).isIntersecting) unseen();
      });
      observer.observe(document.querySelector('istar-viewer'));
    });
  });
  await page.waitForTimeout(200);
  await frames();
  for (let i = 0; i < 5; i++) {
    await page.evaluate((i) => document.querySelector('istar-viewer').zoomTo(308, 150 + i, 2), i);
    await page.waitForTimeout(30);
  }
  assert.deepEqual(await frames(), []);
  // A program that asks for the picture gets it.
  await looksRight('unseen', VIEWPORT);
  assert.equal((await frames()).length, 1);
  await page.evaluate(() => document.querySelector('istar-viewer').zoomTo(308, 150, 3));
  await page.waitForTimeout(100);
  assert.deepEqual(await frames(), []);
  await page.evaluate(() => scrollTo(0, 0));
  await page.waitForFunction(() => window.copied.length > 0);
  assert.equal((await harness.place(page)).scale, 3);
});

test('in a hidden tab nothing is drawn', async () => {
  await open();
  await frames();
  await page.evaluate(() => {
    // As in a tab that is not shown: nobody calls back.
    window.held = [];
    window.requestAnimationFrame = (step) => window.held.push(step);
  });
  for (let i = 0; i < 5; i++) {
    await page.evaluate((i) => document.querySelector('istar-viewer').zoomTo(308, 150 + i, 2), i);
  }
  await page.waitForTimeout(100);
  assert.deepEqual(await frames(), []);
  assert.equal(await page.evaluate(() => window.held.length), 1);
  await page.evaluate(() => window.held[0](performance.now()));
  assert.equal((await frames()).length, 1);
});

test('taken away or changed while it loads, over and over, a figure shows its last picture', async () => {
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${files.base}lands.istar`);
  await page.evaluate(async (base) => {
    const viewer = document.querySelector('istar-viewer');
    const pause = (ms) => new Promise((done) => setTimeout(done, ms));
    for (let i = 0; i < 30; i++) {
      viewer.src = `${base}${i % 2 ? 'quilt' : 'lands'}.istar`;
      await pause((i * 7) % 40);
      if (i % 3 === 0) viewer.remove();
      await pause((i * 5) % 30);
      if (!viewer.isConnected) document.body.append(viewer);
      if (i % 4 === 0) document.body.prepend(viewer);
    }
    viewer.src = `${base}lands.istar`;
    await pause(1);
    viewer.remove();
    window.seen = [];
    window.taken = viewer;
    await pause(300);
  }, files.base);
  assert.deepEqual(await names(), [], 'nothing is told of a figure that is gone');
  await page.evaluate((src) => {
    window.taken.src = src;
    document.body.append(window.taken);
  }, `${files.base}quilt.istar`);
  await harness.event(page, 'load');
  await looksRight('last', VIEWPORT);
  assert.deepEqual(
    (await names()).filter((name) => name === 'load'),
    ['load'],
  );
});

test('a view that moves too slowly is drawn coarsely, and sharply as soon as it rests', async () => {
  await open();
  await harness.zoomTo(page, 308, 150, 2);
  const still = await harness.shot(page);
  /** Moves for so many frames, and what was drawn until they were. */
  const move = (count) =>
    page.evaluate(async (count) => {
      const viewer = document.querySelector('istar-viewer');
      window.copied = [];
      for (let i = 0; i < count; i++) {
        // By parts of pixels: all of it is drawn.
        viewer.zoomTo(308 + 1.1 * i, 150, 2);
        await new Promise(requestAnimationFrame);
      }
      viewer.zoomTo(308, 150, 2);
      return window.copied.splice(0);
    }, count);
  // A clock by which every frame is in time.
  await page.evaluate(() => {
    let now = performance.now();
    performance.now = () => now;
    const frame = requestAnimationFrame;
    window.requestAnimationFrame = (step) =>
      frame(() => {
        now += 16;
        step(now);
      });
  });
  for (const size of await move(10)) assert.deepEqual(size, [480, 360]);
  // And one by which they are late.
  await page.evaluate(() => {
    delete performance.now;
    const real = performance.now.bind(performance);
    let late = 0;
    performance.now = () => real() + late;
    const frame = requestAnimationFrame;
    window.requestAnimationFrame = (step) =>
      frame((now) => {
        late += 40;
        step(now);
      });
  });
  await page.evaluate(() => document.querySelector('istar-viewer').painted);
  await page.waitForTimeout(200);
  const sizes = (await move(10)).map((size) => size.join('×'));
  assert.equal(sizes[0], '480×360');
  assert.equal(sizes.at(-1), '160×120');
  assert.ok(sizes.includes('240×180'));
  assert.deepEqual(await harness.shot(page), still);
  assert.deepEqual((await frames()).at(-1), [480, 360]);
});
