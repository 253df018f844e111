// Regions by keyboard: from neighbour to neighbour, lifted out and spoken of.
import assert from 'node:assert/strict';
import { after, beforeEach, test } from 'node:test';
import * as harness from './harness.mjs';
import { encodedLands } from './pictures.mjs';

const VIEWPORT = { width: 480, height: 360 };

const run = harness.session();
const folder = harness.temporaryFolder();
encodedLands(folder);
const files = harness.serveFolder(folder);

let page;
let uncaught;
let close;
beforeEach(async () => {
  // One for all: they only walk about.
  if (!page) await start();
});
after(async () => {
  assert.deepEqual(uncaught, []);
  await close();
});

async function start() {
  ({ page, uncaught, close } = await harness.newPage(run.browser, { viewport: VIEWPORT }));
  const src = encodeURIComponent(`${files.base}lands.istar`);
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${src}`);
  await harness.event(page, 'load');
  await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    await viewer.names;
    viewer.insertAdjacentHTML('afterend', '<button>After</button>');
  });
}

const heard = (text) => page.locator('istar-viewer .spoken').getByText(text).waitFor();
const press = (key) => page.keyboard.press(key);
/** What happened since the last time. */
const seen = () =>
  page.evaluate(() => {
    const [told, others] = [true, false].map((isRegion) =>
      window.seen.filter(({ name }) => name.startsWith('region') === isRegion),
    );
    window.seen = others;
    return told;
  });

/** Focuses the figure and begins, at the region in the middle. */
async function walk() {
  await page.locator('istar-viewer .stage').focus();
  await press('Escape');
  await seen();
  await press('Enter');
}

test('a walk begins in the middle, and arrows go to the neighbour that lies there', async () => {
  await walk();
  await heard(/^Middle, borders /);
  const spoken = await page.locator('istar-viewer .spoken').textContent();
  assert.deepEqual(spoken.slice('Middle, borders '.length).split(', ').sort(), [
    'Lake',
    'North',
    'West',
    'blue region 3',
  ]);
  for (const [key, text] of [
    ['ArrowLeft', /^West, borders /],
    ['ArrowRight', /^Middle, borders /],
    ['ArrowRight', /^blue region \d, borders /],
    ['ArrowRight', 'No region that way'],
    ['ArrowUp', /^North, borders /],
    ['ArrowDown', /^Middle, borders /],
    ['ArrowDown', 'Lake, borders Middle'],
    ['ArrowRight', /^Middle, borders /],
  ]) {
    await press(key);
    await heard(text);
  }
  const events = await seen();
  assert.deepEqual(
    events.slice(0, 5).map(({ name, detail }) => [name, detail.name]),
    [
      ['regionenter', 'Middle'],
      ['regionleave', 'Middle'],
      ['regionenter', 'West'],
      ['regionleave', 'West'],
      ['regionenter', 'Middle'],
    ],
  );
});

test('the region is lifted out and named, Enter clicks it, and Escape ends it all', async () => {
  const colorAt = async (x, y) => {
    const { data, width } = await harness.shot(page);
    return [...data.subarray(4 * (y * width + x), 4 * (y * width + x) + 3)];
  };
  await press('Escape');
  await page.evaluate(() => document.querySelector('istar-viewer').fit());
  const plain = await colorAt(240, 180);
  await walk();
  await heard(/^Middle, borders /);
  assert.notDeepEqual(await colorAt(240, 180), plain);
  assert.equal(await page.locator('istar-viewer .region').textContent(), 'Middle');
  const pin = await page.locator('istar-viewer .pin').boundingBox();
  const pinned = await page.evaluate(
    ([x, y]) => {
      const viewer = document.querySelector('istar-viewer');
      return viewer.regionName(viewer.pick(x, y));
    },
    [pin.x + pin.width / 2, pin.y + pin.height / 2],
  );
  assert.equal(pinned, 'Middle');
  await seen();
  await press('Enter');
  await press(' ');
  assert.deepEqual(
    (await seen()).map(({ name, detail }) => [name, detail.name]),
    [
      ['regionclick', 'Middle'],
      ['regionclick', 'Middle'],
    ],
  );
  await press('Escape');
  assert.deepEqual(await colorAt(240, 180), plain);
  assert.deepEqual(
    (await seen()).map(({ name }) => name),
    ['regionleave'],
  );
  // Arrows are the view's again.
  const before = await harness.place(page);
  await press('ArrowLeft');
  assert.notEqual((await harness.place(page)).x, before.x);
});

test('Tab goes once around the neighbours, and then on in the page', async () => {
  await page.evaluate(() => document.querySelector('istar-viewer').fit());
  await walk();
  await heard(/^Middle, borders /);
  for (const name of [/^North, /, /^blue region 3, /, /^Lake, /, /^West, /]) {
    await press('Tab');
    await heard(name);
  }
  await press('Shift+Tab');
  await heard(/^Lake, /);
  await press('Tab');
  await press('Tab');
  assert.equal(await page.evaluate(() => document.activeElement.textContent), 'After');
  assert.equal(await page.locator('istar-viewer .spoken').textContent(), '');
  await walk();
  await heard(/^Middle, /);
  await press('Tab');
  await press('Shift+Tab');
  await heard(/^Middle, /);
  await press('Shift+Tab');
  assert.notEqual(await page.evaluate(() => document.activeElement.localName), 'istar-viewer');
});

test('the view follows to what is out of it, and rests where the region is in sight', async () => {
  await harness.zoomTo(page, 48, 60, 10);
  await walk();
  await heard(/^Middle, /);
  await press('ArrowLeft');
  await heard(/^West, /);
  const { x, y, scale } = await harness.place(page);
  assert.deepEqual([x, y, scale], [48, 60, 10]);
  await press('ArrowUp');
  await heard(/^North, /);
  const now = await harness.place(page);
  assert.ok(now.y < 16, `${now.y}`);
  assert.equal(now.scale, 10);
});

test('another picture ends the walk, and without its module keys move the view', async () => {
  await page.evaluate(() => document.querySelector('istar-viewer').fit());
  await walk();
  await heard(/^Middle, /);
  await page.evaluate(() => {
    window.seen = [];
    document.querySelector('istar-viewer').src += '?again';
  });
  await harness.event(page, 'load');
  assert.equal(await page.locator('istar-viewer .spoken').textContent(), '');
  await close();
  await start();
  await page.route('**/istar-walk.js', (route) => route.fulfill({ status: 404 }));
  await page.locator('istar-viewer .stage').focus();
  await press('Enter');
  const before = await harness.place(page);
  await press('ArrowLeft');
  assert.notEqual((await harness.place(page)).x, before.x);
});
