// What `npm run bench -- frames` measures: a moving view in Chromium with the software GPU, with what the viewer has beside the
// picture and without, and one that is only dragged, of which most is kept. Each is measured in turn, over and over, in one page, by the
// processor's time of all that the browser is, its GPU included: other work on the machine is none of it.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { PNG } from 'pngjs';
import { at, cli, TaskError } from '../../web/tasks/project.mjs';
import { BACKENDS, event, launch, newPage, serve } from '../browser/harness.mjs';

/** Of the window: the figure, and the legend beside it. */
const SIZE = { width: 600, height: 360 };
/** A frame with all of it takes no longer than so many without. */
const MOST = 1.2;
const ROUNDS = 6;
/** Frames of a drag and of a zoom in each round. */
const FRAMES = 12;

/**
 * Attributes of the figure; `pointer`: it rests on the picture, and comes to other regions as the view moves; `legend`: there is one;
 * `dragged`: by whole pixels and not zoomed into.
 */
const FURNITURE = {
  nothing: {},
  dragged: { dragged: true },
  controls: { controls: '' },
  scalebar: { scalebar: '', unit: 'km', 'unit-per-pixel': '7.5' },
  navigator: { navigator: '' },
  hash: { hash: '' },
  hover: { interactive: '', pointer: true },
  legend: { pointer: true, legend: true },
};
FURNITURE.all = Object.assign({}, ...Object.values(FURNITURE), { dragged: false });

export async function measureFrames() {
  const folder = mkdtempSync(join(tmpdir(), 'istar-'));
  const server = await serve(cli);
  // Nothing waits for a screen that shows no more than sixty frames a second.
  const browser = await launch(['--disable-frame-rate-limit', '--disable-gpu-vsync']);
  try {
    const file = namedMap(folder);
    for (const backend of BACKENDS) await table(browser, server.url, file, backend);
  } finally {
    await browser.close();
    server.stop();
    rmSync(folder, { recursive: true });
  }
}

/** The gallery's map with a name for every colour. */
function namedMap(folder) {
  const { data } = PNG.sync.read(readFileSync(at('web', 'gallery', 'map.png')));
  const colors = new Set();
  for (let i = 0; i < data.length; i += 4) colors.add(data.toString('hex', i, i + 3));
  const [names, file] = [join(folder, 'names.csv'), join(folder, 'map.istar')];
  writeFileSync(names, [...colors].map((color, i) => `#${color},Land ${i}\n`).join(''));
  execFileSync(cli, ['encode', at('web', 'gallery', 'map.png'), '-o', file, '--names', names], {
    stdio: 'ignore',
  });
  return readFileSync(file);
}

async function table(browser, url, file, backend) {
  const { page, uncaught, close } = await newPage(browser, { viewport: SIZE });
  await page.route('**/made/map.istar', (route) => route.fulfill({ body: file }));
  // By this clock every frame is in time: a view that is late is drawn with fewer pixels, and would be as fast again.
  await page.addInitScript(() => {
    performance.now = () => 0;
  });
  await page.goto(`${url}view.html?backend=${backend}&src=made/map.istar`);
  await event(page, 'load');
  await page.evaluate(() => {
    document.querySelector('istar-viewer').style.width = '480px';
  });
  await page.addScriptTag({ type: 'module', url: 'istar-legend.js' });
  const cdp = await browser.newBrowserCDPSession();
  const names = Object.keys(FURNITURE);
  const times = Object.fromEntries(names.map((name) => [name, []]));
  for (let round = 0; round < ROUNDS; round++) {
    // There and back again, so that what grows slower or faster does so for all.
    for (const name of round % 2 ? names.toReversed() : names) {
      await furnish(page, FURNITURE[name]);
      const before = await processorTime(cdp);
      await page.evaluate(move, [FRAMES, FURNITURE[name].dragged === true]);
      times[name].push((await processorTime(cdp)) - before);
    }
  }
  if (uncaught.length > 0) throw new TaskError(uncaught.join('\n'));
  await close();
  console.log(`\nframes, ${backend.padEnd(8)} ms a frame   of nothing's`);
  const least = (name) => Math.min(...times[name]);
  const ratio = (name) => least(name) / least('nothing');
  for (const name of names)
    console.log(`${name.padEnd(16)} ${least(name).toFixed(2).padStart(10)}   ${ratio(name).toFixed(3)}`);
  if (ratio('all') > MOST) {
    const times = ratio('all').toFixed(2);
    throw new TaskError(`A frame with all of it takes ${times} times as long, with ${backend}.`);
  }
}

async function furnish(page, { pointer, legend, dragged, ...attributes }) {
  await page.mouse.move(pointer ? 240 : 5, pointer ? 180 : 5);
  await page.evaluate(
    async ([attributes, wantsLegend, all]) => {
      const viewer = document.querySelector('istar-viewer');
      for (const name of all) {
        if (name in attributes) viewer.setAttribute(name, attributes[name]);
        else viewer.removeAttribute(name);
      }
      document.querySelector('istar-legend')?.remove();
      if (wantsLegend) {
        const legend = document.createElement('istar-legend');
        Object.assign(legend.style, {
          position: 'fixed',
          inset: '0 0 0 auto',
          width: '120px',
          overflow: 'auto',
        });
        document.body.append(legend);
      }
      viewer.zoomTo(2950, 684, 4);
      await viewer.painted;
      // What comes once, as the overview does, is no part of frames.
      await new Promise((done) => setTimeout(done, 300));
      for (const canvas of viewer.shadowRoot.querySelectorAll('canvas'))
        canvas.getContext('2d').getImageData(0, 0, 1, 1);
    },
    [attributes, legend === true, [...new Set(Object.values(FURNITURE).flatMap(Object.keys))]],
  );
}

/** In the page: the view goes over the map, by parts of pixels, so that all of it is drawn, and into it; or it is dragged. */
async function move([frames, dragged]) {
  const viewer = document.querySelector('istar-viewer');
  const context = viewer.shadowRoot.querySelector('.stage canvas').getContext('2d');
  for (let i = 0; i < 2 * frames; i++) {
    if (dragged) viewer.zoomTo(2950 + 2 * i, 684 + 0.5 * i, 4);
    else if (i < frames) viewer.zoomTo(2950 + 4.1 * i, 684 + i, 4);
    else viewer.zoomTo(3018, 684, 4 * 1.1 ** (i - frames));
    await new Promise(requestAnimationFrame);
    // Until it is there: a GPU in software would still be at it long after the last was asked for.
    context.getImageData(0, 0, 1, 1);
  }
}

/** Milliseconds for a frame, of all of the browser's processes. */
async function processorTime(cdp) {
  const { processInfo } = await cdp.send('SystemInfo.getProcessInfo');
  return (processInfo.reduce((sum, { cpuTime }) => sum + cpuTime, 0) * 1000) / (2 * FRAMES);
}
