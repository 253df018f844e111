// A page that was there once is there without its server, by the service worker that a page may have.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import * as harness from './harness.mjs';

let browser;
before(async () => {
  browser = await harness.launch();
});
after(() => browser?.close());

test('after the first load a page and its figure are there without a server', async () => {
  const server = await harness.serve();
  const { page, uncaught, close } = await harness.newPage(browser);
  try {
    await harness.openViewer(page, server.url, { place: '3018,684,4' });
    await page.addScriptTag({ url: 'istar-offline.js' });
    const address = page.url();
    // What was fetched before the worker was there, too.
    await page.evaluate(async (address) => {
      const wanted = [
        address,
        'istar.js',
        'istar_bg.wasm',
        'istar-webgl2.js',
        'gallery/map.istar',
        'page.css',
      ];
      const isKept = async () => (await Promise.all(wanted.map((url) => caches.match(url)))).every(Boolean);
      while (!(await isKept())) await new Promise((next) => setTimeout(next, 20));
    }, address);
    const before = await harness.shot(page);

    server.stop();
    await page.goto('about:blank');
    await page.goto(address);
    await harness.event(page, 'load');
    assert.deepEqual(await harness.shot(page), before);
    // What was never asked for is not there, and says so.
    await page.evaluate(() => {
      document.querySelector('istar-viewer').src = 'gallery/other.istar';
    });
    assert.equal((await harness.event(page, 'error')).kind, 'network');
    assert.deepEqual(uncaught, []);
  } finally {
    server.stop();
    await close();
  }
});
