// The view and the whole picture as lines and areas: what `toBlob` makes in a worker.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import { at, checkedCli as cli } from '../../web/tasks/project.mjs';
import * as harness from './harness.mjs';

const SIZE = { width: 480, height: 360 };
/** A renderer's edges are blended otherwise than ours. */
const CHANNEL = 40;
const STYLES = { regions: { 1: { color: '#123456' }, 2: { opacity: 0.5 } } };

const run = harness.session();
const folder = harness.temporaryFolder();
const crop = at('tests', 'fixtures', 'crop.png');
writeFileSync(join(folder, 'names.csv'), '#ad8ae6,Elsewhere\n');
for (const [name, ...options] of [
  ['texels', '--names', join(folder, 'names.csv')],
  ['labels', '--lossless', '--names', join(folder, 'names.csv')],
  ['tiles', '--tile-size', '64', '--texel-size', '4'],
]) {
  execFileSync(cli, ['encode', crop, '-o', join(folder, `${name}.istar`), ...options], { stdio: 'ignore' });
}

/** What `toBlob` makes, as text, and its type. */
function made(page, options) {
  return page.evaluate(async (options) => {
    const blob = await document.querySelector('istar-viewer').toBlob(options);
    return { type: blob.type, text: await blob.text() };
  }, options);
}

for (const name of ['texels', 'labels', 'tiles']) {
  test(`${name}: lines show what is drawn`, async () => {
    const { page, uncaught, close } = await harness.newPage(run.browser, {
      viewport: SIZE,
      reducedMotion: 'reduce',
    });
    const asked = [];
    page.on('request', (request) => asked.push(request.url().split('/').at(-1)));
    const path = join(folder, `${name}.istar`);
    await page.route('**/made/*', (route) => route.fulfill({ body: readFileSync(path) }));
    await harness.openViewer(page, run.server.url, { src: `made/${name}.istar` });
    await harness.zoomTo(page, 121.3, 90.2, 5);
    assert.ok(!asked.includes('istar-export.js'), 'what is not asked for is not fetched');

    const view = await made(page, { type: 'image/svg+xml' });
    assert.equal(view.type, 'image/svg+xml');
    assert.match(view.text, /^<svg [^>]*viewBox="0 0 480 360"/);
    const place = { x: 121.3, y: 90.2, scale: 5 };
    const alike = (actual, label, styles) =>
      harness.assertAlike(label, actual, harness.oracle(path, place, SIZE, styles), { channel: CHANNEL });
    alike(await harness.drawnSvg(page, view.text), `lines-${name}`);

    await page.evaluate((styles) => {
      document.querySelector('istar-viewer').styles = styles;
    }, STYLES);
    const styled = await made(page, { type: 'image/svg+xml' });
    alike(await harness.drawnSvg(page, styled.text), `lines-styled-${name}`, STYLES);

    const whole = await made(page, { type: 'image/svg+xml', whole: true });
    assert.match(whole.text, /^<svg [^>]*viewBox="0 0 256 192"/);
    if (name !== 'tiles') assert.match(whole.text, /<title>Elsewhere<\/title>/);
    assert.match((await made(page, { type: 'application/pdf', width: 100 })).text, /^%PDF-1.4\n/);
    const eps = await made(page, { type: 'application/postscript', whole: true, width: 128 });
    assert.match(eps.text, /^%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 96 72\n/);
    const fault = await page.evaluate(() =>
      document.querySelector('istar-viewer').toBlob({ type: 'application/none' }).catch(String),
    );
    assert.match(fault, /no way to write application\/none/);
    assert.deepEqual(uncaught, []);
    await close();
  });
}
