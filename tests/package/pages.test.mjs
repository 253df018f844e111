// Ways to load the viewer on a page, from the package as it is installed, under a strict content security policy.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import * as harness from '../browser/harness.mjs';
import { encodedQuilt } from '../browser/pictures.mjs';
import { answerFrom, install, project } from './installed.mjs';

const site = harness.temporaryFolder();
const requests = [];
let policy = '';
const files = harness.serveFiles((request, response) => {
  requests.push(request.url.split('/').at(-1));
  answerFrom(site, request, response, { 'content-security-policy': policy });
});
let browser;
before(async () => {
  await install();
  const dist = join(project, 'node_modules', 'istar', 'dist');
  mkdirSync(join(site, 'js'));
  const needed = readdirSync(dist).filter((name) => name !== 'types');
  for (const name of needed) copyFileSync(join(dist, name), join(site, 'js', name));
  encodedQuilt(site, 'texels', [64, 64], '--texel-size', '8');
  encodedQuilt(site, 'labels', [64, 64], '--lossless');
  browser = await harness.launch();
});
after(() => browser?.close());

const STRICT = [
  "default-src 'none'",
  "script-src 'self' 'wasm-unsafe-eval'",
  "connect-src 'self'",
  "worker-src 'self'",
].join('; ');

/** A page with these scripts, and a figure for each attribute list; what it asked for, once all figures are there. */
async function shown(name, head, figures, csp = STRICT) {
  policy = csp;
  requests.length = 0;
  const tags = figures.map((attributes) => `<istar-viewer alt="A quilt" ${attributes}></istar-viewer>`);
  // Without a head of its own: the script comes first, as on most pages.
  writeFileSync(join(site, `${name}.html`), `<!doctype html>${head}${tags.join('')}`);
  const { page, uncaught, close } = await harness.newPage(browser);
  await page.addInitScript(() => {
    window.refused = [];
    document.addEventListener('securitypolicyviolation', (event) => {
      window.refused.push(`${event.violatedDirective}: ${event.blockedURI} ${event.sample}`);
    });
  });
  await page.goto(`${files.base}${name}.html`);
  const all = () =>
    page.evaluate(() => window.seen.filter(({ name }) => name === 'load' || name === 'error'));
  await page.waitForFunction(
    () =>
      window.seen.filter(({ name }) => name === 'load' || name === 'error').length ===
      document.querySelectorAll('istar-viewer').length,
  );
  for (const { name, detail } of await all()) assert.equal(name, 'load', detail?.message);
  assert.ok(harness.colors(await harness.shot(page)) > 1, 'the canvas is blank');
  assert.deepEqual(await page.evaluate(() => window.refused), []);
  assert.deepEqual(uncaught, []);
  return { page, close };
}

// One of texels on a GPU, one of labels, which a worker draws, and one that another worker paints.
const FIGURES = [
  'src="texels.istar" backend="webgl2"',
  'src="labels.istar" backend="webgl2"',
  'src="texels.istar" backend="cpu"',
];

test('a module script, with what it fetches beside it', async () => {
  const { close } = await shown('module', '<script type="module" src="js/istar.js"></script>', FIGURES);
  for (const name of ['istar_bg.wasm', 'istar-fitter.js', 'istar-painter.js']) {
    assert.equal(requests.filter((asked) => asked === name).length, 1, name);
  }
  await close();
});

test('a classic script finds the same beside it', async () => {
  const { page, close } = await shown('classic', '<script src="js/istar.classic.js"></script>', FIGURES);
  assert.ok(requests.includes('istar_bg.wasm') && requests.includes('istar-painter.js'));
  assert.ok(await page.evaluate(() => customElements.get('istar-viewer') === window.istar.IStarViewer));
  await close();
});

test('the inlined script fetches pictures alone', async () => {
  // Its workers are inside too.
  const csp = STRICT.replace("worker-src 'self'", 'worker-src blob:');
  const { close } = await shown(
    'inlined',
    '<script type="module" src="js/istar-inlined.js"></script>',
    FIGURES,
    csp,
  );
  const own = requests.filter((name) => name !== 'favicon.ico' && !name.endsWith('.istar'));
  assert.deepEqual(own, ['inlined.html', 'istar-inlined.js']);
  await close();
});

test('a program may keep the module elsewhere', async () => {
  copyFileSync(join(site, 'js', 'istar_bg.wasm'), join(site, 'moved.wasm'));
  writeFileSync(
    join(site, 'js', 'program.js'),
    `import { IStarViewer, settings } from './index.js';
    settings.wasmUrl = new URL('../moved.wasm', import.meta.url);
    customElements.define('istar-viewer', IStarViewer);`,
  );
  const head = '<script type="module" src="js/program.js"></script>';
  const { close } = await shown('program', head, FIGURES.slice(0, 1));
  assert.ok(requests.includes('moved.wasm') && !requests.includes('istar_bg.wasm'));
  await close();
});

test('what a page said before the script came counts', async () => {
  // As MkDocs Material does with instant navigation: it sets what it has read, which was nothing.
  const before = `<istar-viewer alt="Set" id="set" backend="webgl2"></istar-viewer>
    <istar-viewer alt="Lost" id="lost" src="texels.istar" backend="webgl2"></istar-viewer>
    <script>
      set.src = 'texels.istar';
      set.styles = { all: { opacity: 0.5 } };
      lost.src = lost.src;
    </script>`;
  const script = '<script type="module" src="js/istar.js"></script>';
  const { page, close } = await shown('early', before + script, ['src="texels.istar" backend="webgl2"'], '');
  const styles = await page.evaluate(() =>
    [...document.querySelectorAll('istar-viewer')].map((v) => v.styles.all),
  );
  assert.deepEqual(styles, [{ opacity: 0.5 }, {}, {}]);
  await close();
});

test('figures are light or dark as the page around them is', async () => {
  const figures = ['light', 'dark'].map((scheme) => `src="texels.istar" style="color-scheme: ${scheme}"`);
  const script = '<script type="module" src="js/istar.js"></script>';
  const { page, close } = await shown('schemes', script, figures, '');
  const inks = await page.evaluate(() =>
    [...document.querySelectorAll('istar-viewer')].map((viewer) => getComputedStyle(viewer).color),
  );
  assert.deepEqual(inks, ['rgb(27, 29, 34)', 'rgb(236, 238, 242)']);
  await close();
});

test('the list of elements is true', async () => {
  const { page, close } = await shown(
    'elements',
    '<script type="module" src="js/istar.js"></script>',
    FIGURES.slice(0, 1),
    '',
  );
  const found = await page.evaluate(async () => {
    const { modules } = await (await fetch('js/custom-elements.json')).json();
    const { attributes, members, cssParts = [], cssProperties, slots } = modules[0].declarations[0];
    const viewer = document.querySelector('istar-viewer');
    const names = (list) => list.map(({ name }) => name);
    const Viewer = viewer.constructor;
    const inner = /^(constructor|prototype|length|name|observedAttributes|\w+Callback)$/;
    const own = [Viewer, Viewer.prototype]
      .flatMap(Object.getOwnPropertyNames)
      .filter((name) => !inner.test(name));
    const parts = [...viewer.shadowRoot.querySelectorAll('[part]')].flatMap((element) => [...element.part]);
    const style = getComputedStyle(viewer);
    return {
      members: [own.sort(), names(members).sort()],
      unsaidAttributes: Viewer.observedAttributes.filter((name) => !names(attributes).includes(name)),
      unsaidParts: parts.filter((part) => !names(cssParts).includes(part)),
      missingProperties: names(cssProperties).filter((name) => style.getPropertyValue(name) === ''),
      slots: [
        [...viewer.shadowRoot.querySelectorAll('slot')].map(({ name }) => name).sort(),
        names(slots).sort(),
      ],
    };
  });
  assert.deepEqual(...found.members);
  assert.deepEqual(...found.slots);
  assert.deepEqual(found.unsaidAttributes, []);
  assert.deepEqual(found.unsaidParts, []);
  assert.deepEqual(found.missingProperties, []);
  await close();
});
