// What both back ends draw against the oracle: the regions at 16 × 16 places of each pixel, which picking tells.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { PNG } from 'pngjs';
import { at } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';
import { encodedPart } from './pictures.mjs';

const SIZE = { width: 32, height: 24 };
const SCALES = [0.02, 0.1, 0.5, 1, 3, 10, 1e2, 1e4, 1e6, 1e9, 1e12];
const LEAST_PSNR = 42;
/** Parts of the gallery's pictures with boundaries and junctions: left, top, width and height. */
const PICTURES = {
  map: [2700, 500, 800, 600],
  emblem: [2600, 1100, 800, 600],
};

const run = harness.session();
const folder = harness.temporaryFolder();
const files = harness.serveFolder(folder);

for (const [name, part] of Object.entries(PICTURES)) {
  const picture = PNG.sync.read(readFileSync(at('web', 'gallery', `${name}.png`)));
  for (const kernel of ['quadratic', 'linear']) {
    for (const gamma of ['voronoi', 'planes']) {
      test(`${name}, ${kernel}, ${gamma}: at every scale it is the mean of many samples`, async () => {
        const file = `${name}-${kernel}-${gamma}`;
        const options = ['--texel-size', '8', '--kernel', kernel, '--gamma', gamma];
        encodedPart(folder, file, picture, part, ...options);
        const { page, uncaught, close } = await harness.newPage(run.browser);
        await page.goto(`${run.server.url}index.html`);
        await page.evaluate(show, [`${files.base}${file}.istar`, harness.BACKENDS, SIZE]);
        // In a boundary's view there are two regions, in a junction's three; strokes may part everything.
        for (const regions of [2, 3]) {
          const place = await page.evaluate(seek, regions);
          if (!place) assert.equal(regions, 3, 'there is a boundary');
          else
            for (const scale of SCALES)
              for (const found of await page.evaluate(compare, [place, scale])) {
                const { backend, psnr, off } = found;
                // See at_every_scale_it_is_the_mean_of_many_samples of the suite.
                if (psnr >= LEAST_PSNR && off <= (kernel === 'linear' ? 2 : 0)) continue;
                const [actual, expected] = [found.actual, found.expected].map(asPicture);
                const kept = harness.keepUnlike(`oracle-${file}-${backend}-${scale}`, actual, expected);
                assert.fail(`${backend}, ${place}, ${scale}: ${psnr.toFixed(1)} dB, ${off} off, see ${kept}`);
              }
        }
        assert.deepEqual(uncaught, []);
        await close();
      });
    }
  }
}

function asPicture(pixels) {
  const picture = new PNG(SIZE);
  picture.data.set(pixels);
  return picture;
}

/** In the page: viewers of one picture, one for each back end. */
async function show([src, backends, { width, height }]) {
  await customElements.whenDefined('istar-viewer');
  const viewers = backends.map((backend) => {
    const viewer = document.createElement('istar-viewer');
    viewer.style.cssText = `position: fixed; z-index: 9; inset: 0 auto auto 0; width: ${width}px; height: ${height}px`;
    for (const [name, value] of Object.entries({ src, backend, alt: 'A part', loading: 'eager' }))
      viewer.setAttribute(name, value);
    return viewer;
  });
  document.body.replaceChildren(...viewers);
  await Promise.all(viewers.map((viewer) => viewer.painted));
  // They stay where they are, and millions of places are picked.
  const canvas = viewers[0].shadowRoot.querySelector('.stage canvas');
  const box = canvas.getBoundingClientRect();
  canvas.getBoundingClientRect = () => box;
}

/** In the page: a place where so many regions meet, to f64's last digit but few. */
async function seek(wanted) {
  const viewer = document.querySelector('istar-viewer');
  const { width, height } = viewer.getBoundingClientRect();
  viewer.fit();
  await viewer.painted;
  const [wide, high] = viewer.style.getPropertyValue('--istar-aspect').split('/').map(Number);
  /** In a view of that scale, the place nearest to the middle around which so many meet. */
  const nearest = (x, y, scale) => {
    // The picture is one tile: nothing need be painted for it.
    viewer.zoomTo(x, y, scale);
    const picked = [];
    for (let i = 0; i < width * height; i++)
      picked.push(viewer.pick((i % width) + 0.5, Math.floor(i / width) + 0.5));
    let found;
    for (let row = 1; row < height; row++)
      for (let column = 1; column < width; column++) {
        const at = row * width + column;
        const around = new Set([at, at - 1, at - width, at - width - 1].map((i) => picked[i]));
        const [dx, dy] = [column - width / 2, row - height / 2];
        if (around.size < wanted || around.has(undefined)) continue;
        const far = Math.hypot(dx, dy);
        if (!found || far < found.far) found = { far, x: x + dx / scale, y: y + dy / scale };
      }
    return found;
  };
  // Views side by side, until one has such a place.
  for (let y = 100; y < high - 50; y += 24)
    for (let x = 100; x < wide - 50; x += 32) {
      let found = nearest(x, y, 1);
      for (let scale = 8; found && scale < 1e13; scale *= 8) found = nearest(found.x, found.y, scale);
      if (found) return [found.x, found.y];
    }
  return undefined;
}

/**
 * In the page: for each back end the PSNR, and how many pixels are off by more than a third of the contrast around. What is picked is
 * what is in the middles of pixels: the view is moved by sixteenths of a pixel.
 */
async function compare([place, scale]) {
  const SAMPLES = 16;
  const AROUND = 2;
  const viewers = [...document.querySelectorAll('istar-viewer')];
  const [viewer] = viewers;
  const { width, height } = viewer.getBoundingClientRect();
  /** Moved by a part of a pixel, with every digit. */
  const moved = (at, sample) => {
    const part = BigInt((2 * sample + 1 - SAMPLES) * 3125) * 10n ** 22n;
    const digits = BigInt(at.toFixed(25).replace('.', '')) + part / BigInt(Math.round(scale * 100));
    return String(digits).replace(/(\d{25})$/, '.$1');
  };
  for (const viewer of viewers) viewer.place = `${place},${scale}`;
  await Promise.all(viewers.map((viewer) => viewer.painted));
  const drawn = viewers.map((viewer) => {
    const canvas = viewer.shadowRoot.querySelector('.stage canvas');
    return [viewer.backend, canvas.getContext('2d').getImageData(0, 0, width, height).data];
  });
  /** Colours as what they add to a sum. */
  const colors = new Map([[undefined, [0, 0, 0, 0]]]);
  for (const { region, color } of viewer.regions) {
    const [r, g, b, a] = [1, 3, 5, 7].map((i) => Number.parseInt(color.slice(i, i + 2), 16));
    colors.set(region, [...[r, g, b].map((value) => (value * a) / 255), a]);
  }
  const oracle = Array.from({ length: width * height }, () => ({
    regions: new Set(),
    sum: [0, 0, 0, 0],
    low: [255, 255, 255, 255],
    high: [0, 0, 0, 0],
  }));
  for (let sample = 0; sample < SAMPLES ** 2; sample++) {
    const [x, y] = [moved(place[0], sample % SAMPLES), moved(place[1], Math.floor(sample / SAMPLES))];
    viewer.place = `${x},${y},${scale}`;
    for (const [i, { regions, sum, low, high }] of oracle.entries()) {
      const region = viewer.pick((i % width) + 0.5, Math.floor(i / width) + 0.5);
      const color = colors.get(region);
      for (let c = 0; c < 4; c++) sum[c] += color[c] / SAMPLES ** 2;
      if (regions.has(region)) continue;
      regions.add(region);
      for (let c = 0; c < 4; c++) {
        low[c] = Math.min(low[c], color[c]);
        high[c] = Math.max(high[c], color[c]);
      }
    }
  }
  const contrast = (i) => {
    const around = oracle.filter(
      (_, other) =>
        Math.abs((other % width) - (i % width)) <= AROUND &&
        Math.abs(Math.floor(other / width) - Math.floor(i / width)) <= AROUND,
    );
    const range = (c) =>
      Math.max(...around.map(({ high }) => high[c])) - Math.min(...around.map(({ low }) => low[c]));
    return Math.max(...[0, 1, 2, 3].map(range));
  };
  return drawn.map(([backend, data]) => {
    let [squares, off] = [0, 0];
    for (const [i, { sum, regions }] of oracle.entries()) {
      const [r, g, b, a] = data.subarray(4 * i, 4 * i + 4);
      const shown = [...[r, g, b].map((value) => (value * a) / 255), a];
      const errors = shown.map((value, c) => Math.abs(value - sum[c]));
      for (const error of errors) squares += error ** 2;
      // Bytes are rounded, and of more than three regions three are blended.
      const most = Math.max(...errors) - 2;
      if (regions.size <= 3 && most > 0 && most > contrast(i) / 3) off++;
    }
    const psnr = 10 * Math.log10((255 ** 2 * 4 * oracle.length) / squares);
    const straight = oracle.flatMap(({ sum }) =>
      sum.map((s, c) => (c === 3 ? s : (s * 255) / (sum[3] || 1))),
    );
    return { backend, psnr, off, actual: [...data], expected: straight.map(Math.round) };
  });
}
