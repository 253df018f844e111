// The museum: pictures on walls are materials, whatever draws them.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { PNG } from 'pngjs';
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
    await page.mouse.click(SIZE.width / 2, SIZE.height / 2);
    const color = `#${own.map((channel) => channel.toString(16).padStart(2, '0')).join('')}`;
    await page.getByText(new RegExp(`^Region \\d+ of “Emblem”, ${color}$`)).waitFor();
    assert.deepEqual([uncaught, said], [[], []]);
    await close();
  });
}

test('it can be walked by keys, and stands still where motion is not wanted', async () => {
  const options = { viewport: SIZE, reducedMotion: 'reduce' };
  const { page, uncaught, close } = await harness.newPage(run.browser, options);
  await page.goto(`${run.server.url}museum.html?backend=webgl2`);
  await page.waitForSelector('html[data-ready]');
  assert.equal(await page.getByRole('button', { name: 'Tour' }).getAttribute('aria-pressed'), 'false');
  const before = await page.evaluate(() => globalThis.museum.place());
  await page.keyboard.down('w');
  await page.waitForFunction((z) => globalThis.museum.place()[2] < z - 0.2, before[2]);
  await page.keyboard.up('w');
  await page.keyboard.press('n');
  await page.locator('#title').getByText(/./).waitFor();
  assert.deepEqual(uncaught, []);
  await close();
});
