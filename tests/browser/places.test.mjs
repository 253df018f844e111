// Views as text: exact at any depth, and kept in the page's address where a figure asks for it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as harness from './harness.mjs';

const run = harness.session();

/** A page with a figure for each name of a part of the fragment; null for one without. */
async function open(names, fragment = '', { prepare, ...options } = {}) {
  const tab = await harness.newPage(run.browser, { reducedMotion: 'reduce', ...options });
  await prepare?.(tab.page);
  await tab.page.route('**/figures.html', (route) => {
    const figures = names.map((name) => {
      const hash = name === null ? '' : `hash="${name}"`;
      return `<istar-viewer src="gallery/map.istar" alt="Map" backend="webgl2" style="height: 150px" ${hash}></istar-viewer>`;
    });
    const script = '<script type="module" src="istar.js"></script>';
    route.fulfill({ contentType: 'text/html', body: `<!doctype html>${script}${figures.join('')}` });
  });
  await tab.page.goto(`${run.server.url}figures.html${fragment}`);
  await loaded(tab.page, names.length);
  return tab;
}

/** Waits for so many pictures. */
function loaded(page, count) {
  return page.waitForFunction(
    (count) => window.seen.filter(({ name }) => name === 'load').length >= count,
    count,
  );
}

const places = (page) =>
  page.evaluate(() =>
    Promise.all(
      [...document.querySelectorAll('istar-viewer')].map(async (viewer) => {
        await viewer.painted;
        return viewer.place;
      }),
    ),
  );

/** Moves the view of a figure. */
async function show(page, place, figure = 0) {
  await page.evaluate(
    async ([place, figure]) => {
      const viewer = document.querySelectorAll('istar-viewer')[figure];
      viewer.place = place;
      await viewer.painted;
    },
    [place, figure],
  );
}

/** Waits until the page's address says so. */
const says = (page, fragment) => page.waitForFunction((fragment) => location.hash === fragment, fragment);
/** As long as it takes for an address to follow. */
const followed = (page) => page.waitForTimeout(400);

const fragment = (page) => new URL(page.url()).hash;

test('a place is what it was set to, digit by digit', async () => {
  const { page, uncaught, close } = await open([null]);
  for (const place of [
    '0,0,1',
    '3018.5,684.25,12.5',
    '3018.0000000000012345,684.99999999999,1000000000',
    '5792,2896,1000000000000',
    '17.000000000000000000001,0.3333333333333333,123456789.123',
  ]) {
    await show(page, place);
    assert.deepEqual(await places(page), [place]);
  }
  const before = await places(page);
  for (const nonsense of [
    '',
    '1,2',
    '1,2,3,4,5',
    '1,2,3,,flipped',
    'a,b,c',
    '-1,2,3',
    '1.,2,3',
    '1e3,2,3',
    '1,2,nonsense',
  ]) {
    await show(page, nonsense);
    assert.deepEqual(await places(page), before, nonsense);
  }
  await show(page, '7,8,-1');
  assert.equal(await places(page).then(([place]) => place.split(',')[2] > 0), true);
  await followed(page);
  assert.equal(fragment(page), '', 'nobody asked for it');
  assert.deepEqual(uncaught, []);
  await close();
});

test('with another picture comes the view that its address says', async () => {
  const { page, uncaught, close } = await open(['']);
  await show(page, '100,200,4');
  await says(page, '#view=100,200,4');
  const [src, other] = await page.evaluate(async () => {
    const viewer = document.querySelector('istar-viewer');
    const { src } = viewer;
    const other = `${src}?again`;
    viewer.src = other;
    history.pushState(null, '', '#view=300,400,5');
    await new Promise((done) => viewer.addEventListener('load', done, { once: true }));
    return [src, viewer.src];
  });
  assert.notEqual(src, other);
  assert.deepEqual(await places(page), ['300,400,5']);
  // Who asks for it later and moves at once stays there.
  await page.evaluate(() => {
    const viewer = document.querySelector('istar-viewer');
    viewer.removeAttribute('hash');
    viewer.setAttribute('hash', '');
    viewer.place = '500,600,6';
  });
  await says(page, '#view=500,600,6');
  assert.deepEqual(uncaught, []);
  await close();
});

test('a view at 10⁹× is the same after a reload', async () => {
  const { page, uncaught, close } = await open(['']);
  // A boundary: only there is anything to see.
  const y = 684;
  let [low, high] = [3000, 3100];
  const region = (x) =>
    page.evaluate(
      async ([x, y]) => {
        const viewer = document.querySelector('istar-viewer');
        viewer.place = `${x},${y},1000000000`;
        await viewer.painted;
        const box = viewer.getBoundingClientRect();
        return viewer.pick(box.left + box.width / 2, box.top + box.height / 2);
      },
      [x, y],
    );
  const left = await region(low);
  assert.notEqual(await region(high), left, 'two regions');
  while (high - low > 1e-8) {
    const middle = (low + high) / 2;
    if ((await region(middle)) === left) low = middle;
    else high = middle;
  }
  await show(page, `${high},${y},1000000000`);
  // By the pointer: a place that nobody has written.
  await page.mouse.move(240, 75);
  await page.mouse.down();
  await page.mouse.move(250, 82);
  await page.mouse.move(253, 79);
  await page.mouse.up();
  const [place] = await places(page);
  await says(page, `#view=${place}`);
  const before = await harness.shot(page);
  assert.ok(harness.colors(before) > 1, 'a boundary is in sight');

  await page.reload();
  await loaded(page, 1);
  assert.deepEqual(await places(page), [place]);
  assert.deepEqual(await harness.shot(page), before);
  assert.deepEqual(uncaught, []);
  await close();
});

test('figures have names of their own, and other parts of the fragment stay', async () => {
  const first = '#chapter&left=100,200,4&right=1000.5%2C700,8';
  const { page, uncaught, close } = await open(['left', 'right', null], first);
  const [left, right, none] = await places(page);
  assert.deepEqual([left, right], ['100,200,4', '1000.5,700,8']);
  await says(page, '#chapter&left=100,200,4&right=1000.5,700,8');
  await show(page, '33,44,5', 1);
  await says(page, '#chapter&left=100,200,4&right=33,44,5');
  await show(page, '1,2,3', 2);
  await followed(page);
  assert.equal(fragment(page), '#chapter&left=100,200,4&right=33,44,5');
  assert.notEqual(none, left);

  // A link on the page, or another address typed in.
  await page.evaluate(() => {
    location.hash = '#left=55,66,7&right=33,44,5';
  });
  await page.waitForFunction(() => document.querySelector('istar-viewer').place === '55,66,7');
  assert.deepEqual((await places(page)).slice(1), ['33,44,5', '1,2,3']);

  // All of it needs no words, and a figure that is gone says none.
  await page.evaluate(() => document.querySelector('istar-viewer').fit());
  await page.waitForFunction(() => location.hash === '#right=33,44,5');
  await page.evaluate(async () => {
    const viewer = document.querySelectorAll('istar-viewer')[1];
    viewer.place = '9,9,9';
    await viewer.painted;
    viewer.remove();
  });
  await followed(page);
  assert.equal(fragment(page), '#right=33,44,5');
  assert.deepEqual(uncaught, []);
  await close();
});

test('a fragment that says nothing, or too much, does no harm', async () => {
  const { page, uncaught, close } = await open([''], '#%E0%A4%A');
  const [whole] = await places(page);
  for (const odd of ['#view=', '#view', '#view=1,2', '#view=%E0%A4%A', '#view=9,9,nonsense']) {
    await page.evaluate((odd) => {
      location.hash = odd;
    }, odd);
    await page.waitForTimeout(50);
    assert.deepEqual((await places(page))[0].split(',')[2], whole.split(',')[2], odd);
  }
  for (const [far, place] of [
    ['99999999999999999999,5.5,1e300', '5792,5.5,1000000000000'],
    [`${'9'.repeat(400)},5,2`, '0,5,2'],
  ]) {
    await page.evaluate((far) => {
      location.hash = `#view=${far}`;
    }, far);
    await page.waitForTimeout(50);
    assert.deepEqual(await places(page), [place]);
  }
  assert.deepEqual(uncaught, []);
  await close();
});

test('an address that may not be changed is left alone, and a new picture starts anew', async () => {
  const { page, uncaught, close } = await open([''], '#view=100,200,4');
  await page.evaluate(() => {
    history.replaceState = () => {
      throw new DOMException('too often', 'SecurityError');
    };
  });
  await show(page, '1,2,3');
  await followed(page);
  assert.equal(fragment(page), '#view=100,200,4');
  await page.evaluate(() => {
    delete history.replaceState;
    document.querySelector('istar-viewer').src = 'gallery/emblem.istar';
  });
  await loaded(page, 2);
  assert.equal(fragment(page), '');
  // All of a picture that is as wide as it is high.
  assert.equal(await places(page).then(([place]) => place.split(',').slice(0, 2).join()), '2048,2048');
  assert.deepEqual(uncaught, []);
  await close();
});

test('a picture does not wait for ever for what reads addresses, and goes there when that comes', async () => {
  let answer;
  const asked = new Promise((resolve) => {
    answer = resolve;
  });
  const prepare = (page) => page.route('**/istar-hash.js', (route) => asked.then(() => route.continue()));
  const wanted = '3018.5,684.25,12.5';
  const { page, uncaught, close } = await open([''], `#view=${wanted}`, { prepare });
  assert.notDeepEqual(await places(page), [wanted]);
  answer();
  await page.waitForFunction((wanted) => document.querySelector('istar-viewer').place === wanted, wanted);
  assert.deepEqual(uncaught, []);
  await close();
});
