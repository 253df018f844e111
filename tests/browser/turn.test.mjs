// Views that are turned and mirrored: what is drawn, what hands do with them, and what goes with them.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { PNG } from 'pngjs';
import { at, checkedCli as cli } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';
import { encodedLands } from './pictures.mjs';

const SIZE = { width: 480, height: 360 };
const MIDDLE = [SIZE.width / 2, SIZE.height / 2];
/** A worker paints within two levels of the reference, as a GPU draws. */
const CHANNEL = 3;

const run = harness.session();
const folder = harness.temporaryFolder();
const lands = encodedLands(folder);
const tiles = join(folder, 'tiles.istar');
const crop = at('tests', 'fixtures', 'crop.png');
execFileSync(cli, ['encode', crop, '-o', tiles, '--tile-size', '64'], { stdio: 'ignore' });
const map = at('dist', 'gallery', 'map.istar');

/** The full-window page with a picture, its figure with these attributes, as the address and the attributes say. */
async function open({
  src = 'made/lands.istar',
  backend = 'webgl2',
  place = '',
  attributes = {},
  ...options
} = {}) {
  const tab = await harness.newPage(run.browser, { viewport: SIZE, reducedMotion: 'reduce', ...options });
  await tab.page.route('**/made/*', (route) => {
    route.fulfill({ body: readFileSync(join(folder, route.request().url().split('/').at(-1))) });
  });
  await tab.page.addInitScript((attributes) => {
    addEventListener('DOMContentLoaded', () => {
      for (const [name, value] of Object.entries(attributes))
        document.querySelector('istar-viewer').setAttribute(name, value);
    });
  }, attributes);
  await harness.openViewer(tab.page, run.server.url, { src, backend, place });
  return tab;
}

/** Shows a place, turned. */
function show(page, place) {
  return page.evaluate(async (place) => {
    const viewer = document.querySelector('istar-viewer');
    viewer.place = place;
    await viewer.painted;
  }, place);
}

const shown = (page) =>
  page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    await viewer.painted;
    return viewer.place;
  });
const call = (page, name, ...values) =>
  page.evaluate(
    async ([name, values]) => {
      const viewer = document.querySelector('istar-viewer');
      viewer[name](...values);
      await viewer.painted;
    },
    [name, values],
  );

/** The source place under a pixel of the window. */
function under({ x, y, scale, rotation, flipped }, px, py) {
  const angle = (rotation * Math.PI) / 180;
  const [dx, dy] = [px - MIDDLE[0], py - MIDDLE[1]];
  const right = Math.cos(angle) * dx + Math.sin(angle) * dy;
  const down = Math.cos(angle) * dy - Math.sin(angle) * dx;
  return [x + (flipped ? -right : right) / scale, y + down / scale];
}

function near(actual, expected, within = 1e-6) {
  const off = Math.max(...[expected].flat().map((value, i) => Math.abs([actual].flat()[i] - value)));
  assert.ok(off <= within, `${actual} in place of ${expected}`);
}

for (const backend of harness.BACKENDS) {
  test(`${backend} draws what the oracle draws, at any angle`, async () => {
    const { page, uncaught, close } = await open({ src: 'gallery/map.istar', backend, place: '3080,740,1' });
    await show(page, '3080,740,1');
    let aim = await harness.boundaryInSight(page);
    for (const [scale, turns] of [
      [0.3, [',30']],
      [1, [',30', ',90', ',0,flipped']],
      [30, [',211.7,flipped', ',180']],
      [1000, [',45']],
      [1e9, [',30', ',270,flipped']],
    ]) {
      // A boundary in the middle, at any scale.
      for (const closer of [1, 30, 1e3, 1e5, 1e7].filter((closer) => closer < scale)) {
        await show(page, `${aim.x},${aim.y},${closer}`);
        aim = await harness.boundaryInSight(page);
      }
      for (const turn of turns) {
        await show(page, `${aim.x},${aim.y},${scale}${turn}`);
        const expected = harness.oracle(map, await harness.place(page), SIZE);
        harness.assertAlike(`turned-${backend}-${scale}${turn}`, await harness.shot(page), expected);
      }
    }
    assert.deepEqual(uncaught, []);
    await close();
  });

  test(`${backend} puts tiles together at any angle`, async () => {
    const { page, uncaught, close } = await open({ src: 'made/tiles.istar', backend });
    for (const place of ['128,96,3,30', '128.3,64.7,12,123,flipped', '250,100,4,90', '100,100,0.4,45']) {
      await show(page, place);
      // Tiles are sampled each for itself, which shows at their borders from far away.
      const expected = harness.oracle(tiles, await harness.place(page), SIZE);
      harness.assertAlike(`turned-tiles-${backend}-${place}`, await harness.shot(page), expected, {
        share: 0.005,
      });
    }
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('a worker turns too, with styles and without', async () => {
  const { page, uncaught, close } = await open({ backend: 'cpu' });
  const styles = { all: { outline: { color: '#fff', width: 3 } } };
  for (const sheet of [{}, styles]) {
    await page.evaluate((sheet) => {
      document.querySelector('istar-viewer').styles = sheet;
    }, sheet);
    for (const place of ['48,32,4,90', '48,32,4,30,flipped', '40,30,0.5,45']) {
      await show(page, place);
      const expected = harness.oracle(lands, await harness.place(page), SIZE, sheet);
      const label = `turned-cpu-${place}`;
      harness.assertAlike(label, await harness.shot(page), expected, { channel: CHANNEL, share: 0.004 });
    }
  }
  assert.deepEqual(uncaught, []);
  await close();
});

test('attributes, properties and a method turn it, and events tell', async () => {
  const { page, uncaught, close } = await open({ attributes: { rotation: '90', flipped: '' } });
  const { rotation, flipped, scale, x, y } = await harness.place(page);
  // All of 96 × 64 pixels, standing up.
  assert.deepEqual([rotation, flipped, scale, x, y], [90, true, 3.75, 48, 32]);
  assert.equal(await page.evaluate(() => document.querySelector('istar-viewer').rotation), 90);
  const set = (name, value) =>
    page.evaluate(
      ([name, value]) => {
        document.querySelector('istar-viewer')[name] = value;
      },
      [name, value],
    );
  const lies = async () => {
    const { rotation, flipped } = await harness.place(page);
    return [rotation, flipped];
  };
  await set('flipped', false);
  assert.deepEqual(await lies(), [90, false]);
  await set('rotation', -30);
  assert.deepEqual(await lies(), [330, false]);
  await call(page, 'turnTo', 45, true);
  assert.deepEqual(await lies(), [45, true]);
  // What it is set to counts, also where the attribute says so already.
  await set('rotation', -30);
  assert.deepEqual(await lies(), [330, true]);
  for (const nonsense of [Number.NaN, Number.POSITIVE_INFINITY, 'round']) {
    await call(page, 'turnTo', nonsense);
    assert.deepEqual(await lies(), [330, true], nonsense);
  }
  // It goes on to show all, and stays turned where it is moved.
  await call(page, 'turnTo', 0, false);
  assert.equal((await harness.place(page)).scale, 5);
  await call(page, 'turnTo', 20);
  await call(page, 'zoomTo', 30, 20, 7);
  assert.equal(await shown(page), '30,20,7,20');
  await call(page, 'fit');
  assert.equal((await harness.place(page)).rotation, 20);
  const corners = [
    under(await harness.place(page), 0, 0),
    under(await harness.place(page), ...Object.values(SIZE)),
  ];
  assert.ok(
    corners.flat().some((along) => along < 0),
    'all of it is in sight',
  );
  assert.deepEqual(uncaught, []);
  await close();
});

test('a link says how it is turned', async () => {
  const { page, uncaught, close } = await open({ place: '30,20,7,30.5,flipped' });
  assert.equal(await shown(page), '30,20,7,30.5,flipped');
  const fragment = (text) => page.waitForFunction((text) => location.hash === text, text);
  await call(page, 'turnTo', 1e-7, false);
  await fragment('#view=30,20,7,1e-7');
  await show(page, '30,20,7,1e-7');
  assert.equal(await shown(page), '30,20,7,1e-7');
  await page.evaluate(() => {
    location.hash = '#view=30,20,7';
  });
  await page.waitForFunction(() => document.querySelector('istar-viewer').place === '30,20,7');
  await call(page, 'fit');
  await fragment('');
  await call(page, 'turnTo', 90);
  await fragment('#view=48,32,3.75,90');
  assert.deepEqual(uncaught, []);
  await close();
});

test('pointers hold what is under them in a turned view', async () => {
  const { page, uncaught, close } = await open({ place: '48,32,8,30,flipped' });
  const before = await harness.place(page);
  await page.mouse.move(100, 300);
  await page.mouse.down();
  await page.mouse.move(150, 280);
  await page.mouse.move(180, 250);
  await page.mouse.up();
  const dragged = await harness.place(page);
  near(under(dragged, 180, 250), under(before, 100, 300));
  await page.mouse.wheel(0, -200);
  await page.waitForFunction((scale) => window.seen.at(-1).detail?.scale > scale, 8.1);
  near(under(await harness.place(page), 180, 250), under(dragged, 180, 250));
  // A box becomes the view, in its middle.
  await show(page, '48,32,4,30');
  const first = await harness.place(page);
  await page.keyboard.down('Shift');
  await page.mouse.move(300, 240);
  await page.mouse.down();
  await page.mouse.move(260, 200);
  await page.mouse.move(180, 150);
  await page.mouse.up();
  await page.keyboard.up('Shift');
  const { x, y, scale, rotation } = await harness.place(page);
  assert.deepEqual([scale, rotation], [16, 30]);
  near([x, y], under(first, 240, 195));
  // What is picked is what is seen.
  await show(page, '48,32,4,90');
  const pick = (x, y) => page.evaluate(([x, y]) => document.querySelector('istar-viewer').pick(x, y), [x, y]);
  const within = await page.evaluate(() =>
    document.querySelector('istar-viewer').regionsWithin([
      [330, 0],
      [360, 0],
      [360, 360],
      [330, 360],
    ]),
  );
  // The strip above is on the right.
  assert.deepEqual(within, [await pick(345, 180)]);
  assert.notEqual(await pick(200, 20), await pick(345, 180));
  assert.equal(await pick(100, 10), undefined);
  assert.deepEqual(uncaught, []);
  await close();
});

test('a drag with alt or ctrl turns about the middle, and is upright once it nearly is', async () => {
  const { page, uncaught, close } = await open({ place: '48,32,8' });
  const drag = async (key, ...places) => {
    await page.keyboard.down(key);
    const [first, ...others] = places;
    await page.mouse.move(...first);
    await page.mouse.down();
    for (const place of others) await page.mouse.move(...place);
    await page.mouse.up();
    await page.keyboard.up(key);
    return harness.place(page);
  };
  // From the right of the middle to below it, then on to the left.
  near((await drag('Alt', [340, 180], [310, 250], [240, 280])).rotation, 90);
  const half = await drag('Control', [240, 280], [170, 250], [140, 180]);
  near([half.rotation, half.x, half.y, half.scale], [180, 48, 32, 8]);
  const nearly = await drag('Alt', [140, 180], [240, 80], [340, 186]);
  assert.equal(nearly.rotation, 0);
  assert.equal((await shown(page)).split(',').length, 3);
  assert.equal(await page.evaluate(() => window.seen.some(({ name }) => name === 'regionclick')), false);
  assert.deepEqual(uncaught, []);
  await close();
});

test('two fingers twist, and a plain pinch does not', async () => {
  const { page, uncaught, close } = await open({ place: '48,32,8', hasTouch: true });
  const touch = await page.context().newCDPSession(page);
  const send = (type, ...points) =>
    touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y, id]) => ({ x, y, id })) });
  /** Two fingers go around the middle, from one angle to another. */
  const twist = async (from, to, apart = () => 60) => {
    const fingers = (part) => {
      const angle = ((from + (to - from) * part) * Math.PI) / 180;
      const [x, y] = [apart(part) * Math.cos(angle), apart(part) * Math.sin(angle)];
      return [
        [240 + x, 180 + y, 1],
        [240 - x, 180 - y, 2],
      ];
    };
    await send('touchStart', fingers(0)[0]);
    await send('touchStart', ...fingers(0));
    for (let i = 1; i <= 20; i++) await send('touchMove', ...fingers(i / 20));
    await send('touchEnd');
    return harness.place(page);
  };
  // Hands are not steady.
  const pinched = await twist(0, 10, (part) => 60 + 60 * part);
  near(pinched.scale, 16, 0.5);
  assert.equal(pinched.rotation, 0);
  const turned = await twist(0, 70);
  assert.ok(turned.rotation > 45 && turned.rotation < 70, `${turned.rotation}°`);
  near([turned.x, turned.y, turned.scale], [pinched.x, pinched.y, pinched.scale], 0.5);
  // Back to nearly upright, by so much that the first degrees do not count.
  const back = await twist(90, 90 - turned.rotation - 15);
  assert.equal(back.rotation, 0);
  assert.deepEqual(uncaught, []);
  await close();
});

test('keys and buttons turn and mirror, and one button says how far and undoes it', async () => {
  const { page, uncaught, close } = await open({ attributes: { controls: '', navigator: '' } });
  const lies = async () => {
    const { rotation, flipped } = await harness.place(page);
    return [rotation, flipped];
  };
  await page.locator('istar-viewer .stage').focus();
  for (const [key, expected] of [
    ['r', [90, false]],
    ['r', [180, false]],
    ['R', [90, false]],
    // As it is seen: what was on the right is on the left.
    ['f', [270, true]],
    ['f', [90, false]],
  ]) {
    await page.keyboard.press(key);
    assert.deepEqual(await lies(), expected, key);
  }
  const button = (name) => page.getByRole('button', { name });
  const upright = button(/Upright again \(\d+°\)/);
  assert.equal(await upright.getAttribute('aria-label'), 'Upright again (90°)');
  await button('Turn clockwise').click();
  assert.deepEqual(await lies(), [180, false]);
  await button('Mirror').click();
  assert.deepEqual(await lies(), [180, true]);
  await upright.focus();
  await page.keyboard.press('Enter');
  assert.deepEqual(await lies(), [0, false]);
  await upright.waitFor({ state: 'hidden' });
  // The focus is not lost with it.
  assert.equal(
    await page.evaluate(() => document.querySelector('istar-viewer').shadowRoot.activeElement?.className),
    'stage',
  );
  // The overview frames what is seen.
  const frame = page.locator('istar-viewer .frame');
  await show(page, '48,32,10,90');
  const overview = await page.locator('istar-viewer .overview').boundingBox();
  const box = await frame.boundingBox();
  // 480 × 360 pixels of the screen, lying on their side in 140 × 93.3 for 96 × 64 pixels.
  near([box.width, box.height], [(36 * 140) / 96, (48 * 140) / 96], 0.6);
  near([box.x + box.width / 2, box.y + box.height / 2], [overview.x + 71, overview.y + 47.7], 0.6);
  await show(page, '48,32,10');
  assert.equal(await frame.evaluate((frame) => frame.style.transform), '');
  assert.deepEqual(uncaught, []);
  await close();
});

test('a walk goes where it looks', async () => {
  const { page, uncaught, close } = await open({ place: '50,32,4,90' });
  await page.evaluate(() => document.querySelector('istar-viewer').names);
  await page.locator('istar-viewer .stage').focus();
  const heard = (text) => page.locator('istar-viewer .spoken').getByText(text).waitFor();
  await page.keyboard.press('Enter');
  await heard(/^Middle, borders/);
  // What is above in the picture is on the right.
  await page.keyboard.press('ArrowRight');
  await heard(/^North/);
  await page.keyboard.press('ArrowLeft');
  await heard(/^(Middle|West|blue region)/);
  await page.keyboard.press('Escape');
  await show(page, '50,32,4,0,flipped');
  await page.keyboard.press('Enter');
  await heard(/^Middle/);
  await page.keyboard.press('ArrowRight');
  await heard(/^West/);
  // The pin is where it says it is.
  const pin = await page.locator('istar-viewer .pin').boundingBox();
  const [x, y] = [pin.x + pin.width / 2, pin.y + pin.height / 2];
  const color = await page.evaluate(
    ([x, y]) =>
      document.querySelector('istar-viewer').regionName(document.querySelector('istar-viewer').pick(x, y)),
    [x, y],
  );
  assert.equal(color, 'West');
  assert.deepEqual(uncaught, []);
  await close();
});

test('files and paper have the view as it is turned', async () => {
  const { page, uncaught, close } = await open({ place: '41.3,33.7,9,30' });
  const blob = (options) =>
    page.evaluate(async (options) => {
      const blob = await document.querySelector('istar-viewer').toBlob(options);
      const bytes = new Uint8Array(await blob.arrayBuffer());
      return btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), ''));
    }, options);
  const png = async (options) => PNG.sync.read(Buffer.from(await blob(options), 'base64'));
  // Where the picture fades into nothing, a canvas keeps fewer digits of a colour.
  const rim = { share: 0.002 };
  for (const flipped of [false, true]) {
    const look = { x: 41.3, y: 33.7, rotation: 30, flipped };
    await show(page, `41.3,33.7,9,30${flipped ? ',flipped' : ''}`);
    const twice = harness.oracle(lands, { ...look, scale: 18 }, { width: 960, height: 720 });
    harness.assertAlike('turned-toblob', await png({ width: 960 }), twice, rim);
    // In pieces, whose own middles are beside the picture.
    const wide = harness.oracle(lands, { ...look, scale: 9 / 4 }, { width: 4200, height: 90 });
    harness.assertAlike('turned-toblob-wide', await png({ width: 4200, height: 90 }), wide, rim);
    const high = harness.oracle(lands, { ...look, scale: 9 * (2500 / 360) }, { width: 3333, height: 2500 });
    harness.assertAlike('turned-toblob-high', await png({ height: 2500 }), high, rim);
    const svg = Buffer.from(await blob({ type: 'image/svg+xml' }), 'base64').toString();
    const lines = await harness.drawnSvg(page, svg);
    harness.assertAlike('turned-lines', lines, harness.oracle(lands, { ...look, scale: 9 }, SIZE), {
      channel: 40,
      share: 0.005,
    });
  }
  await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
  const paper = await page.evaluate(() => {
    const canvas = document.querySelector('istar-viewer').shadowRoot.querySelector('.stage canvas + canvas');
    return canvas.toDataURL().split(',')[1];
  });
  const look = { x: 41.3, y: 33.7, rotation: 30, flipped: true, scale: (9 * 300) / 96 };
  harness.assertAlike(
    'turned-paper',
    PNG.sync.read(Buffer.from(paper, 'base64')),
    harness.oracle(lands, look, { width: 1500, height: 1125 }),
    rim,
  );
  assert.deepEqual(uncaught, []);
  await close();
});
