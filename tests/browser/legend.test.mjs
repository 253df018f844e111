// The legend: names that are searched, hidden, recoloured and lit, beside a viewer.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedQuilt } from './pictures.mjs';

const run = harness.session();
const folder = harness.temporaryFolder();
// The first square and its disc, and some that the picture does not have.
const NAMES = ['#e6003c,Crête d’Or', '#00c85a,Lake'];
for (const [name, more] of [
  ['few', 0],
  ['many', 30],
]) {
  const table = join(folder, `${name}.csv`);
  const others = Array.from({ length: more }, (_, i) => `#0000${String(10 + i)},Isle ${i}`);
  writeFileSync(table, [...NAMES, ...others].join('\n'));
  encodedQuilt(folder, name, [128, 128], '--texel-size', '8', '--names', table);
}
encodedQuilt(folder, 'plain', [128, 128], '--texel-size', '8');
const files = harness.serveFolder(folder);

/** A page with a viewer of a file, and a legend. */
async function opened(name) {
  const tab = await harness.newPage(run.browser, { viewport: { width: 480, height: 360 } });
  const src = encodeURIComponent(`${files.base}${name}.istar`);
  await tab.page.goto(`${run.server.url}view.html?backend=webgl2&src=${src}`);
  await tab.page.evaluate(() => {
    const legend = document.createElement('istar-legend');
    legend.style.cssText = 'position: fixed; inset: 0 auto auto 0; background: Canvas';
    document.body.append(legend);
    return import('./istar-legend.js');
  });
  await harness.event(tab.page, 'load');
  await harness.zoomTo(tab.page, 32, 32, 5);
  return { ...tab, legend: tab.page.locator('istar-legend') };
}

/** The colour at one of the picture's pixels. */
async function colorAt(page, x, y) {
  const png = await harness.shot(page);
  const from = 4 * (png.width * (180 + (y - 32) * 5) + 240 + (x - 32) * 5);
  return [...png.data.subarray(from, from + 4)];
}

test('a box hides what it names, a field recolours it, and the styles tell', async () => {
  const { page, uncaught, legend, close } = await opened('few');
  await legend.getByText('Lake').waitFor();
  assert.deepEqual(await legend.locator('li').allTextContents(), ['Crête d’Or', 'Lake']);
  assert.ok(await legend.getByRole('searchbox').isHidden(), 'two names are seen at a glance');
  assert.deepEqual(await colorAt(page, 32, 32), [0, 200, 90, 255]);

  await legend.getByRole('checkbox', { name: 'Lake' }).uncheck();
  assert.equal((await colorAt(page, 32, 32))[3], 0);
  await legend.getByRole('checkbox', { name: 'Lake' }).check();
  await legend.getByLabel('Colour of Lake').fill('#102030');
  await page.mouse.move(400, 300);
  assert.deepEqual(await colorAt(page, 32, 32), [16, 32, 48, 255]);
  assert.deepEqual(await page.evaluate(() => document.querySelector('istar-viewer').styles.colors), {
    '#00c85aff': { visible: true, color: '#102030' },
  });

  // The name under the pointer lights its regions, and a region under the pointer its name.
  await legend.getByText('Crête d’Or').hover();
  const lit = await colorAt(page, 3, 3);
  await page.mouse.move(240, 180);
  assert.notDeepEqual(lit, await colorAt(page, 3, 3));
  await legend.locator('li[data-current]').getByText('Lake').waitFor();
  assert.deepEqual(uncaught, []);
  await close();
});

test('of many names some are found', async () => {
  const { legend, uncaught, close } = await opened('many');
  const search = legend.getByRole('searchbox');
  await search.fill('CRETE');
  assert.deepEqual(await legend.locator('li:visible').allTextContents(), ['Crête d’Or']);
  await search.fill('isle 2');
  assert.equal(await legend.locator('li:visible').count(), 11);
  await search.fill('');
  assert.equal(await legend.locator('li:visible').count(), 32);
  assert.deepEqual(uncaught, []);
  await close();
});

test('another picture has its own names, and one without names no legend', async () => {
  const { page, legend, uncaught, close } = await opened('plain');
  assert.ok(await legend.isHidden());
  await page.evaluate((src) => {
    window.seen = [];
    customElements.get('istar-viewer').words = { 'Colour of {name}': 'Farbe von {name}' };
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}few.istar`);
  await legend.getByLabel('Farbe von Lake').waitFor();
  // Of a viewer that is not there nothing is told.
  await page.evaluate(() => document.querySelector('istar-legend').setAttribute('for', 'nobody'));
  await legend.waitFor({ state: 'hidden' });
  assert.deepEqual(uncaught, []);
  await close();
});
