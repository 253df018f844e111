// The legend: names that are searched, hidden, recoloured and lit, beside a viewer.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
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

/** A page with a viewer of a file, and a legend with that attribute `hash`. */
async function opened(name, { hash = null, fragment = '' } = {}) {
  const tab = await harness.newPage(run.browser, { viewport: { width: 480, height: 360 } });
  const src = encodeURIComponent(`${files.base}${name}.istar`);
  await tab.page.goto(`${run.server.url}view.html?backend=webgl2&src=${src}${fragment}`);
  await tab.page.evaluate((hash) => {
    const legend = document.createElement('istar-legend');
    if (hash !== null) legend.setAttribute('hash', hash);
    legend.style.cssText = 'position: fixed; inset: 0 auto auto 0; background: Canvas';
    document.body.append(legend);
    return import('./istar-legend.js');
  }, hash);
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

test('opacity and outline of what has a name are behind a button', async () => {
  const { page, uncaught, legend, close } = await opened('few');
  const more = legend.getByRole('button', { name: 'Opacity and outline of Lake' });
  await more.click();
  assert.equal(await more.getAttribute('aria-expanded'), 'true');
  await legend.getByLabel('Opacity', { exact: true }).fill('0.5');
  await legend.getByLabel('Colour of the outline').fill('#ff0000');
  await legend.getByLabel('Width of the outline').fill('6');
  await page.mouse.move(400, 300);
  assert.equal((await colorAt(page, 32, 32))[3], 128);
  assert.deepEqual(await page.evaluate(() => document.querySelector('istar-viewer').styles.colors), {
    '#00c85aff': { opacity: 0.5, outline: { color: '#ff0000', width: 6 } },
  });
  await more.click();
  assert.ok(await legend.getByLabel('Width of the outline').isHidden());
  assert.deepEqual(uncaught, []);
  await close();
});

test('what is lit is so no longer when its name goes away under the pointer', async () => {
  const { page, uncaught, legend, close } = await opened('few');
  await legend.getByText('Lake').hover();
  const lit = () =>
    page.evaluate(() =>
      Object.values(document.querySelector('istar-viewer').styles.colors).some((style) => style.highlight),
    );
  assert.equal(await lit(), true);
  await page.evaluate(() => document.querySelector('istar-legend').setAttribute('for', 'nobody'));
  assert.equal(await lit(), false);
  assert.deepEqual(uncaught, []);
  await close();
});

test('styles are saved as JSON', async () => {
  const { page, uncaught, legend, close } = await opened('few');
  await legend.getByLabel('Colour of Lake').fill('#102030');
  // Under the pointer it is lit, which is nothing to keep.
  await legend.getByText('Lake').hover();
  const [saved] = await Promise.all([
    page.waitForEvent('download'),
    legend.getByRole('button', { name: 'Save styles' }).press('Enter'),
  ]);
  assert.equal(saved.suggestedFilename(), 'styles.json');
  assert.deepEqual(JSON.parse(readFileSync(await saved.path(), 'utf8')), {
    colors: { '#00c85aff': { color: '#102030' } },
  });
  assert.deepEqual(uncaught, []);
  await close();
});

test('styles are in the address of the page, and come from there', async () => {
  const { page, uncaught, legend, close } = await opened('few', { hash: '' });
  await legend.getByLabel('Colour of Lake').fill('#102030');
  await legend.getByRole('checkbox', { name: 'Crête d’Or' }).uncheck();
  await page.waitForFunction(() => location.hash.includes('styles=') && location.hash.includes('visible'));
  const { hash } = new URL(page.url());
  const styles = await page.evaluate(() => document.querySelector('istar-viewer').styles);
  await close();

  const other = await opened('few', { hash: '', fragment: hash });
  await other.page.waitForFunction(() => document.querySelector('istar-viewer').styles.colors['#00c85aff']);
  const told = await other.page.evaluate(() => document.querySelector('istar-viewer').styles);
  delete styles.colors['#e6003cff'].highlight;
  assert.deepEqual(told, styles);
  assert.deepEqual(await colorAt(other.page, 32, 32), [16, 32, 48, 255]);
  assert.equal(await other.legend.getByLabel('Colour of Lake').inputValue(), '#102030');
  assert.ok(!(await other.legend.getByRole('checkbox', { name: 'Crête d’Or' }).isChecked()));
  assert.deepEqual([...uncaught, ...other.uncaught], []);
  await other.close();
});

test('an address that says nothing of use about styles does no harm', async () => {
  for (const text of ['%7B', '%', 'null', '5', '%22all%22', '%7B%22colors%22:%7B%22x%22:null%7D%7D']) {
    const { page, uncaught, close } = await opened('few', { hash: 'sheet', fragment: `#sheet=${text}` });
    assert.deepEqual(await colorAt(page, 32, 32), [0, 200, 90, 255], text);
    assert.deepEqual(uncaught, [], text);
    await close();
  }
});

test('within a viewer it lies over a corner, and belongs to that one', async () => {
  const { page, uncaught, close } = await opened('few');
  await page.evaluate(() => {
    const { src } = document.querySelector('istar-viewer');
    document.body.insertAdjacentHTML(
      'beforeend',
      `<istar-viewer id="second" controls alt="A quilt" src="${src}" style="width: 300px; height: 200px"><istar-legend slot="legend"></istar-legend></istar-viewer>`,
    );
  });
  const legend = page.locator('#second istar-legend');
  await legend.getByLabel('Colour of Lake').fill('#102030');
  const colors = (which) => page.evaluate((which) => document.querySelector(which).styles.colors, which);
  assert.equal((await colors('#second'))['#00c85aff'].color, '#102030');
  assert.deepEqual(await colors('istar-viewer'), {});
  const [viewer, box, buttons] = await Promise.all(
    ['#second', '#second istar-legend', '#second .controls'].map((one) => page.locator(one).boundingBox()),
  );
  assert.ok(box.x > viewer.x && box.x + box.width < buttons.x, JSON.stringify(box));
  assert.ok(box.y > viewer.y && box.y + box.height < viewer.y + viewer.height, JSON.stringify(box));
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
