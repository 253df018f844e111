// Our own pages: every link leads somewhere, and the comparison shows one view of two files.
import assert from 'node:assert/strict';
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { at } from '../../web/tasks/project.mjs';
import { site } from '../../web/tasks/site.mjs';
import * as harness from '../browser/harness.mjs';
import { answerFrom } from './installed.mjs';

const folder = at('target', 'site');
const files = harness.serveFiles((request, response) => answerFrom(folder, request, response));
let browser;
before(async () => {
  site();
  browser = await harness.launch();
});
after(() => browser?.close());

test('every link and image of the site is there, and so is every element', () => {
  const pages = readdirSync(folder).filter((name) => name.endsWith('.html'));
  assert.equal(pages.length, 6);
  for (const name of pages) {
    const html = readFileSync(`${folder}/${name}`, 'utf8');
    // Code shows how links are written, and leads nowhere.
    const written = html.replace(/<pre>[\s\S]*?<\/pre>|<code>[\s\S]*?<\/code>/g, '');
    for (const [, target] of written.matchAll(/(?:href|src)="([^"]+)"/g)) {
      if (/^(https?|data):|^#/.test(target)) continue;
      assert.ok(existsSync(`${folder}/${target.split('#')[0]}`), `${name}: ${target}`);
    }
  }
  const api = readFileSync(`${folder}/api.html`, 'utf8');
  for (const said of [
    '&lt;istar-viewer&gt;',
    '&lt;istar-legend&gt;',
    'zoomTo()',
    'regionclick',
    '--istar-ink',
  ]) {
    assert.ok(api.includes(said), said);
  }
});

test('the museum finds its material and its pictures', async () => {
  const { page, uncaught, close } = await harness.newPage(browser, { reducedMotion: 'reduce' });
  await page.goto(`${files.base}museum.html?backend=webgl2`);
  await page.waitForSelector('html[data-ready]');
  assert.deepEqual(uncaught, []);
  await close();
});

test('the comparison lays the other file over the same view', async () => {
  const { page, uncaught, close } = await harness.newPage(browser, { viewport: { width: 800, height: 700 } });
  await page.goto(`${files.base}index.html?backend=webgl2`);
  await harness.event(page, 'load');
  const compared = page.locator('.compare').first();
  await compared.getByLabel('SVG').check();
  await compared.getByText(/SVG 66 KB, at/).waitFor();
  await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    viewer.zoomTo(1500, 1900, 0.5);
    await viewer.painted;
  });
  // All of it is the other's, then all IStar's: an SVG is as sharp, so that both look alike.
  const shots = [];
  for (const share of ['0', '100']) {
    await compared.getByRole('slider').fill(share);
    await page.evaluate(() => document.querySelector('.compare img[src]').decode());
    shots.push(await compared.locator('.both').screenshot());
  }
  const { PNG } = await import('pngjs');
  const [other, own] = shots.map((shot) => PNG.sync.read(shot));
  let differing = 0;
  for (let i = 0; i < own.data.length; i += 4) if (Math.abs(own.data[i] - other.data[i]) > 40) differing++;
  const share = (4 * differing) / own.data.length;
  assert.ok(harness.colors(own) > 5 && harness.colors(other) > 5, 'there is something to see');
  assert.ok(share < 0.03, `${(share * 100).toFixed(2)} % of the pixels differ`);
  assert.deepEqual(uncaught, []);
  await close();
});
