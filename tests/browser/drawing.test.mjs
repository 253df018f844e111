// Both back ends draw what the CPU draws, at every depth.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { at } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';

/**
 * The GPU computes in f32 and the CPU in f64: where a boundary passes within rounding of a pixel's edge or three regions meet, a pixel
 * may fall to the other side. Elsewhere only the last step of rounding a colour differs.
 */
const CHANNEL_TOLERANCE = 2;
const DIFFERING_SHARE = 0.001;

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
  assert.ok(harness.colors(expected) > 1, 'the oracle shows a single colour: the view is badly chosen');
  assert.ok(harness.colors(actual) > 1, 'the canvas is blank');
  const { share, picture } = harness.difference(actual, expected, CHANNEL_TOLERANCE);
  if (share <= DIFFERING_SHARE) return;
  const kept = harness.keepFailure(label, expected, picture, actual);
  assert.fail(`${(share * 100).toFixed(3)} % of the pixels differ, see ${kept}`);
}
