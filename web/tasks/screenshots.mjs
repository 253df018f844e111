// `npm run screenshots`: the pictures of the readme and of the site, from what is built: web/readme.png, a piece of the gallery's map
// and a detail of it as PNG and as IStar; and web/viewer-light.png and -dark.png, the viewer with what it may have beside a picture.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { build } from './build.mjs';
import { at, cli, main, run } from './project.mjs';

const PANE = { width: 400, height: 300 };
const GAP = 8;
/** A place where three countries meet, in source pixels. */
const CENTER = { x: 3018, y: 684 };
const CLOSE = 30;
/** Of the frame around the detail, in pixels: white, with a dark line on either side. */
const FRAME = 4;

const VIEWER = { width: 800, height: 400 };
/** What the pointer is on, and the view around it. */
const VIEW = { x: 3060, y: 700, scale: 2.2 };

export async function screenshots() {
  const { PNG } = await import('pngjs');
  comparison(PNG);
  await viewer();
}

function comparison(PNG) {
  const source = PNG.sync.read(readFileSync(at('web', 'gallery', 'map.png')));
  const panes = [rendered(PNG, 1), magnified(PNG, source, CLOSE), rendered(PNG, CLOSE)];
  frame(panes[0], CLOSE);
  // What lies between is transparent: the page is light or dark.
  const strip = new PNG({ width: panes.length * (PANE.width + GAP) - GAP, height: PANE.height });
  for (const [i, pane] of panes.entries()) {
    PNG.bitblt(pane, strip, 0, 0, PANE.width, PANE.height, i * (PANE.width + GAP), 0);
  }
  writeFileSync(at('web', 'readme.png'), PNG.sync.write(strip));
}

function rendered(PNG, scale) {
  const folder = mkdtempSync(join(tmpdir(), 'istar-'));
  try {
    const png = join(folder, 'pane.png');
    const view = ['--center', `${CENTER.x},${CENTER.y}`, '--scale', String(scale)];
    run(cli, [
      'render',
      at('dist', 'gallery', 'map.istar'),
      '-o',
      png,
      ...view,
      '--size',
      `${PANE.width}x${PANE.height}`,
    ]);
    return PNG.sync.read(readFileSync(png));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The source's own pixels, each as a square. */
function magnified(PNG, source, scale) {
  const pane = new PNG(PANE);
  for (let j = 0; j < PANE.height; j++) {
    for (let i = 0; i < PANE.width; i++) {
      const x = Math.floor(CENTER.x + (i + 0.5 - PANE.width / 2) / scale);
      const y = Math.floor(CENTER.y + (j + 0.5 - PANE.height / 2) / scale);
      const from = (y * source.width + x) * 4;
      source.data.copy(pane.data, (j * PANE.width + i) * 4, from, from + 4);
    }
  }
  return pane;
}

/** Frames what is seen from so close by in the middle of a pane. */
function frame(pane, scale) {
  const away = (i, size) => Math.abs(i + 0.5 - size / 2) - size / scale / 2;
  for (let j = 0; j < PANE.height; j++) {
    for (let i = 0; i < PANE.width; i++) {
      const distance = Math.max(away(i, PANE.width), away(j, PANE.height));
      if (distance < 0 || distance >= FRAME) continue;
      const isWhite = distance >= 1 && distance < FRAME - 1;
      pane.data.fill(isWhite ? 255 : 30, (j * PANE.width + i) * 4, (j * PANE.width + i) * 4 + 3);
    }
  }
}

async function viewer() {
  const { event, launch, newPage, serve } = await import('../../tests/browser/harness.mjs');
  const server = await serve(cli);
  const browser = await launch();
  try {
    for (const colorScheme of ['light', 'dark']) {
      const { page } = await newPage(browser, { viewport: VIEWER, colorScheme, reducedMotion: 'reduce' });
      await page.route('**/figure.html', (route) =>
        route.fulfill({ contentType: 'text/html', body: figure() }),
      );
      await page.goto(`${server.url}figure.html#view=${VIEW.x},${VIEW.y},${VIEW.scale}`);
      await event(page, 'load');
      await page.mouse.move(VIEWER.width / 2, VIEWER.height / 2);
      await page.evaluate(async () => {
        const viewer = document.querySelector('istar-viewer');
        const { region } = window.seen.findLast(({ name }) => name === 'regionenter').detail;
        viewer.setStyle(region, { pattern: { motif: 'rising', color: '#fff8', spacing: 8 } });
        await viewer.painted;
      });
      // The overview has its own time.
      await page.waitForTimeout(3000);
      await page.screenshot({ path: at('web', `viewer-${colorScheme}.png`) });
    }
  } finally {
    await browser.close();
    server.stop();
  }
}

function figure() {
  const attributes = 'controls navigator scalebar interactive hash unit="°" unit-per-pixel="0.0621547"';
  return `<!doctype html><meta charset="utf-8"><meta name="color-scheme" content="light dark">
    <style>body { margin: 0 } istar-viewer { width: 100vw; height: 100vh }</style>
    <script type="module" src="istar.js"></script>
    <istar-viewer src="gallery/map.istar" alt="Map" backend="webgl2" ${attributes}></istar-viewer>`;
}

await main(import.meta.url, async () => {
  await build();
  await screenshots();
});
