// The museum: pictures on walls are materials, whatever draws them.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { PNG } from 'pngjs';
import { hit } from '../../web/museum/aim.js';
import { PICTURES } from '../../web/museum/hall.js';
import { Visitor } from '../../web/museum/visitor.js';
import { at } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';

const run = harness.session();
const SIZE = { width: 320, height: 240 };

/** Before the emblem's red letter, straight on: its bar is in the middle of the view. */
const LETTER = { at: [-3.5, 1.58, -3.678], turn: -Math.PI / 2, tilt: 0, pixel: [865, 2490] };

async function middle(page, mode) {
  await page.evaluate(
    ([{ at, turn, tilt }, mode]) => {
      globalThis.museum.mode(mode);
      globalThis.museum.stand(at, turn, tilt);
    },
    [LETTER, mode],
  );
  // The frame that this asked for, and the one that shows it.
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const png = PNG.sync.read(await page.screenshot());
  const from = 4 * (png.width * (png.height >> 1) + (png.width >> 1));
  return [...png.data.subarray(from, from + 3)];
}

for (const backend of harness.BACKENDS) {
  test(`a wall shows a picture's colour, and tells its region, with ${backend}`, async () => {
    const options = { viewport: SIZE, reducedMotion: 'reduce' };
    const { page, uncaught, close } = await harness.newPage(run.browser, options);
    const said = [];
    page.on('console', (message) => message.type() === 'error' && said.push(message.text()));
    await page.goto(`${run.server.url}museum.html?backend=${backend}`);
    await page.waitForSelector('html[data-ready]');
    assert.equal(
      await page.evaluate(() => document.documentElement.dataset.backend),
      { webgpu: 'WebGPU', webgl2: 'WebGL2' }[backend],
    );
    const source = PNG.sync.read(readFileSync(at('web', 'gallery', 'emblem.png')));
    const [x, y] = LETTER.pixel;
    const own = [...source.data.subarray(4 * (y * source.width + x)).subarray(0, 3)];
    // As it is, and as a texture: so much light falls on it.
    for (const mode of [0, 2]) {
      const shown = await middle(page, mode);
      const light = shown[0] / own[0];
      assert.ok(light > 0.6 && light < 1.1, `${shown} of ${own}`);
      for (const [i, channel] of shown.entries()) {
        assert.ok(Math.abs(channel - own[i] * light) < 8, `${shown} of ${own}`);
      }
    }
    const color = `#${own.map((channel) => channel.toString(16).padStart(2, '0')).join('')}`;
    // The middle by mouse, and without one.
    const asks = [
      () => page.mouse.click(SIZE.width / 2, SIZE.height / 2),
      () => page.keyboard.press('Enter'),
    ];
    for (const ask of asks) {
      await ask();
      await page.getByText(new RegExp(`^Region \\d+ of “Emblem”, ${color}$`)).waitFor();
      await page.evaluate(() => document.querySelector('#found').replaceChildren());
    }
    assert.deepEqual([uncaught, said], [[], []]);
    await close();
  });
}

/** A page whose device can be lost, by `lose()`. */
function losable() {
  const getContext = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
    const context = getContext.call(this, kind, ...rest);
    if (kind === 'webgl2') window.lose = () => context.getExtension('WEBGL_lose_context').loseContext();
    return context;
  };
  const requestDevice = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = async function (...rest) {
    const device = await requestDevice.apply(this, rest);
    // One that is destroyed is not lost by accident, and no script can do that.
    const lost = new Promise((resolve) => {
      window.lose = () => {
        device.destroy();
        resolve({ reason: 'unknown' });
      };
    });
    Object.defineProperty(device, 'lost', { value: lost });
    return device;
  };
}

for (const backend of harness.BACKENDS) {
  test(`a lost ${backend} device is replaced, and where that fails the page says so`, async () => {
    const options = { viewport: SIZE, reducedMotion: 'reduce' };
    const { page, uncaught, close } = await harness.newPage(run.browser, options);
    await page.addInitScript(losable);
    await page.goto(`${run.server.url}museum.html?backend=${backend}`);
    await page.waitForSelector('html[data-ready]');
    const before = await middle(page, 0);
    const canvas = await page.$('canvas');
    await page.evaluate(() => window.lose());
    await page.waitForFunction((old) => {
      const now = document.querySelector('html[data-ready] canvas');
      return now && now !== old;
    }, canvas);
    assert.deepEqual(await middle(page, 0), before);
    await page.evaluate(() => {
      HTMLCanvasElement.prototype.getContext = () => null;
      GPUAdapter.prototype.requestDevice = () => Promise.reject(new Error('denied'));
      window.lose();
    });
    await page.getByText('The hall can no longer be drawn').waitFor();
    assert.deepEqual(uncaught, []);
    await close();
  });
}

for (const [broken, said] of [
  ['gallery/map.istar', /map\.istar could not be fetched \(404\)/],
  ['museum/loader.js', /loader\.js could not be run/],
  ['museum/baker.js', /The hall cannot be drawn: baker\.js/],
]) {
  test(`without ${broken} the page says what is wrong`, async () => {
    const { page, uncaught, close } = await harness.newPage(run.browser, { viewport: SIZE });
    await page.route(`**/${broken}`, (route) => route.fulfill({ status: 404 }));
    await page.goto(`${run.server.url}museum.html?backend=webgl2`);
    await page.locator('#status').getByText(said).waitFor();
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('a picture behind a wall is not hit, and one behind a door is', () => {
  const europe = { at: [2.5, 1.62, -4.6], turn: Math.PI / 2, tilt: 0 };
  assert.equal(hit(europe, [0, 0], 1, 1).picture.title, 'Europe');
  // From the first room to the second's right wall: beside the door, and through it.
  const toCanada = (x, z) => ({ at: [x, 1.62, z], turn: Math.atan2(5 - x, z + 14), tilt: 0 });
  assert.equal(hit(toCanada(4, -5), [0, 0], 1, 1), undefined);
  assert.equal(hit(toCanada(-2, -7), [0, 0], 1, 1).picture.title, 'Canada and Greenland');
});

test('a visitor keeps the picture that it goes to in mind, until it goes elsewhere', () => {
  const visitor = new Visitor();
  for (const away of [() => visitor.look(0.1, 0), () => visitor.key('KeyW', true), () => visitor.tour()]) {
    visitor.visit(PICTURES.length - 1, false);
    assert.equal(visitor.goal, PICTURES.length - 1);
    away();
    assert.equal(visitor.goal, undefined);
  }
});

test('it can be walked by keys, and stands still where motion is not wanted', async () => {
  const options = { viewport: SIZE, reducedMotion: 'reduce' };
  const { page, uncaught, close } = await harness.newPage(run.browser, options);
  // As on a slow machine, where what moves has fewer pixels.
  await page.addInitScript(() => {
    const own = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (draw) => own((now) => draw(10 * now));
  });
  await page.goto(`${run.server.url}museum.html?backend=webgl2`);
  await page.waitForSelector('html[data-ready]');
  assert.equal(await page.getByRole('button', { name: 'Tour' }).getAttribute('aria-pressed'), 'false');
  const before = await page.evaluate(() => globalThis.museum.place());
  await page.keyboard.down('w');
  await page.waitForFunction((z) => globalThis.museum.place()[2] < z - 0.2, before[2]);
  await page.waitForFunction((width) => document.querySelector('canvas').width < width, SIZE.width);
  await page.keyboard.up('w');
  await page.waitForFunction((width) => document.querySelector('canvas').width === width, SIZE.width);
  await page.keyboard.press('n');
  await page.locator('#title').getByText(/./).waitFor();
  assert.deepEqual(uncaught, []);
  await close();
});
