// Styles of regions: what the page sets is what the command line draws, whatever draws it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { PNG } from 'pngjs';
import { at, checkedCli } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';

const SIZE = { width: 360, height: 270 };
const FILE = at('dist', 'gallery', 'map.istar');
const PLACE = '3080,740,2';

const run = harness.session();
const folder = harness.temporaryFolder();
const files = harness.serveFolder(folder);

async function opened(backend) {
  const opened = await harness.newPage(run.browser, { viewport: SIZE });
  await harness.openViewer(opened.page, run.server.url, { backend, place: PLACE });
  return opened;
}

/** The page's view against the CPU's, with the styles that the page has. */
async function matches(page, label) {
  const styles = await page.evaluate(() => document.querySelector('istar-viewer').styles);
  const actual = await harness.shot(page);
  const expected = harness.oracle(FILE, await harness.place(page), SIZE, styles);
  harness.assertAlike(`styles-${label}`, actual, expected);
  return actual;
}

function middle(png) {
  const from = 4 * (png.width * (png.height >> 1) + (png.width >> 1));
  return [...png.data.subarray(from, from + 4)];
}

for (const backend of [...harness.BACKENDS, 'cpu']) {
  test(`regions take styles with ${backend}`, async (t) => {
    const { page, uncaught, close } = await opened(backend);
    const set = (style) =>
      page.evaluate(async (style) => {
        const viewer = document.querySelector('istar-viewer');
        viewer.setStyle(viewer.pick(innerWidth / 2, innerHeight / 2), style);
        await viewer.painted;
      }, style);

    await t.test('a colour', async () => {
      await set({ color: 'rgb(250, 20, 130)' });
      assert.deepEqual(middle(await matches(page, `${backend}-color`)), [250, 20, 130, 255]);
    });
    await t.test('hidden', async () => {
      await set({ visible: false });
      assert.equal(middle(await matches(page, `${backend}-hidden`))[3], 0);
    });
    await t.test('absorbed', async () => {
      const before = await page.evaluate(() =>
        document.querySelector('istar-viewer').pick(innerWidth / 2, innerHeight / 2),
      );
      await set({ visible: 'absorbed' });
      assert.equal(middle(await matches(page, `${backend}-absorbed`))[3], 255);
      const picked = await page.evaluate(() =>
        document.querySelector('istar-viewer').pick(innerWidth / 2, innerHeight / 2),
      );
      assert.notEqual(picked, before);
      // What is said of the one that absorbs is said of both.
      await page.evaluate(async (picked) => {
        const viewer = document.querySelector('istar-viewer');
        viewer.setStyle(picked, { color: 'rgb(1, 99, 2)' });
        await viewer.painted;
      }, picked);
      assert.deepEqual(middle(await matches(page, `${backend}-absorber`)), [1, 99, 2, 255]);
      // A pick tells what is drawn: until that is painted, one absorbs the other.
      await page.evaluate(
        async ([before, picked]) => {
          const viewer = document.querySelector('istar-viewer');
          viewer.setStyle([before, picked], null);
          await viewer.painted;
        },
        [before, picked],
      );
    });
    await t.test('an outline and a pattern', async () => {
      await set({
        color: '#fff8',
        opacity: 0.8,
        highlight: true,
        outline: { color: 'crimson', width: 4, side: 'outside' },
        pattern: { motif: 'cross', color: '#00f', spacing: 16 },
      });
      await matches(page, `${backend}-outline`);
    });
    await t.test('taken away again', async () => {
      await set(null);
      assert.deepEqual(await page.evaluate(() => document.querySelector('istar-viewer').styles), {
        all: {},
        colors: {},
        regions: {},
      });
      await matches(page, `${backend}-plain`);
    });
    assert.deepEqual(uncaught, []);
    await close();
  });

  test(`a whole sheet is set at once with ${backend}`, async () => {
    const { page, uncaught, close } = await opened(backend);
    const region = await page.evaluate(() =>
      document.querySelector('istar-viewer').pick(innerWidth / 2, innerHeight / 2),
    );
    const sheet = {
      all: { outline: { color: '#222', width: 1.5, group: 3 } },
      colors: {},
      regions: { [region]: { color: '#e02020', outline: { color: '#fff', width: 2, unit: 'source' } } },
    };
    await page.evaluate(async (sheet) => {
      const viewer = document.querySelector('istar-viewer');
      viewer.styles = sheet;
      await viewer.painted;
    }, sheet);
    assert.deepEqual(middle(await matches(page, `${backend}-sheet`)), [0xe0, 0x20, 0x20, 255]);
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('an attribute draws lines along boundaries, and styles come before it', async () => {
  const { page, uncaught, close } = await opened('webgl2');
  const shotWith = async (outline, sheet) => {
    await page.evaluate(
      async ([outline, sheet]) => {
        const viewer = document.querySelector('istar-viewer');
        if (outline === null) viewer.removeAttribute('outline');
        else viewer.setAttribute('outline', outline);
        viewer.styles = sheet;
        await viewer.painted;
      },
      [outline, sheet],
    );
    return harness.shot(page);
  };
  const line = (width, color) => ({ all: { outline: { width, color } } });
  for (const [outline, width, color] of [
    ['', 1, '#000'],
    ['2.5px', 2.5, '#000'],
    ['crimson', 1, 'crimson'],
    ['3 #0f08', 3, '#0f08'],
  ]) {
    const drawn = await shotWith(outline, {});
    assert.ok(drawn.data.equals((await shotWith(null, line(width, color))).data), outline);
    assert.ok(!drawn.data.equals((await shotWith(null, {})).data), outline);
  }
  const both = await shotWith('9 blue', line(2, 'white'));
  assert.ok(both.data.equals((await shotWith(null, line(2, 'white'))).data));
  await shotWith('1.2.3.4 no such colour', {});
  assert.deepEqual(uncaught, []);
  await close();
});

test('all tiles agree on who absorbs a region', async () => {
  // A band lies along red for longest, and in some tiles red is out of sight.
  const png = new PNG({ width: 1200, height: 800 });
  for (let i = 0; i < 1200 * 800; i++) {
    const [x, y] = [i % 1200, Math.floor(i / 1200)];
    const isBand = y >= 300 && y < 340 && x > 100 && x < 1000;
    png.data.set(isBand ? [20, 160, 60, 255] : x <= 700 ? [200, 40, 40, 255] : [40, 40, 200, 255], 4 * i);
  }
  writeFileSync(join(folder, 'band.png'), PNG.sync.write(png));
  const file = join(folder, 'band.istar');
  execFileSync(checkedCli, ['encode', join(folder, 'band.png'), '-o', file, '--tile-size', '256']);
  const { page, uncaught, close } = await harness.newPage(run.browser, { viewport: SIZE });
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${files.base}band.istar#view=900,320,4`);
  await harness.event(page, 'load');
  await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    viewer.styles = { colors: { '#14a03c': { visible: 'absorbed' } } };
    await viewer.painted;
  });
  assert.deepEqual(middle(await harness.shot(page)), [200, 40, 40, 255]);
  const picked = await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    const absorber = viewer.pick(innerWidth / 2, innerHeight / 2);
    viewer.zoomTo(300, 100, 4);
    await viewer.painted;
    return [absorber, viewer.pick(innerWidth / 2, innerHeight / 2)];
  });
  assert.equal(picked[0], picked[1]);
  assert.deepEqual(uncaught, []);
  await close();
});

test('nonsense from a page does no harm', async () => {
  const { page, uncaught, close } = await opened('webgl2');
  await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    viewer.setStyle([-1, 1e9, Number.NaN, 2.5], { color: 'no colour', opacity: 7 });
    viewer.setStyle(1, { outline: { width: -3, side: 'left', group: 1e9 }, pattern: { motif: 'stars' } });
    viewer.styles = {};
    await viewer.painted;
  });
  await matches(page, 'nonsense');
  assert.deepEqual(uncaught, []);
  await close();
});
