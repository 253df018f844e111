// The viewer in Firefox, where there is one: whether it draws, with whatever draws there, and what people do with it.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, beforeEach, test } from 'node:test';
import { PNG } from 'pngjs';
import * as harness from './harness.mjs';
import { encodedLands } from './pictures.mjs';

const VIEWPORT = { width: 480, height: 360 };
const NOT_FOUND = 'Firefox was not found: install it, or set FIREFOX to where it is';
const options = { skip: !harness.firefoxPath && NOT_FOUND };

const run = harness.session(harness.launchFirefox);
const folder = harness.temporaryFolder();
const file = encodedLands(folder);
/** What `/once` is answered, time after time. */
const faults = [404];
const files = harness.serveFiles((request, response) => {
  const status = request.url.startsWith('/once') ? (faults.shift() ?? 200) : 200;
  response.writeHead(status).end(status === 200 ? readFileSync(file) : '');
});

/** A page that has no errors at its end, not even in the console. */
async function newPage() {
  const tab = await harness.newPage(run.browser, { viewport: VIEWPORT });
  const said = [];
  // What servers answer is said there by the browser itself.
  tab.page.on('console', (message) => {
    if (message.type() === 'error' && !/404/.test(message.text())) said.push(message.text());
  });
  const close = async () => {
    assert.deepEqual([...tab.uncaught, ...said], []);
    await tab.close();
  };
  return { ...tab, close };
}

/** The first that draws here, for what is the same with all. */
let backend = 'cpu';
let page;
let close;
beforeEach(async () => {
  if (options.skip || page) return;
  ({ page, close } = await newPage());
  // Without a screen Firefox has no WebGL2.
  const hasWebgl2 = await page.evaluate(() => !!new OffscreenCanvas(1, 1).getContext('webgl2'));
  if (hasWebgl2) backend = 'webgl2';
  console.log(`Firefox ${run.browser.version()}, ${hasWebgl2 ? 'with' : 'without'} WebGL2`);
  await harness.openViewer(page, run.server.url, { src: `${files.base}lands`, backend });
});
after(() => close?.());

const near = (actual, expected, tolerance = 1e-6) =>
  assert.ok(
    Math.abs(actual - expected) <= tolerance * Math.max(1, Math.abs(expected)),
    `${actual} is not ${expected}`,
  );

/** Sets the figure's attributes, by null takes them away, and waits for the picture. */
const furnish = (attributes) =>
  page.evaluate(async (attributes) => {
    const viewer = document.querySelector('istar-viewer');
    for (const [name, value] of Object.entries(attributes)) {
      if (value === null) viewer.removeAttribute(name);
      else viewer.setAttribute(name, value);
    }
    await viewer.painted;
  }, attributes);

for (const name of ['webgl2', 'webgpu', 'cpu']) {
  test(`Firefox draws with ${name} what the oracle draws`, options, async (t) => {
    const tab = await newPage();
    await tab.page.goto(`${run.server.url}view.html?backend=${name}&src=gallery/map.istar#view=3018,684,30`);
    await tab.page.waitForFunction(() => window.seen.some(({ name }) => name === 'load' || name === 'error'));
    const failed = await tab.page.evaluate(() => window.seen.find(({ name }) => name === 'error')?.detail);
    if (failed?.kind === 'gpu') t.skip(`it has none here: ${failed.message}`);
    else {
      const place = await harness.place(tab.page);
      assert.deepEqual(place, { x: 3018, y: 684, scale: 30, rotation: 0, flipped: false });
      const map = new URL('../../dist/gallery/map.istar', import.meta.url).pathname;
      const expected = harness.oracle(map, place, VIEWPORT);
      harness.assertAlike(`firefox-${name}`, await harness.shot(tab.page), expected, { channel: 3 });
      // On the screen as well.
      const seen = PNG.sync.read(await tab.page.screenshot());
      assert.ok(harness.colors(seen) >= harness.colors(expected) / 2, `${harness.colors(seen)} colours`);
    }
    await tab.close();
  });
}

test('Firefox: drag, wheel, double click and keys move the view', options, async () => {
  await harness.zoomTo(page, 48, 32, 10);
  await page.mouse.move(200, 150);
  await page.mouse.down();
  await page.mouse.move(210, 160);
  await page.mouse.move(260, 130);
  await page.mouse.up();
  let place = await harness.place(page);
  near(place.x, 48 - 6);
  near(place.y, 32 + 2);

  const start = await harness.place(page);
  await page.mouse.move(100, 300);
  await page.mouse.wheel(0, -200);
  await page.waitForFunction((scale) => window.seen.at(-1).detail?.scale > 1.2 * scale, start.scale);
  await page.waitForTimeout(100);
  place = await harness.place(page);
  near(place.x + (100 - 240) / place.scale, start.x + (100 - 240) / start.scale);
  near(place.y + (300 - 180) / place.scale, start.y + (300 - 180) / start.scale);

  await harness.zoomTo(page, 48, 32, 10);
  await page.mouse.dblclick(240, 180);
  near((await harness.place(page)).scale, 20);
  await page.keyboard.down('Shift');
  await page.mouse.dblclick(240, 180);
  await page.keyboard.up('Shift');
  near((await harness.place(page)).scale, 10);

  for (const [key, x, y, scale] of [
    ['ArrowRight', 54.4, 32, 10],
    ['ArrowUp', 54.4, 25.6, 10],
    ['+', 54.4, 25.6, 15],
    ['-', 54.4, 25.6, 10],
    ['0', 48, 32, 5],
  ]) {
    await page.keyboard.press(key);
    place = await harness.place(page);
    for (const [name, expected] of Object.entries({ x, y, scale })) near(place[name], expected);
  }
});

const forget = () =>
  page.evaluate(() => {
    window.seen = [];
  });

test('Firefox: what the pointer is over is told, and a click reports it', options, async () => {
  await furnish({ interactive: '' });
  await forget();
  await page.mouse.move(240, 260);
  const region = await page.evaluate(() => document.querySelector('istar-viewer').pick(240, 260));
  const lake = { region, name: 'Lake' };
  assert.deepEqual(await harness.event(page, 'regionenter'), lake);
  assert.equal(await page.locator('istar-viewer .region').textContent(), 'Lake');
  await page.mouse.click(240, 260);
  assert.deepEqual(await harness.event(page, 'regionclick'), lake);
  await forget();
  await page.mouse.move(240, 5);
  assert.deepEqual(await harness.event(page, 'regionleave'), lake);
  await furnish({ interactive: null });
});

test('Firefox: a walk by keyboard tells names', options, async () => {
  await page.locator('istar-viewer .stage').focus();
  await page.keyboard.press('Enter');
  await page.waitForFunction(() =>
    /borders/.test(document.querySelector('istar-viewer').shadowRoot.textContent),
  );
  await page.keyboard.press('Escape');
});

test('Firefox: styles, and pictures of the view as PNG and as SVG', options, async () => {
  const result = await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    viewer.zoomTo(48, 32, 5);
    await viewer.painted;
    const middle = viewer.pick(240, 180);
    viewer.setStyle(middle, { color: '#123456', outline: { color: 'black', width: 2 } });
    const png = await viewer.toBlob({ width: 960 });
    const svg = await viewer.toBlob({ type: 'image/svg+xml', width: 480 });
    const image = await createImageBitmap(png);
    const context = new OffscreenCanvas(960, 720).getContext('2d');
    context.drawImage(image, 0, 0);
    const color = [...context.getImageData(480, 360, 1, 1).data];
    viewer.setStyle(middle, null);
    return { size: [image.width, image.height], color, svg: await svg.text(), types: [png.type, svg.type] };
  });
  assert.deepEqual(result.size, [960, 720]);
  assert.deepEqual(result.color, [0x12, 0x34, 0x56, 255]);
  assert.deepEqual(result.types, ['image/png', 'image/svg+xml']);
  assert.match(result.svg, /^<svg .*#123456.*<\/svg>\s*$/s);
  const whole = await harness.shot(page);
  harness.assertAlike('firefox-lands', whole, harness.oracle(file, { x: 48, y: 32, scale: 5 }, VIEWPORT), {
    channel: 3,
  });
});

test('Firefox: buttons, scale bar, overview and legend', options, async () => {
  await furnish({ controls: '', scalebar: '', unit: 'km', 'unit-per-pixel': '2', navigator: '' });
  await harness.zoomTo(page, 48, 32, 10);
  await page.getByRole('button', { name: 'Zoom in' }).click();
  near((await harness.place(page)).scale, 15);
  const bar = page.locator('istar-viewer .scalebar');
  await bar.getByText('10 km', { exact: true }).waitFor();
  assert.equal(Math.round((await bar.boundingBox()).width), 75);
  const overview = page.locator('istar-viewer .overview');
  await overview.waitFor();
  await overview.click({ position: { x: 36, y: 24 } });
  near((await harness.place(page)).x, 24, 0.05);
  await page.addScriptTag({ type: 'module', url: 'istar-legend.js' });
  await page.evaluate(() => {
    document.querySelector('istar-viewer').id = 'lands';
    const legend = document.createElement('istar-legend');
    legend.setAttribute('for', 'lands');
    document.body.append(legend);
  });
  await page.locator('istar-legend').getByText('Lake').waitFor();
  await page.evaluate(() => document.querySelector('istar-legend').remove());
  await furnish({ controls: null, scalebar: null, unit: null, 'unit-per-pixel': null, navigator: null });
});

test('Firefox: an error says what is wrong, and retry works', options, async () => {
  await page.evaluate((src) => {
    window.seen = [];
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}once`);
  const detail = await harness.event(page, 'error');
  assert.equal(detail.kind, 'http');
  assert.match(detail.message, /404/);
  await page.locator('istar-viewer [role=alert]').getByText(detail.message).waitFor();
  await page.getByRole('button', { name: 'Retry' }).click();
  await harness.event(page, 'load');
  assert.ok(harness.colors(await harness.shot(page)) > 1);
});

test('Firefox: a link leads to a view, and the address follows', options, async () => {
  await page.evaluate(() => {
    location.hash = '#view=24,40,12.5';
  });
  await page.waitForFunction(() => document.querySelector('istar-viewer').place === '24,40,12.5');
  await harness.zoomTo(page, 30, 20, 8);
  await page.waitForFunction(() => location.hash === '#view=30,20,8');
  await page.reload();
  await harness.event(page, 'load');
  assert.deepEqual(await harness.place(page), { x: 30, y: 20, scale: 8, rotation: 0, flipped: false });
});

test('Firefox: ten figures on a page are drawn', options, async () => {
  await page.evaluate(
    ([src, backend]) => {
      document.documentElement.classList.remove('full');
      window.seen = [];
      document.querySelector('istar-viewer').remove();
      for (let i = 0; i < 10; i++) {
        const viewer = document.createElement('istar-viewer');
        Object.assign(viewer.style, { width: '200px', height: '150px' });
        viewer.setAttribute('backend', backend);
        viewer.setAttribute('alt', `Lands ${i}`);
        viewer.src = `${src}?${i}`;
        document.body.append(viewer);
      }
    },
    [`${files.base}lands`, backend],
  );
  const counts = await page.evaluate(async () => {
    const found = [];
    for (const viewer of document.querySelectorAll('istar-viewer')) {
      viewer.scrollIntoView();
      await viewer.painted;
      const canvas = viewer.shadowRoot.querySelector('.stage canvas');
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      found.push(new Set(new Uint32Array(data.buffer)).size);
    }
    return found;
  });
  assert.equal(counts.length, 10);
  for (const count of counts) assert.ok(count >= 5, `${counts}`);
});
