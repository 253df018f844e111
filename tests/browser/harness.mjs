// What the browser tests share: the server under test, browsers, and pictures compared pixel by pixel.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { after, before } from 'node:test';
import { chromium, firefox } from 'playwright-core';
import { PNG } from 'pngjs';
import { at, checkedCli as cli } from '../../web/tasks/project.mjs';

export const BACKENDS = ['webgpu', 'webgl2'];

/** Starts `istar view dist` on a free port. */
export async function serve(tool = cli) {
  const server = spawn(tool, ['view', at('dist'), '--port', '0'], { stdio: ['ignore', 'pipe', 'inherit'] });
  for await (const line of createInterface(server.stdout)) {
    const url = line.match(/http:\/\/127\.0\.0\.1:\d+\//)?.[0];
    if (url) return { url, stop: () => server.kill() };
  }
  throw new Error('istar view ended without printing an address.');
}

export function launch(more = []) {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    headless: true,
    // Tests may run as root, for whom Chromium has no sandbox.
    chromiumSandbox: false,
    args: [
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      '--no-first-run',
      // All of these are needed to have WebGPU and WebGL2 at once without a graphics card.
      '--enable-unsafe-webgpu',
      '--enable-features=Vulkan',
      '--use-vulkan=swiftshader',
      '--use-angle=swiftshader',
      '--use-webgpu-adapter=swiftshader',
      '--enable-unsafe-swiftshader',
      ...more,
    ],
  });
}

const FIREFOX = [
  '/usr/bin/firefox-esr',
  '/usr/bin/firefox',
  '/Applications/Firefox.app/Contents/MacOS/firefox',
];
/** Where Firefox is, if anywhere; an empty variable leaves it out. */
export const firefoxPath = process.env.FIREFOX ?? FIREFOX.find((path) => existsSync(path));

/**
 * Firefox, or nothing where there is none. With Xvfb on the path it has a screen of its own, without which it has no WebGL2.
 * Playwright drives such a Firefox by WebDriver BiDi; from 1.65 on by commands that the ESR of 2026 does not know.
 */
export async function launchFirefox() {
  if (!firefoxPath) return undefined;
  const screen = await virtualScreen();
  const { WAYLAND_DISPLAY, ...env } = process.env;
  const launched = firefox.launch({
    channel: 'moz-firefox',
    executablePath: firefoxPath,
    headless: !screen,
    env: { ...env, ...(screen && { DISPLAY: screen.name }), LIBGL_ALWAYS_SOFTWARE: '1' },
    firefoxUserPrefs: {
      'dom.webgpu.enabled': true,
      'gfx.webgpu.ignore-blocklist': true,
      // Nothing coasts.
      'ui.prefersReducedMotion': 1,
    },
  });
  launched.catch(() => screen?.stop());
  const browser = await launched;
  browser.on('disconnected', () => screen?.stop());
  return browser;
}

/** A screen in memory, if there is a program for it. */
async function virtualScreen() {
  const server = spawn('Xvfb', ['-displayfd', '1', '-screen', '0', '1280x1024x24', '-nolisten', 'tcp'], {
    stdio: ['ignore', 'pipe', 'ignore'],
  });
  // Told by the end of its output too.
  server.on('error', () => {});
  for await (const number of createInterface(server.stdout)) {
    return { name: `:${number}`, stop: () => server.kill() };
  }
  return undefined;
}

/** The server of the pages and a browser, for all tests of a file: `server` and `browser` once these run. */
export function session(launchBrowser = launch) {
  const session = {};
  before(async () => {
    session.server = await serve();
    session.browser = await launchBrowser();
  });
  after(async () => {
    await session.browser?.close();
    session.server?.stop();
  });
  return session;
}

/** A server of files that tests make up, of another origin than the pages: `base` is its address once tests run. */
export function serveFiles(answer) {
  const files = {};
  const server = createServer((request, response) => {
    response.setHeader('access-control-allow-origin', '*');
    answer(request, response);
  });
  before(async () => {
    await new Promise((ready) => server.listen(0, '127.0.0.1', ready));
    files.base = `http://127.0.0.1:${server.address().port}/`;
  });
  after(() => {
    server.closeAllConnections();
    server.close();
  });
  return files;
}

/** The same with the files of a folder. */
export function serveFolder(folder) {
  return serveFiles((request, response) => {
    const path = join(folder, new URL(request.url, 'http://localhost').pathname);
    if (!existsSync(path)) response.writeHead(404).end();
    else response.end(readFileSync(path));
  });
}

/** A folder that is there as long as tests of a file run. */
export function temporaryFolder() {
  const folder = mkdtempSync(join(tmpdir(), 'istar-'));
  after(() => rmSync(folder, { recursive: true }));
  return folder;
}

/** A page that keeps a record: `uncaught` holds what nobody caught, and window.seen the figure's events in order. */
export async function newPage(browser, options = {}) {
  const context = await browser.newContext({ viewport: { width: 480, height: 360 }, ...options });
  const page = await context.newPage();
  const uncaught = [];
  page.on('pageerror', (error) => uncaught.push(String(error)));
  await page.addInitScript(() => {
    window.seen = [];
    const names = ['load', 'progress', 'error', 'viewchange', 'regionenter', 'regionleave', 'regionclick'];
    // On the document and capturing: these events do not bubble, and a load event never reaches the window.
    for (const name of names) {
      const note = (event) => {
        if (event.target?.localName === 'istar-viewer') window.seen.push({ name, detail: event.detail });
      };
      document.addEventListener(name, note, true);
    }
  });
  return { page, uncaught, close: () => context.close() };
}

/**
 * Opens the full-window page and waits for the picture: at a place (`x,y,scale`) if one is given, since all of a large picture takes
 * software its time to draw.
 */
export async function openViewer(
  page,
  base,
  { src = 'gallery/map.istar', backend = 'webgl2', place = '' } = {},
) {
  await page.goto(`${base}view.html?backend=${backend}&src=${encodeURIComponent(src)}#view=${place}`);
  await event(page, 'load');
}

/** Waits for an event of that name and returns its detail. */
export async function event(page, name) {
  const found = await page.waitForFunction(
    (wanted) => window.seen.find((seen) => seen.name === wanted),
    name,
  );
  return (await found.jsonValue()).detail;
}

/** The place the painted view shows, from the last viewchange event. */
export function place(page) {
  return page.evaluate(async () => {
    await document.querySelector('istar-viewer').painted;
    return window.seen.findLast((seen) => seen.name === 'viewchange').detail;
  });
}

/** The source place of the boundary nearest to the view's middle on its middle row. */
export async function boundaryInSight(page) {
  const { x, y, scale } = await place(page);
  const offset = await page.evaluate(() => {
    const viewer = document.querySelector('istar-viewer');
    const box = viewer.getBoundingClientRect();
    const [mx, my] = [box.left + box.width / 2, box.top + box.height / 2];
    const steps = [...Array(Math.floor(box.width) - 2).keys()].map((i) => i + 1 - box.width / 2);
    steps.sort((a, b) => Math.abs(a) - Math.abs(b));
    return steps.find((d) => viewer.pick(mx + d - 0.5, my) !== viewer.pick(mx + d + 0.5, my));
  });
  if (offset === undefined) throw new Error('no boundary in sight');
  return { x: x + offset / scale, y };
}

export async function zoomTo(page, x, y, scale) {
  await page.evaluate(
    async ([x, y, scale]) => {
      const viewer = document.querySelector('istar-viewer');
      viewer.zoomTo(x, y, scale);
      await viewer.painted;
    },
    [x, y, scale],
  );
}

/**
 * A mouse whose events carry times of its own, in milliseconds from its first: what depends on speed is then the same on a busy
 * machine.
 */
export async function timedMouse(page) {
  const session = await page.context().newCDPSession(page);
  const start = Date.now();
  const send =
    (type, buttons, clickCount) =>
    (x, y, at, modifiers = 0) =>
      session.send('Input.dispatchMouseEvent', {
        type,
        x,
        y,
        buttons,
        button: clickCount || buttons ? 'left' : 'none',
        clickCount,
        modifiers,
        timestamp: (start + at) / 1000,
      });
  return {
    press: send('mousePressed', 1, 1),
    drag: send('mouseMoved', 1, 0),
    release: send('mouseReleased', 0, 1),
  };
}

/** What the figure's own canvas holds. */
export async function shot(page) {
  const base64 = await page.evaluate(async () => {
    const blob = await document.querySelector('istar-viewer').toBlob();
    const reader = new FileReader();
    return new Promise((resolve) => {
      reader.onload = () => resolve(reader.result.split(',')[1]);
      reader.readAsDataURL(blob);
    });
  });
  return PNG.sync.read(Buffer.from(base64, 'base64'));
}

/** The same view drawn by the CPU in f64, with styles if there are any. */
export function oracle(file, { x, y, scale, rotation = 0, flipped = false }, { width, height }, styles) {
  const folder = mkdtempSync(join(tmpdir(), 'istar-'));
  try {
    const png = join(folder, 'oracle.png');
    const view = ['--center', `${x},${y}`, '--scale', String(scale), '--size', `${width}x${height}`];
    view.push('--rotate', String(rotation), ...(flipped ? ['--flip'] : []));
    if (styles) {
      writeFileSync(join(folder, 'styles.json'), JSON.stringify(styles));
      view.push('--style', join(folder, 'styles.json'));
    }
    execFileSync(cli, ['render', file, '-o', png, ...view], { stdio: ['ignore', 'ignore', 'inherit'] });
    return PNG.sync.read(readFileSync(png));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

export function colors(png) {
  const words = new Set();
  for (let i = 0; i < png.data.length; i += 4) words.add(png.data.readUInt32BE(i));
  return words.size;
}

/**
 * The GPU computes in f32 and the CPU in f64: where a boundary passes within rounding of a pixel's edge or three regions meet, a pixel
 * may fall to the other side. Elsewhere only the last step of rounding a colour differs.
 */
const CHANNEL = 2;
const SHARE = 0.001;

/** No more than a `share` of the pixels differs by more than `channel` in a channel, and there is something to see. */
export function assertAlike(label, actual, expected, { channel = CHANNEL, share = SHARE } = {}) {
  assert.ok(colors(expected) > 1, 'the oracle shows a single colour: the view is badly chosen');
  assert.ok(colors(actual) > 1, 'the canvas is blank');
  const found = difference(actual, expected, channel);
  if (found.share <= share) return;
  const kept = keepFailure(label, expected, found.picture, actual);
  assert.fail(`${label}: ${(found.share * 100).toFixed(3)} % of the pixels differ, see ${kept}`);
}

/**
 * The share of pixels that differ by more than `tolerance` in a channel, and a picture of where. Colours are weighted by their opacity, as
 * canvases keep them: what little is seen of one that is next to transparent is rounded too much to tell more.
 */
function difference(actual, expected, tolerance) {
  const { width, height } = expected;
  if (actual.width !== width || actual.height !== height) {
    throw new Error(`${actual.width}x${actual.height} pixels instead of ${width}x${height}`);
  }
  const picture = new PNG({ width, height });
  let count = 0;
  for (let i = 0; i < expected.data.length; i += 4) {
    const channel = ({ data }, c) => (c < 3 ? data[i + c] * (data[i + 3] / 255) : data[i + c]);
    let most = 0;
    for (let c = 0; c < 4; c++) most = Math.max(most, Math.abs(channel(actual, c) - channel(expected, c)));
    const differs = most > tolerance;
    if (differs) count++;
    picture.data.set(differs ? [255, 0, 0, 255] : [most * 40, most * 40, most * 40, 255], i);
  }
  return { share: count / (width * height), picture };
}

/** Keeps what was to be alike, and says where. */
export function keepUnlike(label, actual, expected) {
  return keepFailure(label, expected, difference(actual, expected, CHANNEL).picture, actual);
}

/** Puts expected | difference | actual into target/browser-failures, and says where. */
function keepFailure(name, expected, between, actual) {
  const { width, height } = expected;
  const strip = new PNG({ width: width * 3, height });
  for (const [i, png] of [expected, between, actual].entries()) {
    PNG.bitblt(png, strip, 0, 0, width, height, i * width, 0);
  }
  const folder = at('target', 'browser-failures');
  mkdirSync(folder, { recursive: true });
  const path = join(folder, `${name}.png`);
  writeFileSync(path, PNG.sync.write(strip));
  return path;
}

/** An SVG, drawn by the browser. */
export async function drawnSvg(page, text) {
  const base64 = await page.evaluate(async (text) => {
    const image = new Image();
    image.src = URL.createObjectURL(new Blob([text], { type: 'image/svg+xml' }));
    await image.decode();
    const canvas = Object.assign(document.createElement('canvas'), {
      width: image.width,
      height: image.height,
    });
    canvas.getContext('2d').drawImage(image, 0, 0);
    return canvas.toDataURL().split(',')[1];
  }, text);
  return PNG.sync.read(Buffer.from(base64, 'base64'));
}
