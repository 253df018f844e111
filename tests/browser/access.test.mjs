// axe finds nothing to blame: on the gallery page with all that may stand beside a picture, a legend, a walk, and an error.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { at } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';
import { encodedLands } from './pictures.mjs';

const run = harness.session();
const folder = harness.temporaryFolder();
encodedLands(folder);

/** What axe has to say of a page as it is, in a line for each fault. */
async function faults(page) {
  const { violations } = await page.evaluate(() => window.axe.run());
  return violations.flatMap(({ id, help, nodes }) =>
    nodes.map(({ target, failureSummary }) => `${id}: ${help}: ${target} ${failureSummary}`),
  );
}

for (const colorScheme of ['light', 'dark']) {
  test(`the gallery page and a legend are for everybody, ${colorScheme}`, async () => {
    const { page, uncaught, close } = await harness.newPage(run.browser, {
      viewport: { width: 900, height: 600 },
      colorScheme,
    });
    await page.route('**/gallery/*', (route) =>
      route.fulfill({ body: readFileSync(join(folder, 'lands.istar')) }),
    );
    await page.goto(`${run.server.url}?backend=webgl2`);
    await page.waitForFunction(() => window.seen.filter(({ name }) => name === 'load').length === 2);
    await page.addScriptTag({ path: at('node_modules', 'axe-core', 'axe.min.js') });
    await page.evaluate(() => {
      document.querySelector('figcaption').append(document.createElement('istar-legend'));
      return import('./istar-legend.js');
    });
    await page.locator('istar-legend').getByText('Lake').waitFor();
    await page.getByRole('button', { name: 'Opacity and outline of Lake' }).click();
    await page.locator('istar-viewer .controls').first().waitFor();
    await page.locator('istar-viewer .stage').first().focus();
    await page.keyboard.press('Enter');
    await page
      .locator('istar-viewer .spoken')
      .first()
      .getByText(/borders/)
      .waitFor();
    assert.deepEqual(await faults(page), []);

    await page.evaluate(() => {
      document.querySelector('istar-viewer').src = 'nothing.istar';
    });
    await page.getByRole('button', { name: 'Retry' }).waitFor();
    assert.deepEqual(await faults(page), []);
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('in forced colours everything has an edge', async () => {
  const { page, close } = await harness.newPage(run.browser, { forcedColors: 'active' });
  await page.route('**/lands.istar', (route) =>
    route.fulfill({ body: readFileSync(join(folder, 'lands.istar')) }),
  );
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=lands.istar`);
  await harness.event(page, 'load');
  await page.evaluate(() => {
    for (const name of ['controls', 'navigator', 'scalebar'])
      document.querySelector('istar-viewer').setAttribute(name, '');
  });
  await page.locator('istar-viewer .frame').waitFor();
  const edges = await page.evaluate(() => {
    const root = document.querySelector('istar-viewer').shadowRoot;
    const names = ['.controls', '.scalebar', '.overview', '.frame', '.status'];
    return names.map((name) => {
      const { borderBottomWidth, borderBottomColor } = getComputedStyle(root.querySelector(name));
      return [name, parseFloat(borderBottomWidth) >= 1, borderBottomColor];
    });
  });
  // Opaque, whatever the theme has: the user's colours.
  for (const [name, isWide, color] of edges) assert.ok(isWide && /^rgb\(/.test(color), `${name} ${color}`);
  await close();
});
