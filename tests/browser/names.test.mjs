// What regions are called: told on hover and in events, and read by a module of its own.
import assert from 'node:assert/strict';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedQuilt } from './pictures.mjs';

const SIZE = { width: 480, height: 360 };

const run = harness.session();
const folder = harness.temporaryFolder();
const table = join(folder, 'names.csv');
// The first square and its disc; and one that the picture does not have.
writeFileSync(table, 'color,name\n#e6003c,Crête d’Or\n#00c85a,"Lake, deep"\n#123456,Nowhere\n');
for (const [name, ...options] of [
  ['texels', '--texel-size', '8'],
  ['labels', '--lossless'],
]) {
  encodedQuilt(folder, name, [128, 128], '--names', table, ...options);
}
encodedQuilt(folder, 'plain', [128, 128], '--texel-size', '8');
const files = harness.serveFolder(folder);

/** Opens the full-window page and notes whether it asks for the module that reads names. */
async function opened(name) {
  const tab = await harness.newPage(run.browser, { viewport: SIZE });
  const asked = [];
  tab.page.context().on('request', (request) => asked.push(request.url().split('/').at(-1)));
  const src = encodeURIComponent(`${files.base}${name}.istar`);
  await tab.page.goto(`${run.server.url}view.html?backend=webgl2&src=${src}`);
  await harness.event(tab.page, 'load');
  await harness.zoomTo(tab.page, 32, 32, 5);
  return { ...tab, asked };
}

/** The window's place of one of the picture's pixels. */
const at = (x, y) => [SIZE.width / 2 + (x - 32) * 5, SIZE.height / 2 + (y - 32) * 5];

for (const name of ['texels', 'labels']) {
  test(`regions of a file of ${name} have its names`, async () => {
    const { page, uncaught, asked, close } = await opened(name);
    const readout = page.locator('istar-viewer .region');
    await page.mouse.move(...at(32, 32));
    await readout.getByText('Lake, deep').waitFor();
    const { region, name: entered } = await harness.event(page, 'regionenter');
    assert.equal(entered, 'Lake, deep');
    await page.mouse.click(...at(3, 3));
    await readout.getByText('Crête d’Or').waitFor();
    assert.equal((await harness.event(page, 'regionclick')).name, 'Crête d’Or');
    const told = (region) =>
      page.evaluate((id) => document.querySelector('istar-viewer').regionName(id), region);
    assert.equal(await told(region), 'Lake, deep');
    // Another square has no name.
    await page.mouse.move(...at(68, 3));
    await readout.getByText(/^region \d+$/).waitFor();
    assert.equal(await told(10_000), undefined);
    const regions = await page.evaluate(() => document.querySelector('istar-viewer').regions);
    assert.deepEqual(
      regions.filter((one) => one.region === region),
      [{ region, name: 'Lake, deep', color: '#00c85aff' }],
    );
    assert.ok(regions.every((one, i) => i === 0 || one.region > regions[i - 1].region));
    assert.equal(asked.filter((file) => file === 'istar-names.js').length, 1);
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('a file without names asks for no module that reads them', async () => {
  const { page, asked, close } = await opened('plain');
  await page.mouse.move(...at(32, 32));
  await page
    .locator('istar-viewer .region')
    .getByText(/^region \d+$/)
    .waitFor();
  assert.ok(!asked.includes('istar-names.js'));
  await close();
});

test('where that module is missing, regions have numbers', async () => {
  const tab = await harness.newPage(run.browser, { viewport: SIZE });
  await tab.page.route('**/istar-names.js', (route) => route.fulfill({ status: 404 }));
  const src = encodeURIComponent(`${files.base}texels.istar`);
  await tab.page.goto(`${run.server.url}view.html?backend=webgl2&src=${src}`);
  await harness.event(tab.page, 'load');
  await harness.zoomTo(tab.page, 32, 32, 5);
  await tab.page.mouse.move(...at(32, 32));
  await tab.page
    .locator('istar-viewer .region')
    .getByText(/^region \d+$/)
    .waitFor();
  assert.deepEqual(tab.uncaught, []);
  await tab.close();
});
