// What people see while a picture loads and when it cannot be shown.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, test } from 'node:test';
import { at } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';
import { encodedLands, encodedQuilt } from './pictures.mjs';

const run = harness.session();
const folder = harness.temporaryFolder();
const picture = readFileSync(encodedLands(folder));
const map = readFileSync(at('dist', 'gallery', 'map.istar'));
const quilt = readFileSync(
  encodedQuilt(folder, 'quilt', [1024, 768], '--tile-size', '128', '--texel-size', '4'),
);
/** What slow servers have still to send. */
const held = [];
const release = () => {
  for (const send of held.splice(0)) send();
};

/** Serves pictures badly. Names that end in -once go well once they are among `mended`. */
const FAULTS = {
  none: (response) => response.end(picture),
  whole: (response) => response.writeHead(200, { 'content-length': map.length }).end(map),
  quilt: (response, _, range) => {
    const [from, to] = /(\d+)-(\d+)/.exec(range).slice(1).map(Number);
    const part = quilt.subarray(from, to + 1);
    response.writeHead(206, {
      'content-range': `bytes ${from}-${from + part.length - 1}/${quilt.length}`,
      'cache-control': 'no-store',
    });
    response.end(part);
  },
  missing: (response) => response.writeHead(404).end(),
  forbidden: (response) => response.writeHead(403).end(),
  // These are tried again before it is said.
  unavailable: (response) => response.writeHead(503).end(),
  'out-of-order': (response) => response.writeHead(500).end(),
  late: (response) => response.writeHead(504).end(),
  // A server that lets no other origin's pages read it.
  closed: (response, bytes) => {
    response.removeHeader('access-control-allow-origin');
    response.end(bytes);
  },
  // What is there in place of files that are not: a page.
  page: (response) => response.writeHead(200, { 'content-type': 'text/html' }).end('<!doctype html><p>Hello'),
  broken: (response, bytes) => {
    response.writeHead(200, { 'content-length': bytes.length });
    response.write(bytes.subarray(0, bytes.length / 2), () => setTimeout(() => response.destroy(), 50));
  },
  refused: (response) => response.destroy(),
  silent: () => {},
  stalled: (response, bytes) => {
    response.writeHead(200, { 'content-length': bytes.length });
    response.write(bytes.subarray(0, bytes.length / 2));
  },
  truncated: (response, bytes) => response.end(bytes.subarray(0, bytes.length / 2)),
  'wrong-magic': (response, bytes) => response.end(Buffer.concat([Buffer.from('GIF89a'), bytes.subarray(6)])),
  empty: (response) => response.end(),
  slow: (response, bytes) => {
    response.writeHead(200, { 'content-length': bytes.length });
    response.write(bytes.subarray(0, bytes.length / 4));
    held.push(() => response.end(bytes.subarray(bytes.length / 4)));
  },
  'slow-chunked': (response, bytes) => {
    response.write(bytes.subarray(0, bytes.length / 4));
    held.push(() => response.end(bytes.subarray(bytes.length / 4)));
  },
};

const mended = new Set();
const files = harness.serveFiles((request, response) => {
  const name = request.url.slice(1);
  if (name === 'members') {
    response.setHeader('access-control-allow-origin', request.headers.origin);
    response.setHeader('access-control-allow-credentials', 'true');
    if (request.headers.cookie === 'member=yes') response.end(picture);
    else response.writeHead(403).end();
  } else if (mended.has(name)) response.end(picture);
  else FAULTS[name.replace(/-once$/, '')](response, picture, request.headers.range);
});

const alertOf = (page) => page.locator('istar-viewer [role=alert]');

async function open(src, options) {
  const opened = await harness.newPage(run.browser, options);
  await opened.page.goto(`${run.server.url}view.html?backend=webgl2&src=${encodeURIComponent(src)}`);
  return opened;
}

/** A page whose figure has failed to load what is not there, and remembers no event of that. */
async function openWithout(options) {
  const opened = await open('none.istar', options);
  await harness.event(opened.page, 'error');
  await opened.page.evaluate(() => {
    window.seen = [];
  });
  return opened;
}

const failures = [
  ['missing', 'http', /404/],
  ['forbidden', 'http', /403/],
  ['unavailable', 'http', /503/],
  ['out-of-order', 'http', /500/],
  ['late', 'http', /504/],
  ['closed', 'network', /could not be reached .*Access-Control-Allow-Origin/],
  ['page', 'malformed', /./],
  ['broken', 'network', /broke after .* of /],
  ['refused', 'network', /could not be reached/],
  ['silent', 'network', /sent nothing for 30 seconds/],
  ['stalled', 'network', /sent nothing for 30 seconds/],
  ['truncated', 'malformed', /./],
  ['wrong-magic', 'malformed', /./],
  ['empty', 'malformed', /./],
];
let failing;
after(() => failing?.close());
for (const [name, kind, text] of failures) {
  test(`${name}: says so, and retry works`, async () => {
    // One page for all: each takes another picture.
    failing ??= await openWithout();
    const { page, uncaught } = failing;
    await page.evaluate((src) => {
      // Nobody waits half a minute.
      const wait = window.setTimeout;
      window.setTimeout = (step, ms) => wait(step, ms === 30_000 ? 1500 : ms);
      window.seen = [];
      document.querySelector('istar-viewer').src = src;
    }, `${files.base}${name}-once`);
    const detail = await harness.event(page, 'error');
    assert.equal(detail.kind, kind);
    assert.match(detail.message, text);
    await alertOf(page).getByText(detail.message).waitFor();
    // Who asks only now is told too.
    const asked = await page.evaluate(() => {
      const viewer = document.querySelector('istar-viewer');
      return Promise.allSettled([viewer.painted, viewer.toBlob(), viewer.toBlob({ width: 9 })]);
    });
    for (const { status, reason } of asked) {
      assert.equal(status, 'rejected');
      assert.equal(reason.message, detail.message);
    }

    mended.add(`${name}-once`);
    await page.getByRole('button', { name: 'Retry' }).click();
    await harness.event(page, 'load');
    await alertOf(page).getByRole('button').waitFor({ state: 'detached' });
    assert.ok(harness.colors(await harness.shot(page)) > 1);
    assert.deepEqual(uncaught, []);
  });
}

test('a server that wants to know who asks is told where the page says so', async () => {
  const { page, uncaught, close } = await openWithout();
  await page.context().addCookies([{ name: 'member', value: 'yes', url: files.base }]);
  const show = async (src) => {
    await page.evaluate((src) => {
      document.querySelector('istar-viewer').src = src;
    }, src);
  };
  await show(`${files.base}members`);
  assert.match((await harness.event(page, 'error')).message, /403/);
  await page.evaluate(() =>
    document.querySelector('istar-viewer').setAttribute('crossorigin', 'use-credentials'),
  );
  await page.getByRole('button', { name: 'Retry' }).click();
  await harness.event(page, 'load');
  // Nobody is told who does not allow it.
  await page.evaluate(() => {
    window.seen = [];
  });
  await show(`${files.base}none`);
  assert.match((await harness.event(page, 'error')).message, /Access-Control/);
  assert.deepEqual(uncaught, []);
  await close();
});

test('without a network it says so, and retry works once there is one', async () => {
  const { page, uncaught, close } = await openWithout();
  await page.context().setOffline(true);
  await page.evaluate((src) => {
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}none`);
  const detail = await harness.event(page, 'error');
  assert.equal(detail.kind, 'network', detail.message);
  await alertOf(page).getByText(detail.message).waitFor();
  await page.context().setOffline(false);
  await page.getByRole('button', { name: 'Retry' }).click();
  await harness.event(page, 'load');
  assert.deepEqual(uncaught, []);
  await close();
});

/** From now on the page's network is as slow as what browsers' tools call Slow 3G. */
async function slowDown(page) {
  const cdp = await page.context().newCDPSession(page);
  const throughput = 50_000;
  await cdp.send('Network.enable');
  await cdp.send('Network.emulateNetworkConditions', {
    offline: false,
    latency: 2000,
    downloadThroughput: throughput,
    uploadThroughput: throughput,
  });
}

/** Shows a picture, and tells what is seen until its first frame: which bytes, which share of all. */
function watched(page, src) {
  return page.evaluate(async (src) => {
    const viewer = document.querySelector('istar-viewer');
    const progress = viewer.shadowRoot.querySelector('.progress');
    const bar = progress.querySelector('[role=progressbar]');
    const seen = [];
    let isThere = false;
    viewer.addEventListener('load', () => {
      isThere = true;
    });
    viewer.src = src;
    while (!isThere) {
      // Text alone is nothing to see: it appears after a while.
      if (progress.checkVisibility() && getComputedStyle(progress).opacity > 0.5) {
        const loaded = window.seen.findLast(({ name }) => name === 'progress')?.detail.loaded ?? 0;
        seen.push({ loaded, share: bar.ariaValueNow });
      }
      await new Promise((done) => setTimeout(done, 50));
    }
    return { seen, loaded: seen.map(({ loaded }) => loaded), isOver: !progress.checkVisibility() };
  }, src);
}

/** Never less than before, and in more than a few steps. */
function grows(values) {
  return new Set(values).size > 5 && values.every((value, i) => i === 0 || value >= values[i - 1]);
}

// All at once: they wait for their networks most of the time.
test('on a slow network', { concurrency: true }, async (t) => {
  const part = async (name, step) => {
    const { page, uncaught, close } = await openWithout();
    await slowDown(page);
    await t.test(name, () => step(page));
    assert.deepEqual(uncaught, []);
    await close();
  };
  await Promise.all([
    part('progress is soon seen, grows to all of the file, and goes', async (page) => {
      const { seen, loaded, isOver } = await watched(page, `${files.base}whole`);
      const shares = seen.map(({ share }) => Number(share));
      // The first answer takes two seconds.
      assert.equal(seen[0].loaded, 0);
      assert.ok(grows(loaded) && grows(shares), `${loaded}; ${shares}`);
      assert.ok(isOver);
    }),
    part('progress is soon seen, grows and goes, where files are read by ranges', async (page) => {
      const { seen, loaded, isOver } = await watched(page, `${run.server.url}gallery/map.istar`);
      assert.equal(seen[0].loaded, 0);
      assert.ok(grows(loaded), `${loaded}`);
      // Nobody knows how much of the file the view needs.
      assert.ok(seen.every(({ share }) => share === null));
      assert.ok(isOver);
    }),
    part('a picture in tiles is seen before all of it is there', async (page) => {
      const { first, all, colors } = await page.evaluate(async (src) => {
        const viewer = document.querySelector('istar-viewer');
        const start = performance.now();
        viewer.src = src;
        location.hash = '#view=512,384,2';
        await new Promise((done) => viewer.addEventListener('load', done));
        const first = performance.now() - start;
        const canvas = viewer.shadowRoot.querySelector('.stage canvas');
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        const colors = new Set(new Uint32Array(data.buffer)).size;
        await viewer.painted;
        return { first, all: performance.now() - start, colors };
      }, `${files.base}quilt`);
      console.log(`a first picture after ${first.toFixed()} ms, all of the view after ${all.toFixed()} ms`);
      assert.ok(all > first + 1000);
      assert.ok(colors > 1);
    }),
  ]);
});

test('progress is shown, with a share where the length is known', async () => {
  for (const [name, total] of [
    ['slow', picture.length],
    ['slow-chunked', undefined],
  ]) {
    const { page, close } = await open(files.base + name);
    const first = await harness.event(page, 'progress');
    assert.equal(first.total, total);
    assert.ok(first.loaded > 0 && first.loaded < picture.length);
    const bar = page.getByRole('progressbar');
    await bar.waitFor();
    assert.equal(await bar.getAttribute('aria-valuenow'), total === undefined ? null : '25');
    release();
    await harness.event(page, 'load');
    await bar.waitFor({ state: 'hidden' });
    await close();
  }
});

test('a new src ends the old load, without an error', async () => {
  const { page, uncaught, close } = await open(`${files.base}slow`);
  await harness.event(page, 'progress');
  await page.evaluate((src) => {
    document.querySelector('istar-viewer').src = src;
  }, `${files.base}none`);
  await harness.event(page, 'load');
  release();
  await page.waitForTimeout(200);
  const names = await page.evaluate(() => window.seen.map(({ name }) => name));
  assert.equal(names.filter((name) => name === 'load').length, 1);
  assert.ok(!names.includes('error'));
  assert.deepEqual(uncaught, []);
  await close();
});

test('a removed figure stops, a moved one keeps its picture', async () => {
  const { page, uncaught, close } = await open(`${files.base}none`);
  await harness.event(page, 'load');
  const loads = () => page.evaluate(() => window.seen.filter(({ name }) => name === 'load').length);
  await page.evaluate(() => {
    document.body.prepend(document.querySelector('istar-viewer'));
  });
  await page.waitForTimeout(200);
  assert.equal(await loads(), 1);
  await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    viewer.remove();
    await new Promise((done) => setTimeout(done, 50));
    document.body.append(viewer);
  });
  await page.waitForFunction(() => window.seen.filter(({ name }) => name === 'load').length === 2);
  assert.deepEqual(uncaught, []);
  await close();
});

test('an image inside stands in until the first frame', async () => {
  const { page, close } = await harness.newPage(run.browser);
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${encodeURIComponent(`${files.base}slow`)}`);
  const dot = 'data:image/gif;base64,R0lGODlhAQABAIAAAAAAAP///yH5BAEAAAAALAAAAAABAAEAAAIBRAA7';
  await page.evaluate((src) => {
    document.querySelector('istar-viewer').innerHTML = `<img src="${src}" alt="A stand-in">`;
  }, dot);
  const image = page.locator('istar-viewer > img');
  assert.equal(await image.isVisible(), true);
  release();
  await harness.event(page, 'load');
  assert.equal(await image.isVisible(), false);
  await close();
});

test('an image that the attribute names stands in, in its own shape', async () => {
  const { page, uncaught, close } = await harness.newPage(run.browser);
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${encodeURIComponent(`${files.base}slow`)}`);
  const set = (url) =>
    page.evaluate((url) => {
      const viewer = document.querySelector('istar-viewer');
      viewer.style.height = 'auto';
      viewer.setAttribute('poster', url);
    }, url);
  const image = page.locator('istar-viewer .poster');
  assert.equal(await image.isVisible(), false);
  await set('data:image/svg+xml,<svg xmlns="http://www.w3.org/2000/svg" width="40" height="10"/>');
  await image.waitFor();
  await page.waitForFunction(() => {
    const { width, height } = document.querySelector('istar-viewer').getBoundingClientRect();
    return Math.abs(width / height - 4) < 0.1;
  });
  await set('');
  assert.equal(await image.isVisible(), false);
  await set('no/such.png');
  release();
  await harness.event(page, 'load');
  assert.equal(await image.isVisible(), false);
  assert.deepEqual(uncaught, []);
  await close();
});

test('what a page has for the poster and for progress stands in their place, as long', async () => {
  const { page, uncaught, close } = await harness.newPage(run.browser);
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${encodeURIComponent(`${files.base}slow`)}`);
  await page.evaluate(() => {
    document.querySelector('istar-viewer').innerHTML =
      '<b slot="poster">Soon</b><i slot="progress">Wait <img alt="A clock" width="9" height="1"></i>';
  });
  const [soon, wait] = ['Soon', 'Wait'].map((text) => page.getByText(text));
  await harness.event(page, 'progress');
  assert.ok((await soon.isVisible()) && (await wait.isVisible()));
  assert.ok(await page.locator('istar-viewer .progress').isHidden());
  // How far it is, for bars of its own.
  const share = await wait.evaluate((wait) => getComputedStyle(wait).getPropertyValue('--istar-share'));
  assert.equal(Number(share).toFixed(2), '0.25');
  assert.equal(await page.getByRole('application', { name: 'A clock' }).count(), 0);
  release();
  await harness.event(page, 'load');
  assert.ok((await soon.isHidden()) && (await wait.isHidden()));
  assert.deepEqual(uncaught, []);
  await close();
});

test('a file that somebody chose, or whatever else gives bytes, is shown in place of src', async () => {
  const { page, uncaught, close } = await open(`${files.base}none`);
  await harness.event(page, 'load');
  const shown = (source) =>
    page.evaluate(
      async ([source, lands]) => {
        const viewer = document.querySelector('istar-viewer');
        const bytes = await (await fetch(lands)).arrayBuffer();
        viewer.source = {
          file: () => new File([bytes], 'lands.istar'),
          blob: () => new Blob([bytes]),
          own: () => ({
            getBytes: async (from, length) => ({ data: bytes.slice(from, from + length) }),
            getKey: () => 'own',
          }),
          torn: () => new File([bytes.slice(0, 99)], 'torn.istar'),
          throws: () => ({
            getBytes: () => {
              throw new Error('none today');
            },
            getKey: () => 'throws',
          }),
          nonsense: () => ({ getBytes: () => 7 }),
          nothing: () => null,
        }[source]();
        const key = viewer.source?.getKey?.();
        return viewer.painted.then(
          () => ({ key, pixels: viewer.place }),
          ({ kind, message }) => ({ key, kind, message }),
        );
      },
      [source, `${files.base}none`],
    );
  const { pixels } = await shown('nothing');
  assert.deepEqual(await shown('file'), { key: 'lands.istar', pixels });
  assert.deepEqual(await shown('blob'), { key: '', pixels });
  assert.deepEqual(await shown('own'), { key: 'own', pixels });
  assert.equal((await shown('torn')).kind, 'malformed');
  assert.match((await shown('throws')).message, /none today/);
  await page.getByText('none today').waitFor();
  assert.equal((await shown('nonsense')).kind, 'malformed');
  assert.deepEqual(await shown('nothing'), { key: undefined, pixels });
  assert.deepEqual(uncaught, []);
  await close();
});

test('works under a strict content security policy', async () => {
  const { page, uncaught, close } = await harness.newPage(run.browser);
  await page.route('**/made/*', (route) => route.fulfill({ body: picture }));
  await page.route('**/view.html*', async (route) => {
    const response = await route.fetch();
    const policy = "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; img-src data:";
    await route.fulfill({ response, headers: { ...response.headers(), 'content-security-policy': policy } });
  });
  const refused = [];
  page.on(
    'console',
    (message) => message.text().includes('Content Security Policy') && refused.push(message.text()),
  );
  await harness.openViewer(page, run.server.url, { src: 'made/lands.istar' });
  assert.deepEqual(refused, []);
  assert.deepEqual(uncaught, []);
  await close();
});

for (const backend of harness.BACKENDS) {
  test(`the gallery page shows both pictures with ${backend}`, async () => {
    const { page, uncaught, close } = await harness.newPage(run.browser, {
      // All of large pictures takes software its time.
      viewport: { width: 200, height: 700 },
    });
    await page.goto(`${run.server.url}?backend=${backend}`);
    await page.waitForFunction(() => window.seen.filter(({ name }) => name === 'load').length === 2);
    const shown = await page.evaluate(() =>
      [...document.querySelectorAll('istar-viewer')].map((viewer) => viewer.backend),
    );
    assert.deepEqual(shown, [backend, backend]);
    assert.deepEqual(uncaught, []);
    await close();
  });
}

test('without WebGPU, WebGL2 draws', async () => {
  const { page, uncaught, close } = await harness.newPage(run.browser);
  await page.addInitScript(() => {
    delete Navigator.prototype.gpu;
  });
  await harness.openViewer(page, run.server.url, { src: `${files.base}none`, backend: 'auto' });
  assert.equal(await page.evaluate(() => document.querySelector('istar-viewer').backend), 'webgl2');
  assert.deepEqual(uncaught, []);
  await close();
});

test('without the GPU that is asked for it says so', async () => {
  const { page, uncaught, close } = await harness.newPage(run.browser);
  await page.addInitScript(() => {
    delete Navigator.prototype.gpu;
    OffscreenCanvas.prototype.getContext = () => null;
  });
  await page.goto(`${run.server.url}view.html?backend=webgl2&src=${files.base}none`);
  const detail = await harness.event(page, 'error');
  assert.equal(detail.kind, 'gpu');
  await alertOf(page).getByText(detail.message).waitFor();
  assert.deepEqual(uncaught, []);
  await close();
});

test('a viewer that lost its own file on the way says so, and retry works', async () => {
  const { page, uncaught, close } = await harness.newPage(run.browser);
  await page.route('**/istar_bg.wasm', (route) => route.fulfill({ status: 503 }), { times: 1 });
  await page.goto(`${run.server.url}view.html?src=${files.base}none`);
  assert.equal((await harness.event(page, 'error')).kind, 'http');
  await page.getByRole('button', { name: 'Retry' }).click();
  await harness.event(page, 'load');
  assert.deepEqual(uncaught, []);
  await close();
});
