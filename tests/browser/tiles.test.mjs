// Files in tiles and levels: what is fetched for a view, and what is shown until it is there.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import * as harness from './harness.mjs';
import { encodedLargeQuilt, encodedQuilt, huge } from './pictures.mjs';

const VIEWPORT = { width: 240, height: 180 };

const run = harness.session();
const folder = harness.temporaryFolder();
const quilted = readFileSync(
  encodedQuilt(folder, 'quilt', [1024, 768], '--tile-size', '128', '--texel-size', '4'),
);
/** The picture of 1024 × 768 in tiles of 128 and three levels; and the huge one. */
const pictures = {
  quilt: { length: quilted.length, slice: (from, to) => quilted.subarray(from, to) },
  huge: huge(readFileSync(encodedLargeQuilt(folder, 'small', [1024, 1024], '--texel-size', '8'))),
};
/** Requests by name, as [from, to] of bytes; null for a whole file. */
let asked;
/** Answers in place of the usual one, by name. */
let answers;

const files = harness.serveFiles((request, response) => {
  const [name, kind] = request.url.slice(1).split('.');
  response.setHeader('access-control-expose-headers', 'etag, content-range, content-encoding');
  response.setHeader('cache-control', 'no-store');
  const picture = pictures[name];
  const range = /bytes=(\d+)-(\d+)/.exec(request.headers.range ?? '');
  const [from, to] = range
    ? [Number(range[1]), Math.min(Number(range[2]) + 1, picture.length)]
    : [0, picture.length];
  asked.push(range ? [from, to] : null);
  const usual = () => {
    if (range && from >= picture.length) return response.writeHead(416).end();
    if (range) response.writeHead(206, { 'content-range': `bytes ${from}-${to - 1}/${picture.length}` });
    response.end(picture.slice(from, to));
  };
  (answers[kind] ?? usual)({ request, response, from, to, picture, usual });
});

async function open(name, { backend = 'webgl2', answer = {}, viewport = VIEWPORT, place = '' } = {}) {
  asked = [];
  answers = answer;
  const tab = await harness.newPage(run.browser, { viewport });
  const url = `${run.server.url}view.html?backend=${backend}&src=${encodeURIComponent(files.base + name)}#view=${place}`;
  await tab.page.goto(url);
  return tab;
}

/** Waits until all of the view is there. */
async function settled(page) {
  await harness.event(page, 'load');
  await page.evaluate(() => document.querySelector('istar-viewer').painted);
}

function bytesAsked() {
  return asked.reduce((sum, [from, to]) => sum + to - from, 0);
}

async function looksRight(page, name) {
  const place = await harness.place(page);
  const actual = await harness.shot(page);
  const expected = harness.oracle(join(folder, 'quilt.istar'), place, VIEWPORT);
  harness.assertAlike(name, actual, expected);
}

for (const backend of harness.BACKENDS) {
  test(`tiles and levels with ${backend} look like the oracle`, async () => {
    const { page, uncaught, close } = await open('quilt.istar', { backend });
    await settled(page);
    await looksRight(page, `tiles-whole-${backend}`);
    // Where four tiles meet, from close by and from further off, and at a level between.
    for (const [x, y, scale] of [
      [256, 256, 1.5],
      [512.25, 384.5, 40],
      [550, 350, 0.4],
    ]) {
      await harness.zoomTo(page, x, y, scale);
      await looksRight(page, `tiles-${scale}-${backend}`);
    }
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('what a turned view passes by is not fetched', async () => {
  const viewport = { width: 540, height: 540 };
  const { page, uncaught, close } = await open('quilt.istar', { viewport, place: '512,384,1,45' });
  await settled(page);
  const before = asked.length;
  // No more than the upright square around it.
  await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    viewer.place = '512,384,0.71';
    await viewer.painted;
  });
  assert.ok(asked.length > before, `all of its ${before} requests were for the view that was turned`);
  assert.deepEqual(uncaught, []);
  await close();
});

test('a picture of 65,536 by 65,536 pixels is sharp after three requests and 200 KB', async () => {
  const { page, uncaught, close } = await open('huge.istar', { viewport: { width: 1024, height: 768 } });
  await settled(page);
  const [requests, bytes] = [asked.length, bytesAsked()];
  assert.ok(requests <= 3, `${requests} requests`);
  assert.ok(bytes <= 200_000, `${bytes} bytes`);
  console.log(`all of it: ${requests} requests, ${bytes} bytes of ${pictures.huge.length}`);

  // A place at the finest level: a part of the directory, and its tiles.
  asked = [];
  await harness.zoomTo(page, 30_000.5, 40_000.5, 1);
  console.log(`a place: ${asked.length} requests, ${bytesAsked()} bytes`);
  assert.ok(asked.length <= 3 && bytesAsked() <= 200_000, `${asked.length} requests, ${bytesAsked()} bytes`);
  assert.ok(harness.colors(await harness.shot(page)) > 1);
  assert.deepEqual(uncaught, []);
  await close();
});

test('a view fetches the tiles that it shows, each once, and what was seen is there', async () => {
  const { page, close } = await open('quilt.istar');
  await settled(page);
  const tile = 128;
  // Tiles that a view shows: by its place and its size, at the finest level.
  const columns = (at, scale, extent, most) => {
    const reach = extent / scale / 2;
    const from = Math.max(0, Math.floor((at - reach) / tile));
    return Math.min(most - 1, Math.ceil((at + reach) / tile) - 1) - from + 1;
  };
  for (const [x, y, scale] of [
    [150.5, 150.5, 1],
    [450.5, 450.5, 2],
    [750.5, 300.5, 9],
  ]) {
    asked = [];
    await harness.zoomTo(page, x, y, scale);
    const tiles = columns(x, scale, VIEWPORT.width, 8) * columns(y, scale, VIEWPORT.height, 6);
    const most = 1.5 * tiles * Math.max(...asked.map(([from, to]) => to - from));
    assert.ok(asked.length >= 1 && asked.length <= tiles, `${asked.length} requests for ${tiles} tiles`);
    assert.ok(bytesAsked() <= most, `${bytesAsked()} bytes for ${tiles} tiles`);
  }
  asked = [];
  await harness.zoomTo(page, 150.5, 150.5, 1);
  assert.deepEqual(asked, []);
  await close();
});

test('what is coarse is shown until what is fine is there, and there never is a hole', async () => {
  const held = [];
  let isHeld = false;
  const later = ({ usual }) => (isHeld ? held.push(usual) : usual());
  const { page, uncaught, close } = await open('quilt.later', { answer: { later } });
  await settled(page);
  isHeld = true;
  const pixels = () =>
    page.evaluate(async () => {
      await new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)));
      const drawn = document.querySelector('istar-viewer').shadowRoot.querySelector('canvas');
      const { data } = drawn.getContext('2d').getImageData(0, 0, drawn.width, drawn.height);
      const colors = new Set(new Uint32Array(data.buffer));
      return { holes: data.filter((byte, i) => i % 4 === 3 && byte < 255).length, colors: colors.size };
    });
  await page.evaluate(() => document.querySelector('istar-viewer').zoomTo(500, 350, 3));
  await page.waitForTimeout(200);
  const before = await pixels();
  assert.equal(before.holes, 0);
  assert.ok(before.colors > 1);
  assert.ok(held.length > 0, 'the finest tiles are on their way');
  isHeld = false;
  for (const answer of held.splice(0)) answer();
  await page.evaluate(() => document.querySelector('istar-viewer').painted);
  await looksRight(page, 'tiles-refined');
  assert.deepEqual(uncaught, []);
  await close();
});

test('what a moved view no longer needs is not waited for', async () => {
  const ended = [];
  let isHeld = false;
  const held = ({ request, response, usual }) => {
    if (isHeld) response.on('close', () => ended.push(request.headers.range));
    else usual();
  };
  const { page, close } = await open('quilt.held', { answer: { held } });
  await settled(page);
  isHeld = true;
  asked = [];
  await page.evaluate(() => document.querySelector('istar-viewer').zoomTo(500, 350, 3));
  while (asked.length === 0) await page.waitForTimeout(50);
  isHeld = false;
  assert.deepEqual(ended, []);
  await harness.zoomTo(page, 950, 700, 3);
  for (let wait = 0; ended.length === 0 && wait < 40; wait++) await page.waitForTimeout(50);
  assert.ok(ended.length > 0);
  await close();
});

const servers = {
  'that knows no ranges': ({ picture, response }) => response.end(picture.slice(0, picture.length)),
  'that packs what it sends': ({ picture, response }) => {
    response.writeHead(200, { 'content-encoding': 'gzip' });
    response.end(gzipSync(picture.slice(0, picture.length)));
  },
  'that packs ranges': ({ request, picture, response, from, to }) => {
    const packed = gzipSync(picture.slice(0, picture.length));
    if (!request.headers.range) return response.writeHead(200, { 'content-encoding': 'gzip' }).end(packed);
    const end = Math.min(to, packed.length);
    response.writeHead(206, {
      'content-encoding': 'gzip',
      'content-range': `bytes ${from}-${end - 1}/${packed.length}`,
    });
    response.end(packed.subarray(from, end));
  },
  'that fails now and then': (() => {
    let count = 0;
    return ({ response, usual }) => {
      if (count++ % 2 === 0) response.writeHead(503).end();
      else usual();
    };
  })(),
  'that cuts connections': (() => {
    let count = 0;
    return ({ response, from, to, picture, usual }) => {
      if (count++ % 2 === 1) return usual();
      response.writeHead(206, {
        'content-length': to - from,
        'content-range': `bytes ${from}-${to - 1}/${picture.length}`,
      });
      response.write(picture.slice(from, from + (to - from) / 2), () => response.destroy());
    };
  })(),
};
for (const [name, answer] of Object.entries(servers)) {
  test(`a server ${name} will do`, async () => {
    const { page, uncaught, close } = await open('quilt.odd', { answer: { odd: answer } });
    await settled(page);
    await harness.zoomTo(page, 350.5, 250.5, 2);
    await looksRight(page, `tiles-odd-${name.replaceAll(' ', '-')}`);
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('a file that changes midway is read anew, once', async () => {
  let version = 0;
  const changing = ({ response, usual }) => {
    response.setHeader('etag', `"${version}"`);
    usual();
  };
  const { page, close } = await open('quilt.changing', { answer: { changing } });
  await settled(page);
  version++;
  const loads = () => page.evaluate(() => window.seen.filter(({ name }) => name === 'load').length);
  await page.evaluate(() => document.querySelector('istar-viewer').zoomTo(350, 250, 3));
  await page.waitForFunction(() => window.seen.filter(({ name }) => name === 'load').length === 2);
  assert.equal(await loads(), 2);
  version++;
  await page.evaluate(() => document.querySelector('istar-viewer').zoomTo(850, 600, 3));
  assert.equal((await harness.event(page, 'error')).kind, 'changed');
  await close();
});

test('a damaged tile is replaced by what is coarser, and the others are sharp', async () => {
  // The last tile of the finest level.
  const damaged = ({ response, from, to, picture }) => {
    const bytes = Buffer.from(picture.slice(from, to));
    const at = picture.length - 20;
    if (at >= from && at < to) bytes[at - from] ^= 1;
    response.writeHead(206, { 'content-range': `bytes ${from}-${to - 1}/${picture.length}` });
    response.end(bytes);
  };
  const { page, uncaught, close } = await open('quilt.damaged', { answer: { damaged } });
  await settled(page);
  await harness.zoomTo(page, 960.5, 700.5, 4);
  assert.ok(harness.colors(await harness.shot(page)) > 1);
  await harness.zoomTo(page, 350.5, 250.5, 2);
  await looksRight(page, 'tiles-beside-damaged');
  assert.deepEqual(uncaught, []);
  await close();
});
