// What stands beside the picture: buttons, scale bar, overview; and the view in a box, in a file, on paper, in another language.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, beforeEach, test } from 'node:test';
import { PNG } from 'pngjs';
import * as harness from './harness.mjs';
import { encodedLands } from './pictures.mjs';

const VIEWPORT = { width: 480, height: 360 };

const run = harness.session();
const folder = harness.temporaryFolder();
const file = encodedLands(folder);
const files = harness.serveFolder(folder);

let page;
let uncaught;
let close;
const asked = [];
beforeEach(async () => {
  if (page) return;
  // One for all: each test says what it needs beside the picture.
  ({ page, uncaught, close } = await harness.newPage(run.browser, {
    viewport: VIEWPORT,
    reducedMotion: 'reduce',
  }));
  page.on('request', (request) => asked.push(request.url().split('/').at(-1)));
  const src = encodeURIComponent(`${files.base}lands.istar`);
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${src}`);
  await harness.event(page, 'load');
});
after(async () => {
  assert.deepEqual(uncaught, []);
  await close();
});

/** Gives the figure these attributes beside those that it needs, and shows all of the picture. */
const furnish = (attributes) =>
  page.evaluate(async (attributes) => {
    const viewer = document.querySelector('istar-viewer');
    for (const name of ['controls', 'navigator', 'scalebar', 'unit', 'unit-per-pixel', 'dir', 'lang'])
      viewer.removeAttribute(name);
    for (const [name, value] of Object.entries(attributes)) viewer.setAttribute(name, value);
    viewer.fit();
    await viewer.painted;
  }, attributes);
const part = (name) => page.locator(`istar-viewer .${name}`);
const button = (name) => page.getByRole('button', { name });

test('what nobody asks for is not fetched, and what is no longer asked for goes', async () => {
  assert.ok(!asked.includes('istar-controls.js') && !asked.includes('istar-export.js'));
  await furnish({ controls: '' });
  await part('controls').waitFor();
  assert.ok((await part('scalebar').isHidden()) && (await part('overview').isHidden()));
  assert.equal(asked.filter((name) => name === 'istar-controls.js').length, 1);
  await furnish({});
  await part('controls').waitFor({ state: 'hidden' });
});

test('buttons zoom, show all and fill the screen', async () => {
  await furnish({ controls: '' });
  const { scale } = await harness.place(page);
  for (const [name, times] of [
    ['Zoom in', 1.5],
    ['Zoom in', 2.25],
    ['Zoom out', 1.5],
    ['Show all', 1],
  ]) {
    await button(name).click();
    const now = (await harness.place(page)).scale / scale;
    assert.ok(Math.abs(now - times) < 1e-9, `${name}: ${now}`);
  }
  await button('Full screen').click();
  await button('Leave full screen').click();
  await button('Full screen').waitFor();
  const download = page.waitForEvent('download');
  await button('Save as picture').click();
  const saved = await download;
  assert.equal(saved.suggestedFilename(), 'lands.png');
  assert.equal(PNG.sync.read(readFileSync(await saved.path())).width, 480);
});

test('the scale bar is as long as it says', async () => {
  const bar = part('scalebar');
  const says = async (attributes, text, width) => {
    await furnish({ scalebar: '', ...attributes });
    await harness.zoomTo(page, 48, 32, 2);
    await bar.getByText(text, { exact: true }).waitFor();
    assert.equal(Math.round((await bar.boundingBox()).width), width, text);
  };
  await says({}, '50 px', 100);
  await says({ unit: 'km', 'unit-per-pixel': '0.25' }, '10 km', 80);
  await says({ unit: 'light years', 'unit-per-pixel': '1e9' }, '5E10 light years', 100);
  for (const nonsense of ['', '0', '-3', 'NaN', 'Infinity', 'four']) {
    await says({ unit: 'km', 'unit-per-pixel': nonsense, lang: 'no_such!' }, '50 km', 100);
  }
  assert.match(await bar.getAttribute('aria-label'), /50 km/);
});

test('the overview frames what is seen, moves the view, and is drawn again only where regions change', async () => {
  await furnish({ navigator: '' });
  await part('overview').waitFor();
  const overview = await part('overview').boundingBox();
  const frame = async () => {
    const { x, y, width, height } = await part('frame').boundingBox();
    return [x - overview.x - 1, y - overview.y - 1, width, height].map(Math.floor);
  };
  // 480 × 360 pixels of the screen are half of the picture's width and 9/16 of its height; the overview has 140 × 93.3.
  await harness.zoomTo(page, 48, 32, 10);
  assert.deepEqual(await frame(), [35, 20, 70, 52]);
  await page.mouse.move(overview.x + 1 + 35, overview.y + 1 + 70);
  await page.mouse.down();
  const pressed = await harness.place(page);
  assert.deepEqual([Math.round(pressed.x), Math.round(pressed.y), pressed.scale], [24, 48, 10]);
  await page.mouse.move(overview.x + 1 + 105, overview.y + 1 + 70);
  await page.mouse.up();
  assert.equal(Math.round((await harness.place(page)).x), 72);
  for (let i = 0; i < 3; i++) {
    await furnish({});
    await furnish({ navigator: '' });
  }
  assert.equal(await part('overview').locator('canvas').count(), 1);
  await harness.zoomTo(page, 72, 48, 10);

  const drawn = await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    const small = viewer.shadowRoot.querySelector('.overview canvas');
    const colorAt = (x, y) => [
      ...small.getContext('2d').getImageData(x * small.width, y * small.height, 1, 1).data,
    ];
    const before = colorAt(0.1, 0.6);
    let count = 0;
    const { drawImage } = CanvasRenderingContext2D.prototype;
    CanvasRenderingContext2D.prototype.drawImage = function (...rest) {
      if (this.canvas === small) count++;
      return drawImage.apply(this, rest);
    };
    for (let i = 0; i < 5; i++) {
      viewer.zoomTo(40 + i, 32, 10);
      await viewer.painted;
    }
    const moved = count;
    viewer.styles = { colors: { '#c83232': { color: '#123456' } } };
    await viewer.painted;
    // It follows when the view rests.
    for (let i = 0; i < 50 && count === 0; i++) await new Promise((done) => setTimeout(done, 100));
    const after = colorAt(0.1, 0.6);
    // What the pointer lights up is told by the view.
    viewer.setAttribute('interactive', '');
    const stage = viewer.shadowRoot.querySelector('.stage');
    for (const clientX of [150, 350]) {
      stage.dispatchEvent(new PointerEvent('pointermove', { clientX, clientY: 180 }));
      await viewer.painted;
      await new Promise((done) => setTimeout(done, 300));
    }
    stage.dispatchEvent(new PointerEvent('pointerleave'));
    await viewer.painted;
    viewer.removeAttribute('interactive');
    viewer.styles = {};
    CanvasRenderingContext2D.prototype.drawImage = drawImage;
    return { before, moved, count, after };
  });
  assert.deepEqual(drawn, {
    before: [0xc8, 0x32, 0x32, 255],
    moved: 0,
    count: 1,
    after: [0x12, 0x34, 0x56, 255],
  });
});

test('a drag with shift shows what is in its box', async () => {
  await furnish({});
  await harness.zoomTo(page, 48, 32, 4);
  await page.keyboard.down('Shift');
  await page.mouse.move(300, 240);
  await page.mouse.down();
  await page.mouse.move(260, 200);
  await page.mouse.move(180, 150);
  assert.deepEqual(await part('box').boundingBox(), { x: 180, y: 150, width: 120, height: 90 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  assert.ok(await part('box').isHidden());
  const { x, y, scale } = await harness.place(page);
  assert.deepEqual([x, y, scale], [48, 32 + 15 / 4, 16]);
});

/** The picture that `toBlob` makes. */
async function blob(options) {
  const { type, base64 } = await page.evaluate(async (options) => {
    const blob = await document.querySelector('istar-viewer').toBlob(options);
    const bytes = new Uint8Array(await blob.arrayBuffer());
    return {
      type: blob.type,
      base64: btoa(bytes.reduce((text, byte) => text + String.fromCharCode(byte), '')),
    };
  }, options);
  return { type, bytes: Buffer.from(base64, 'base64') };
}

test('a picture of the view is of any size, sharp and whole', async () => {
  await furnish({});
  await harness.zoomTo(page, 41.3, 33.7, 9);
  const look = { x: 41.3, y: 33.7 };
  const twice = PNG.sync.read((await blob({ width: 960 })).bytes);
  harness.assertAlike(
    'toblob-twice',
    twice,
    harness.oracle(file, { ...look, scale: 18 }, { width: 960, height: 720 }),
  );
  // Drawn in pieces, and of another shape.
  const wide = PNG.sync.read((await blob({ width: 2100, height: 90 })).bytes);
  harness.assertAlike(
    'toblob-wide',
    wide,
    harness.oracle(file, { ...look, scale: 9 / 4 }, { width: 2100, height: 90 }),
  );
  assert.equal((await blob({ type: 'image/webp', quality: 0.5 })).type, 'image/webp');
  for (const wrong of [
    { width: 20_000 },
    { height: -5 },
    { width: 16_384, height: 0.2 },
    { width: 'wide' },
  ]) {
    await assert.rejects(blob(wrong), /cannot be made: each side has 1 to 16384/);
  }
  // The view is as it was.
  assert.deepEqual(await harness.place(page), { ...look, scale: 9, rotation: 0, flipped: false });
});

test('what knows no transparency is white beside the picture', async () => {
  await furnish({});
  for (const size of [{}, { height: 180 }]) {
    const { type, bytes } = await blob({ ...size, type: 'image/jpeg' });
    assert.equal(type, 'image/jpeg');
    const corner = await page.evaluate(async (base64) => {
      const picture = await createImageBitmap(await (await fetch(`data:image/jpeg;base64,${base64}`)).blob());
      const context = new OffscreenCanvas(1, 1).getContext('2d');
      context.drawImage(picture, 0, 0);
      return [...context.getImageData(0, 0, 1, 1).data];
    }, bytes.toString('base64'));
    assert.ok(Math.min(...corner) > 250, `${corner}`);
  }
});

test('paper gets more pixels than the screen', async () => {
  await furnish({ controls: '', scalebar: '' });
  await harness.zoomTo(page, 48, 32, 9);
  const canvases = () =>
    page.evaluate(() =>
      [...document.querySelector('istar-viewer').shadowRoot.querySelectorAll('.stage canvas')].map(
        ({ width, height }) => [width, height],
      ),
    );
  const pdf = (await page.pdf({ width: '480px', height: '360px' })).toString('latin1');
  assert.match(pdf, /\/Width 1500\b/);
  assert.deepEqual(await canvases(), [[480, 360]]);
  await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
  assert.deepEqual(await canvases(), [
    [480, 360],
    [1500, 1125],
  ]);
  await page.evaluate(() => dispatchEvent(new Event('afterprint')));
  assert.deepEqual(await canvases(), [[480, 360]]);
});

test('pages set parts, sides and words as they like', async () => {
  await furnish({ controls: '', scalebar: '', dir: 'rtl' });
  await part('controls').waitFor();
  assert.ok((await part('controls').boundingBox()).x < 100);
  assert.ok((await part('status').boundingBox()).x < 100);
  assert.ok((await part('scalebar').boundingBox()).x > 300);
  const color = await page.evaluate(() => {
    const sheet = new CSSStyleSheet();
    sheet.replaceSync('istar-viewer::part(scalebar) { color: rgb(1, 2, 3) }');
    document.adoptedStyleSheets.push(sheet);
    return getComputedStyle(document.querySelector('istar-viewer').shadowRoot.querySelector('.scalebar'))
      .color;
  });
  assert.equal(color, 'rgb(1, 2, 3)');
  await page.evaluate((src) => {
    customElements.get('istar-viewer').words = {
      'Zoom in': 'Vergrößern',
      px: 'Pixel',
      Retry: 'Nochmals',
      'The picture could not be loaded.': 'Das Bild fehlt.',
      'Show all': 7,
    };
    const viewer = document.createElement('istar-viewer');
    viewer.setAttribute('controls', '');
    viewer.setAttribute('backend', 'webgl2');
    viewer.src = src;
    document.querySelector('istar-viewer').replaceWith(viewer);
  }, `${files.base}lands.istar`);
  await button('Vergrößern').waitFor();
  await button('7').waitFor();
  await button('Zoom out').waitFor();
  await page.evaluate(() => {
    document.querySelector('istar-viewer').src = 'missing.istar';
  });
  await part('title').getByText('Das Bild fehlt.').waitFor();
  await button('Nochmals').waitFor();
  await part('controls').waitFor({ state: 'hidden' });
});
