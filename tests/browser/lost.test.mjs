// Devices that are lost: who looks at a picture is to see nothing of it, and else what is wrong.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedLands } from './pictures.mjs';

const run = harness.session();
const folder = harness.temporaryFolder();
encodedLands(folder);
const files = harness.serveFolder(folder);

/** A page whose devices can be lost, by `lose()`, and denied, by `denied = true`. */
async function openLosable(backend) {
  const opened = await harness.newPage(run.browser);
  await opened.page.addInitScript(() => {
    window.taken = 0;
    const getContext = OffscreenCanvas.prototype.getContext;
    OffscreenCanvas.prototype.getContext = function (kind, ...rest) {
      if (kind === 'webgl2' && window.denied) return null;
      const context = getContext.call(this, kind, ...rest);
      if (kind === 'webgl2') {
        window.taken++;
        window.lose = () => context.getExtension('WEBGL_lose_context').loseContext();
      }
      return context;
    };
    const requestDevice = GPUAdapter.prototype.requestDevice;
    GPUAdapter.prototype.requestDevice = async function (...rest) {
      if (window.denied) throw new Error('denied');
      const device = await requestDevice.apply(this, rest);
      window.taken++;
      window.lose = () => device.destroy();
      return device;
    };
  });
  await harness.openViewer(opened.page, run.server.url, { src: `${files.base}lands.istar`, backend });
  return opened;
}

/** Loses the device, and moves until something comes of it: the browser takes its time to report the loss. */
function lose(page) {
  return page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    const before = window.taken;
    window.seen = [];
    window.lose();
    for (let i = 0; i < 50; i++) {
      viewer.zoomTo(32 + (i % 2), 30, 8);
      await new Promise((done) => setTimeout(done, 100));
      if (window.taken > before || window.seen.some(({ name }) => name === 'error')) break;
    }
  });
}

for (const backend of harness.BACKENDS) {
  test(`a lost ${backend} device is replaced, and the view goes on`, async () => {
    const { page, uncaught, close } = await openLosable(backend);
    await page.evaluate(() => {
      const viewer = document.querySelector('istar-viewer');
      viewer.styles = { all: { opacity: 0.5 }, regions: { 3: { color: 'teal' } } };
    });
    await harness.zoomTo(page, 32, 30, 8);
    const before = await harness.shot(page);
    const asked = [];
    page.on('request', (request) => asked.push(request.url()));
    await lose(page);
    assert.equal(await page.evaluate(() => window.taken), 2);
    await harness.zoomTo(page, 32, 30, 8);
    assert.deepEqual(await harness.shot(page), before);
    assert.equal(await page.evaluate(() => window.seen.some(({ name }) => name === 'error')), false);
    assert.deepEqual(asked, [], 'the tiles that were there are not fetched again');
    assert.deepEqual(uncaught, []);
    await close();
  });

  test(`a lost ${backend} device is replaced while the view rests, and nobody sees it`, async () => {
    const { page, uncaught, close } = await openLosable(backend);
    await harness.zoomTo(page, 32, 30, 8);
    const before = await harness.shot(page);
    const ms = await page.evaluate(async () => {
      const viewer = document.querySelector('istar-viewer');
      const start = performance.now();
      window.lose();
      const inTime = () => performance.now() - start < 10_000;
      while (window.taken === 1 && inTime()) await new Promise(requestAnimationFrame);
      await viewer.painted;
      return performance.now() - start;
    });
    console.log(`${backend}: the view is back ${ms.toFixed()} ms after the device was lost`);
    const after = await harness.shot(page);
    assert.deepEqual(after, before);
    assert.equal(await page.evaluate(() => window.taken), 2);
    assert.deepEqual(uncaught, []);
    await close();
  });

  test(`a lost ${backend} device that nothing replaces is an error, and retry takes a new one`, async () => {
    const { page, uncaught, close } = await openLosable(backend);
    await page.evaluate(() => {
      window.denied = true;
    });
    await lose(page);
    const detail = await harness.event(page, 'error');
    assert.equal(detail.kind, 'gpu');
    await page.locator('istar-viewer [role=alert]').getByText(detail.message).waitFor();
    await page.evaluate(() => {
      window.denied = false;
    });
    await page.getByRole('button', { name: 'Retry' }).click();
    await harness.event(page, 'load');
    assert.ok(harness.colors(await harness.shot(page)) > 1);
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('a lost device that nothing replaces leaves a worker to draw, where the choice is free', async () => {
  const { page, uncaught, close } = await openLosable('auto');
  await harness.zoomTo(page, 32, 30, 8);
  const before = await harness.shot(page);
  await page.evaluate(() => {
    window.denied = true;
    window.lose();
  });
  await page.waitForFunction(() => document.querySelector('istar-viewer').backend === 'cpu');
  await page.locator('istar-viewer .backend').getByText('CPU').waitFor();
  harness.assertAlike('denied', await harness.shot(page), before, { channel: 3, share: 0.001 });
  assert.deepEqual(uncaught, []);
  await close();
});
