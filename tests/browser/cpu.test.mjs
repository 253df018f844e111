// Without a GPU a worker draws, tile by tile, what a GPU would.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { PNG } from 'pngjs';
import { at, checkedCli as cli } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';

const SIZE = { width: 480, height: 360 };
/** The painter is within two levels of the reference, as a GPU is. */
const CHANNEL = 3;

const run = harness.session();
const folder = harness.temporaryFolder();
const [crop, tiles] = [at('tests', 'fixtures', 'crop.png'), join(folder, 'tiles.istar')];
execFileSync(cli, ['encode', crop, '-o', tiles, '--tile-size', '64'], { stdio: 'ignore' });
execFileSync(cli, ['encode', crop, '-o', join(folder, 'labels.istar'), '--lossless'], { stdio: 'ignore' });

async function newPage(options) {
  const tab = await harness.newPage(run.browser, { viewport: SIZE, reducedMotion: 'reduce', ...options });
  const asked = [];
  tab.page.context().on('request', (request) => {
    if (/cpu|painter|encoder/.test(request.url())) asked.push(request.url().split('/').at(-1));
  });
  await tab.page.route('**/made/*', (route) => {
    route.fulfill({ body: readFileSync(join(folder, route.request().url().split('/').at(-1))) });
  });
  return { ...tab, asked };
}

/** No GPU for the page; a 2D canvas is one of the browser's own. */
function withoutGpu(page) {
  return page.addInitScript(() => {
    delete Navigator.prototype.gpu;
    const getContext = OffscreenCanvas.prototype.getContext;
    OffscreenCanvas.prototype.getContext = function (kind, ...rest) {
      return kind === '2d' ? getContext.call(this, kind, ...rest) : null;
    };
  });
}

const backend = (page) => page.evaluate(() => document.querySelector('istar-viewer').backend);

function alike(actual, expected, name) {
  harness.assertAlike(name, actual, expected, { channel: CHANNEL });
}

const VIEWS = {
  'gallery/map.istar': [
    [2896, 1448, 0.08],
    [3080, 740, 1],
    [3080, 740, 30],
    [3080, 740, 1000],
    [3080, 740, 30_000],
  ],
  'made/tiles.istar': [
    [128, 96, 1.5],
    [128.3, 64.7, 12],
    [100, 100, 0.4],
  ],
  'made/labels.istar': [[128, 96, 3]],
};
for (const [src, views] of Object.entries(VIEWS)) {
  test(`${src}: a worker and WebGL2 draw the same`, async () => {
    const [gpu, cpu] = [await newPage(), await newPage()];
    await harness.openViewer(gpu.page, run.server.url, { src, backend: 'webgl2' });
    await harness.openViewer(cpu.page, run.server.url, { src, backend: 'cpu' });
    assert.deepEqual([await backend(gpu.page), await backend(cpu.page)], ['webgl2', 'cpu']);
    assert.equal(await cpu.page.locator('istar-viewer .backend').textContent(), 'CPU');
    assert.deepEqual(await harness.place(cpu.page), await harness.place(gpu.page));
    alike(await harness.shot(cpu.page), await harness.shot(gpu.page), 'cpu-whole');
    for (const [x, y, scale] of views) {
      // From close by, at a boundary of the view before.
      const aim = scale > 10 ? await harness.boundaryInSight(gpu.page) : { x, y };
      for (const { page } of [gpu, cpu]) await harness.zoomTo(page, aim.x, aim.y, scale);
      alike(await harness.shot(cpu.page), await harness.shot(gpu.page), `cpu-${scale}`);
      // The main thread has the same picture.
      const pick = () => document.querySelector('istar-viewer').pick(241, 181);
      assert.equal(await cpu.page.evaluate(pick), await gpu.page.evaluate(pick));
    }
    assert.deepEqual([...gpu.uncaught, ...cpu.uncaught], []);
    assert.ok(!gpu.asked.some((name) => /cpu|painter/.test(name)), 'with a GPU no painter is fetched');
    await gpu.close();
    await cpu.close();
  });
}

test('without any GPU a worker draws', async () => {
  const { page, uncaught, asked, close } = await newPage();
  await withoutGpu(page);
  await harness.openViewer(page, run.server.url, { backend: 'auto' });
  assert.equal(await backend(page), 'cpu');
  assert.deepEqual(asked.sort(), ['istar-cpu.js', 'istar-painter.js', 'istar_encoder_bg.wasm']);
  await harness.zoomTo(page, 3018.4, 684.3, 30);
  const place = await harness.place(page);
  alike(
    await harness.shot(page),
    harness.oracle(at('dist', 'gallery', 'map.istar'), place, SIZE),
    'cpu-auto',
  );
  assert.deepEqual(uncaught, []);
  await close();
});

test('a drag is followed to its end, however many frames it takes', async () => {
  const { page, uncaught, close } = await newPage();
  await harness.openViewer(page, run.server.url, { backend: 'cpu' });
  await harness.zoomTo(page, 3000, 1400, 2);
  await page.mouse.move(100, 150);
  await page.mouse.down();
  for (let i = 1; i <= 40; i++) await page.mouse.move(100 + 5 * i, 150 + 2 * i);
  await page.mouse.up();
  const place = await harness.place(page);
  assert.deepEqual(place, { x: 2900, y: 1360, scale: 2, rotation: 0, flipped: false });
  alike(
    await harness.shot(page),
    harness.oracle(at('dist', 'gallery', 'map.istar'), place, SIZE),
    'cpu-drag',
  );
  assert.deepEqual(uncaught, []);
  await close();
});

test('paper gets its 300 dots an inch at once, with styles', async () => {
  const { page, uncaught, close } = await newPage();
  await harness.openViewer(page, run.server.url, { src: 'made/tiles.istar', backend: 'cpu' });
  // Strips above the picture, within it and below.
  for (const [x, y, scale] of [
    [128.3, 10.5, 5],
    [100, 96, 1.2],
  ]) {
    await harness.zoomTo(page, x, y, scale);
    const styles = await page.evaluate(() => {
      const viewer = document.querySelector('istar-viewer');
      viewer.styles = { all: { opacity: 0.75 } };
      viewer.setStyle(viewer.pick(240, 240), { color: '#1e90ff' });
      return viewer.styles;
    });
    const place = await harness.place(page);
    const { sizes, data } = await page.evaluate(() => {
      const viewer = document.querySelector('istar-viewer');
      dispatchEvent(new Event('beforeprint'));
      const canvases = [...viewer.shadowRoot.querySelectorAll('.stage canvas')];
      const sizes = canvases.map(({ width, height }) => [width, height]);
      const data = canvases[1].toDataURL().split(',')[1];
      dispatchEvent(new Event('afterprint'));
      return { sizes, data };
    });
    assert.deepEqual(sizes, [
      [480, 360],
      [1500, 1125],
    ]);
    const expected = harness.oracle(
      tiles,
      { ...place, scale: (place.scale * 300) / 96 },
      { width: 1500, height: 1125 },
      styles,
    );
    alike(PNG.sync.read(Buffer.from(data, 'base64')), expected, `cpu-paper-${scale}`);
    // The screen goes on as it was.
    const screen = harness.oracle(tiles, place, SIZE, styles);
    alike(await harness.shot(page), screen, `cpu-after-paper-${scale}`);
  }
  const pdf = (await page.pdf({ width: '480px', height: '360px' })).toString('latin1');
  assert.match(pdf, /\/Width 1500\b/);
  assert.deepEqual(uncaught, []);
  await close();
});

test('two figures share one worker, and a new size is drawn', async () => {
  const { page, uncaught, close } = await newPage({ viewport: { width: 900, height: 700 } });
  const workers = [];
  page.on('worker', (worker) => workers.push(worker));
  await page.goto(`${run.server.url}?backend=cpu`);
  await page.waitForFunction(() => window.seen.filter(({ name }) => name === 'load').length === 2);
  assert.equal(workers.length, 1);
  const width = () =>
    page.evaluate(async () => {
      const viewer = document.querySelector('istar-viewer');
      await viewer.painted;
      return viewer.shadowRoot.querySelector('canvas').width;
    });
  const before = await width();
  await page.setViewportSize({ width: 500, height: 700 });
  await page.waitForFunction(
    (before) => document.querySelector('istar-viewer').clientWidth < before - 100,
    before,
  );
  await page.waitForTimeout(200);
  assert.ok((await width()) < before - 100);
  assert.deepEqual(uncaught, []);
  await close();
});

test('a worker that ends is replaced, once', async () => {
  const { page, uncaught, close } = await newPage();
  await page.addInitScript(() => {
    window.workers = [];
    const Real = window.Worker;
    window.Worker = class extends Real {
      constructor(...rest) {
        super(...rest);
        window.workers.push(this);
      }
    };
  });
  await harness.openViewer(page, run.server.url, { backend: 'cpu' });
  await harness.zoomTo(page, 3018, 684, 8);
  const before = await harness.shot(page);
  // What a worker says whose memory ran out.
  const fail = () =>
    page.evaluate(() => {
      const data = { kind: 'gpu', message: 'unreachable' };
      window.workers.at(-1).dispatchEvent(new MessageEvent('message', { data }));
    });
  await fail();
  // What is there need not be drawn again.
  await harness.zoomTo(page, 3018, 684, 9);
  await harness.zoomTo(page, 3018, 684, 8);
  assert.equal(await page.evaluate(() => window.workers.length), 2);
  assert.deepEqual(await harness.shot(page), before);
  assert.equal(await page.evaluate(() => window.seen.some(({ name }) => name === 'error')), false);
  assert.deepEqual(uncaught, []);
  await close();
});

test('a viewer without its painter says what is wrong with the GPU', async () => {
  const { page, uncaught, close } = await newPage();
  await withoutGpu(page);
  await page.route('**/istar-cpu.js', (route) => route.fulfill({ status: 404 }));
  await page.goto(`${run.server.url}view.html?src=gallery/map.istar`);
  const { kind, message } = await harness.event(page, 'error');
  assert.deepEqual([kind, message], ['gpu', 'this browser has no WebGL2']);
  assert.deepEqual(uncaught, []);
  await close();
});
