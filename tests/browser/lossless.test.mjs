// Files without loss: a worker fetches the encoder and fits texels before anything is drawn.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { at, checkedCli as cli } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';
import { encodedLands } from './pictures.mjs';

const SIZE = { width: 480, height: 360 };

const run = harness.session();
const folder = harness.temporaryFolder();
const [file, lands] = [join(folder, 'crop.istar'), encodedLands(folder)];
execFileSync(cli, ['encode', at('tests', 'fixtures', 'crop.png'), '-o', file, '--lossless']);
const files = harness.serveFiles((request, response) => {
  const bytes = readFileSync(request.url.startsWith('/lands') ? lands : file);
  // Its labels are at the end.
  if (request.url.startsWith('/damaged')) bytes[bytes.length - 9] ^= 1;
  response.end(bytes);
});

/** Opens the full-window page and notes which files of the encoder it asks for. */
async function opened(src, backend) {
  const tab = await harness.newPage(run.browser, { viewport: SIZE });
  const asked = [];
  tab.page.context().on('request', (request) => {
    if (/fitter|encoder/.test(request.url())) asked.push(request.url().split('/').at(-1));
  });
  await tab.page.goto(`${run.server.url}view.html?backend=${backend}&src=${encodeURIComponent(src)}`);
  return { ...tab, asked };
}

for (const backend of harness.BACKENDS) {
  test(`a file without loss with ${backend} looks like the oracle`, async () => {
    const { page, uncaught, close } = await opened(`${files.base}crop.istar`, backend);
    await harness.event(page, 'load');
    const place = await harness.place(page);
    const actual = await harness.shot(page);
    const expected = harness.oracle(file, place, SIZE);
    harness.assertAlike(`lossless-${backend}`, actual, expected);
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('a damaged file without loss is told, and the next one is shown', async () => {
  const { page, uncaught, close } = await opened(`${files.base}damaged.istar`, 'webgl2');
  assert.equal((await harness.event(page, 'error')).kind, 'malformed');
  await page.evaluate((src) => {
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}crop.istar`);
  await harness.event(page, 'load');
  assert.deepEqual(uncaught, []);
  await close();
});

test('the encoder is fetched only for files without loss', async () => {
  const { page, asked, close } = await opened(`${files.base}lands.istar`, 'webgl2');
  await harness.event(page, 'load');
  assert.deepEqual(asked, []);
  await page.evaluate((src) => {
    window.seen = [];
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}crop.istar`);
  await harness.event(page, 'load');
  assert.deepEqual(asked.sort(), ['istar-fitter.js', 'istar_encoder_bg.wasm']);
  await close();
});

test('a figure that goes while texels are fitted ends its worker, and the next one gets its own', async () => {
  const { page, uncaught, close } = await opened(`${files.base}lands.istar`, 'webgl2');
  await harness.event(page, 'load');
  // The first encoder never arrives: its worker is there until the figure goes.
  let held = true;
  await page.context().route('**/istar_encoder_bg.wasm', (route) => {
    if (held) return new Promise(() => {});
    return route.continue();
  });
  const started = page.waitForEvent('worker');
  await page.evaluate((src) => {
    const figure = document.createElement('istar-viewer');
    figure.src = src;
    document.body.append(figure);
  }, `${files.base}crop.istar`);
  const ended = (await started).waitForEvent('close');
  await page.evaluate(() => document.querySelectorAll('istar-viewer')[1].remove());
  await ended;
  held = false;
  await page.evaluate((src) => {
    window.seen = [];
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}crop.istar`);
  await harness.event(page, 'load');
  assert.deepEqual(uncaught, []);
  await close();
});
