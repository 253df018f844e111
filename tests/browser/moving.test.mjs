// Pointer, wheel, touch and keys move the view; the readout and the events follow. No matter which back end draws.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { afterEach, beforeEach, test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedQuilt } from './pictures.mjs';

const run = harness.session();
const file = encodedQuilt(harness.temporaryFolder(), 'quilt', [600, 300], '--texel-size', '8');
const files = harness.serveFiles((_, response) => response.end(readFileSync(file)));
const open = (page) => harness.openViewer(page, run.server.url, { src: `${files.base}quilt.istar` });
let page;
let uncaught;
let close;
beforeEach(async () => {
  ({ page, uncaught, close } = await harness.newPage(run.browser, {
    hasTouch: true,
    reducedMotion: 'reduce',
  }));
  await open(page);
});
afterEach(async () => {
  assert.deepEqual(uncaught, []);
  await close();
});

const near = (actual, expected, tolerance = 1e-6) =>
  assert.ok(
    Math.abs(actual - expected) <= tolerance * Math.max(1, Math.abs(expected)),
    `${actual} is not ${expected}`,
  );

/** The source place under a pixel of the window. */
const under = ({ x, y, scale }, px, py) => ({ x: x + (px - 240) / scale, y: y + (py - 180) / scale });

test('a drag moves the picture with the pointer', async () => {
  await harness.zoomTo(page, 300, 150, 2);
  await page.mouse.move(200, 150);
  await page.mouse.down();
  await page.mouse.move(210, 160);
  await page.mouse.move(260, 130);
  await page.mouse.up();
  const { x, y, scale } = await harness.place(page);
  near(x, 300 - 60 / 2);
  near(y, 150 + 20 / 2);
  near(scale, 2);
});

test('a thrown picture coasts, unless motion is unwanted', async () => {
  for (const [reducedMotion, coasts] of [
    ['reduce', false],
    ['no-preference', true],
  ]) {
    await page.emulateMedia({ reducedMotion });
    await harness.zoomTo(page, 300, 150, 2);
    const mouse = await harness.timedMouse(page);
    await mouse.press(100, 100, 0);
    for (let i = 1; i <= 8; i++) await mouse.drag(100 + 20 * i, 100, 10 * i);
    await mouse.release(260, 100, 90);
    if (coasts) {
      // The pointer let go at 220.
      await page.waitForFunction(() => window.seen.at(-1).detail?.x < 215);
    } else {
      await page.waitForTimeout(500);
      near((await harness.place(page)).x, 300 - 160 / 2);
    }
  }
});

test('the wheel zooms about the pointer', async () => {
  await harness.zoomTo(page, 300, 150, 2);
  const before = await harness.place(page);
  await page.mouse.move(100, 300);
  await page.mouse.wheel(0, -200);
  await page.waitForFunction(
    (n) => window.seen.length > n,
    await page.evaluate(() => window.seen.length - 1),
  );
  await page.waitForTimeout(100);
  const now = await harness.place(page);
  assert.ok(now.scale > 2.5, `the scale is ${now.scale}`);
  near(under(now, 100, 300).x, under(before, 100, 300).x);
  near(under(now, 100, 300).y, under(before, 100, 300).y);
});

test('a double click zooms in there, with shift out', async () => {
  await harness.zoomTo(page, 300, 150, 2);
  const before = await harness.place(page);
  const mouse = await harness.timedMouse(page);
  const doubleClick = async (at, modifiers) => {
    for (const later of [0, 100]) {
      await mouse.press(100, 300, at + later, modifiers);
      await mouse.release(100, 300, at + later + 50, modifiers);
    }
  };
  await doubleClick(0);
  const inside = await harness.place(page);
  near(inside.scale, 4);
  near(under(inside, 100, 300).x, under(before, 100, 300).x);
  // Later than a double click, or the two pairs would count as one. 8 is the shift key.
  await doubleClick(1000, 8);
  near((await harness.place(page)).scale, 2);
});

test('two fingers pinch', async () => {
  await harness.zoomTo(page, 300, 150, 2);
  const before = await harness.place(page);
  const touch = await page.context().newCDPSession(page);
  const send = (type, ...points) =>
    touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y, id]) => ({ x, y, id })) });
  await send('touchStart', [200, 180, 1]);
  await send('touchStart', [200, 180, 1], [240, 180, 2]);
  for (let i = 1; i <= 10; i++) await send('touchMove', [200 - 4 * i, 180, 1], [240 + 4 * i, 180, 2]);
  await send('touchEnd');
  const now = await harness.place(page);
  near(now.scale, 2 * (120 / 40), 0.02);
  near(under(now, 220, 180).x, under(before, 220, 180).x, 0.001);
});

test('keys pan, zoom and show all', async () => {
  const fitted = await harness.place(page);
  await page.keyboard.press('Tab');
  await harness.zoomTo(page, 300, 150, 2);
  const steps = [
    ['ArrowRight', { x: 332, y: 150, scale: 2 }],
    ['ArrowLeft', { x: 300, y: 150, scale: 2 }],
    ['ArrowDown', { x: 300, y: 182, scale: 2 }],
    ['ArrowUp', { x: 300, y: 150, scale: 2 }],
    ['+', { x: 300, y: 150, scale: 3 }],
    ['-', { x: 300, y: 150, scale: 2 }],
    ['0', fitted],
    ['+', { ...fitted, scale: fitted.scale * 1.5 }],
    ['Home', fitted],
  ];
  for (const [key, expected] of steps) {
    await page.keyboard.press(key);
    const now = await harness.place(page);
    for (const name of ['x', 'y', 'scale']) near(now[name], expected[name]);
  }
});

test('the focused figure shows a ring', async () => {
  const ring = () =>
    page.evaluate(() => {
      const stage = document.querySelector('istar-viewer').shadowRoot.querySelector('.stage');
      return getComputedStyle(stage, '::after').borderTopWidth;
    });
  assert.equal(await ring(), '0px');
  await page.keyboard.press('Tab');
  assert.equal(await ring(), '3px');
});

test('hover names the region, and a click reports it', async () => {
  const readout = page.locator('istar-viewer .region');
  await assert.rejects(readout.waitFor({ timeout: 200 }), 'nothing is hovered yet');
  await page.mouse.move(240, 180);
  await readout.waitFor();
  const region = await page.evaluate(() => document.querySelector('istar-viewer').pick(240, 180));
  assert.equal(await readout.textContent(), `region ${region}`);
  assert.deepEqual(await harness.event(page, 'regionenter'), { region, name: undefined });

  await page.mouse.click(240, 180);
  assert.deepEqual(await harness.event(page, 'regionclick'), { region, name: undefined });

  // The picture is twice as wide as high: there is nothing of it at the window's top.
  await page.mouse.move(240, 5);
  assert.deepEqual(await harness.event(page, 'regionleave'), { region, name: undefined });
  await readout.waitFor({ state: 'hidden' });
});

test('a box and a lasso tell the regions within', async () => {
  const found = await page.evaluate(() => {
    const viewer = document.querySelector('istar-viewer');
    const within = (...outline) => viewer.regionsWithin(outline);
    const around = within([235, 175], [245, 175], [245, 185], [235, 185]);
    return {
      picked: viewer.pick(240, 180),
      around,
      all: within([0, 0], [480, 0], [480, 360], [0, 360]).length,
      above: within([0, 0], [480, 0], [480, 5], [0, 5]),
      nothing: within([1, 1], [2, Number.NaN]),
    };
  });
  assert.ok(found.around.includes(found.picked));
  assert.deepEqual(
    found.around,
    [...found.around].sort((a, b) => a - b),
  );
  assert.ok(found.all > 50, `${found.all} of the quilt's 100`);
  assert.deepEqual([found.above, found.nothing], [[], []]);
});

test('the region under a resting pointer follows the view', async () => {
  await harness.zoomTo(page, 32, 32, 8);
  await page.mouse.move(240, 180);
  const here = await harness.event(page, 'regionenter');
  await page.evaluate(() => {
    window.seen = [];
  });
  await harness.zoomTo(page, 480, 160, 8);
  const there = await harness.event(page, 'regionenter');
  assert.notDeepEqual(there, here);
});

test('the readout tells zoom and back end', async () => {
  await harness.zoomTo(page, 300, 150, 12.5);
  assert.equal(await page.locator('istar-viewer .zoom').textContent(), '12.5×');
  assert.equal(await page.locator('istar-viewer .backend').textContent(), 'WebGL2');
});

test('every move is one viewchange, and nothing is drawn without a change', async () => {
  await page.evaluate(() => {
    window.seen = [];
  });
  await page.waitForTimeout(200);
  assert.deepEqual(await page.evaluate(() => window.seen), []);
  await harness.zoomTo(page, 300, 150, 2);
  const seen = await page.evaluate(() => window.seen);
  assert.deepEqual(
    seen.map(({ name }) => name),
    ['viewchange'],
  );
});

test('the view stays whole when the window changes, and a hidden figure comes back', async () => {
  const before = await harness.place(page);
  await page.setViewportSize({ width: 240, height: 360 });
  await page.waitForFunction((scale) => window.seen.at(-1).detail?.scale < scale * 0.6, before.scale);
  await page.evaluate(() => {
    document.querySelector('istar-viewer').style.display = 'none';
  });
  await page.setViewportSize({ width: 480, height: 360 });
  await page.evaluate(() => {
    document.querySelector('istar-viewer').style.display = '';
  });
  await page.waitForFunction((scale) => window.seen.at(-1).detail?.scale === scale, before.scale);
  assert.ok(harness.colors(await harness.shot(page)) > 1);
});

test('a dense screen gets all of its pixels, and scales stay in CSS pixels', async () => {
  const dense = await harness.newPage(run.browser, { deviceScaleFactor: 2, reducedMotion: 'reduce' });
  await open(dense.page);
  const { width, height } = await harness.shot(dense.page);
  assert.deepEqual({ width, height }, { width: 960, height: 720 });
  near((await harness.place(dense.page)).scale, (await harness.place(page)).scale);
  await harness.zoomTo(dense.page, 300, 150, 2);
  await dense.page.mouse.move(240, 180);
  await dense.page.mouse.down();
  await dense.page.mouse.move(260, 180);
  await dense.page.mouse.up();
  const place = await harness.place(dense.page);
  near(place.scale, 2);
  near(place.x, 290);
  await dense.close();
});
