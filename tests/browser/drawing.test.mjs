// Both back ends draw what the CPU draws, at every depth.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { at } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';

const SIZE = { width: 480, height: 360 };
/** Places with boundaries in sight, in source pixels. */
const PICTURES = {
  map: { x: 3080, y: 740 },
  emblem: { x: 2972, y: 1420 },
};

const run = harness.session();

for (const backend of harness.BACKENDS) {
  for (const [name, middle] of Object.entries(PICTURES)) {
    test(`${name} with ${backend} looks like the oracle`, async (t) => {
      const { page, uncaught, close } = await harness.newPage(run.browser, { viewport: SIZE });
      await harness.openViewer(page, run.server.url, { src: `gallery/${name}.istar`, backend });
      assert.equal(await page.evaluate(() => document.querySelector('istar-viewer').backend), backend);

      await t.test('all of it', () => matches(page, `${name}-${backend}-fit`, name));
      // From each view on to a boundary in it, looked at from closer by.
      let aim = middle;
      for (const scale of [1, 30, 1000]) {
        await harness.zoomTo(page, aim.x, aim.y, scale);
        await t.test(`${scale}×`, () => matches(page, `${name}-${backend}-${scale}`, name));
        aim = await harness.boundaryInSight(page);
      }

      assert.deepEqual(uncaught, []);
      await close();
    });
  }
}

async function matches(page, label, name) {
  const place = await harness.place(page);
  const actual = await harness.shot(page);
  const expected = harness.oracle(at('dist', 'gallery', `${name}.istar`), place, SIZE);
  harness.assertAlike(label, actual, expected);
}
