// Sites that are built as web/recipes.md says, looked at in Chromium. Slow to install, so that this is a step of its own.
import assert from 'node:assert/strict';
import { execSync } from 'node:child_process';
import { mkdirSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { delimiter, dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { at } from '../../web/tasks/project.mjs';
import * as harness from '../browser/harness.mjs';
import { encodedQuilt } from '../browser/pictures.mjs';
import { answerFrom, code, filesOf, install } from '../package/installed.mjs';

const PAGE = 'web/recipes.md';
const FIGURES = 10;
const project = at('target', 'recipes');
/** What the server's root is: one of the sites. */
let served;
const files = harness.serveFiles((request, response) => answerFrom(served, request, response));
const pictures = harness.temporaryFolder();
let browser;
before(async () => {
  await install(project, at('tests', 'recipes'));
  for (let i = 0; i < FIGURES; i++) encodedQuilt(pictures, `map${i}`, [64 + 8 * i, 64], '--texel-size', '8');
  browser = await harness.launch();
});
after(() => browser?.close());

/**
 * Builds a site: what the recipe says, with ten figures where it has one, and the other pages that any site has. Its commands run as
 * they are; what they install is there.
 */
function build(heading, { pages, figures, out }) {
  const folder = join(project, heading);
  rmSync(folder, { recursive: true, force: true });
  const ten = (line) =>
    [...Array(FIGURES).keys()].map((i) => line.replaceAll('figures/map.', `figures/map${i}.`));
  const sources = Object.entries(filesOf(PAGE, heading)).map(([name, text]) => [
    name,
    text
      // A line between, or Markdown takes them for one paragraph.
      .replace(/^.*<istar-viewer.*$/m, (line) => ten(line).join('\n\n'))
      .replaceAll('figures/map.', 'figures/map0.')
      // Where the site is: MkDocs loads those pages without loading all anew.
      .replaceAll('https://example.org/', files.base),
  ]);
  for (const [name, text] of [...Object.entries(pages), ...sources]) {
    mkdirSync(dirname(join(folder, name)), { recursive: true });
    writeFileSync(join(folder, name), text);
  }
  symlinkSync(join(project, 'node_modules'), join(folder, 'node_modules'));
  mkdirSync(dirname(join(folder, figures)), { recursive: true });
  execSync(`cp -r ${pictures} ${figures}`, { cwd: folder });
  const bins = [at('.tools', 'docs', 'bin'), join(project, 'node_modules', '.bin'), process.env.PATH];
  const [install, ...commands] = code(PAGE, heading, 'sh')[0].trim().split('\n');
  assert.equal(install, 'npm install istar');
  for (const command of commands) {
    execSync(command, { cwd: folder, stdio: 'inherit', env: { ...process.env, PATH: bins.join(delimiter) } });
  }
  served = join(folder, out);
}

/** A page that asks this machine alone, and says what nobody caught. */
async function open(path, options) {
  const opened = await harness.newPage(browser, options);
  const isOurs = (url) => url.href.startsWith(files.base);
  await opened.page.route(
    (url) => !isOurs(url),
    (route) => route.abort(),
  );
  await opened.page.goto(files.base + path);
  return opened;
}

/** All ten figures are drawn, wherever on the page they are. */
async function assertDrawn(page) {
  await page.waitForFunction((count) => document.querySelectorAll('istar-viewer').length === count, FIGURES);
  const colors = await page.evaluate(async () => {
    const found = [];
    await customElements.whenDefined('istar-viewer');
    for (const viewer of document.querySelectorAll('istar-viewer')) {
      viewer.scrollIntoView();
      const late = new Promise((_, reject) => setTimeout(reject, 20_000, `${viewer.outerHTML} is not drawn`));
      const image = await createImageBitmap(await Promise.race([viewer.toBlob(), late]));
      const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
      context.drawImage(image, 0, 0);
      const words = new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer);
      found.push(new Set(words).size);
    }
    return found;
  });
  assert.equal(colors.length, FIGURES);
  assert.ok(
    colors.every((count) => count > 1),
    `colours of the figures: ${colors}`,
  );
}

/** Whether the site is dark, and what figures put over their pictures. */
function darkness(page) {
  return page.evaluate(() => {
    const isDark = (color) => {
      const [r, g, b, a = 1] = color.match(/[\d.]+/g).map(Number);
      return a === 0 ? undefined : r + g + b < 384;
    };
    const background = (element) => isDark(getComputedStyle(element).backgroundColor);
    const status = document.querySelector('istar-viewer').shadowRoot.querySelector('.status');
    return {
      site: background(document.body) ?? background(document.documentElement) ?? false,
      figure: background(status),
    };
  });
}

const TEXT = 'Ten pictures of an archipelago.';
/** What a site's pages are beside that of the recipe, how to find that, and how its theme and its search are told. */
const SITES = {
  mdBook: {
    pages: {
      'book.toml': '[book]\ntitle = "Atlas"\n',
      'src/SUMMARY.md': '- [Home](index.md)\n- [Figures](figures.md)\n',
      'src/index.md': `# Home\n\n${TEXT} [All figures](figures.md)\n`,
    },
    figures: 'src/figures',
    out: 'book',
    page: 'figures.html',
    stored: (isDark) => ({ 'mdbook-theme': isDark ? 'navy' : 'light' }),
    search: async (page) => {
      await page.keyboard.press('s');
      await page.keyboard.type('archipelago');
      return page.locator('#mdbook-searchresults a').first();
    },
  },
  Sphinx: {
    pages: {
      'index.rst': `Home\n====\n\n${TEXT} :doc:\`All figures <figures>\`\n\n.. toctree::\n\n   figures\n`,
    },
    figures: '_static/figures',
    out: '_build',
    page: 'figures.html',
    stored: (isDark) => ({ theme: isDark ? 'dark' : 'light' }),
    search: async (page) => {
      await page.getByPlaceholder('Search').first().fill('archipelago');
      await page.keyboard.press('Enter');
      return page.locator('#search-results li a').first();
    },
  },
  'MkDocs Material': {
    pages: { 'docs/index.md': `# Home\n\n${TEXT} [All figures](figures.md)\n` },
    figures: 'docs/figures',
    out: 'site',
    page: 'figures/',
    isClientSide: true,
    stored: (isDark) => ({
      '/.__palette': JSON.stringify({
        index: isDark ? 1 : 0,
        color: { media: '', scheme: isDark ? 'slate' : 'default' },
      }),
    }),
    search: async (page) => {
      await page.keyboard.press('s');
      await page.keyboard.type('archipelago');
      return page.locator('.md-search-result__link').first();
    },
  },
  Docusaurus: {
    pages: {
      'docs/index.md': `---\nslug: /\n---\n\n# Home\n\n${TEXT} [All figures](figures.mdx)\n`,
      'package.json': '{}',
    },
    figures: 'static/figures',
    out: 'build',
    page: 'figures/',
    isClientSide: true,
    stored: (isDark) => ({ theme: isDark ? 'dark' : 'light' }),
    search: async (page) => {
      await page.getByPlaceholder('Search').first().click();
      await page.keyboard.type('archipelago');
      return page.locator('[class*=suggestion]').first();
    },
  },
  VitePress: {
    pages: {
      'index.md': `# Home\n\n${TEXT} [All figures](./figures.md)\n`,
      'package.json': '{ "type": "module" }',
    },
    figures: 'public/figures',
    out: '.vitepress/dist',
    page: 'figures.html',
    isClientSide: true,
    stored: (isDark) => ({ 'vitepress-theme-appearance': isDark ? 'dark' : 'light' }),
    search: async (page) => {
      await page.locator('.DocSearch-Button').first().click();
      // Its field is fetched first.
      await page.locator('.VPLocalSearchBox input').fill('archipelago');
      return page.locator('.VPLocalSearchBox .result').first();
    },
  },
};

for (const [heading, site] of Object.entries(SITES)) {
  test(`${heading}: builds, and shows images where scripts do not run`, async () => {
    build(heading, site);
    const { page, close } = await open(site.page, { javaScriptEnabled: false });
    const images = page.locator('istar-viewer img');
    assert.equal(await images.count(), FIGURES);
    for (const image of await images.all()) {
      await image.scrollIntoViewIfNeeded();
      const box = await image.boundingBox();
      assert.ok(box.width >= 64 && box.height >= 48, `${box.width} × ${box.height}`);
    }
    await close();
  });

  test(`${heading}: figures draw, also after going from page to page`, async () => {
    const { page, uncaught, close } = await open('');
    // Those that load no page anew know by then which they have.
    await page.waitForLoadState('networkidle');
    await page.evaluate(() => {
      window.isFirst = true;
    });
    const go = async (act) => {
      await act();
      await page.waitForURL(`${files.base}${site.page}`);
      await assertDrawn(page);
    };
    await go(() => page.getByRole('link', { name: 'All figures' }).click());
    await page.goBack();
    await page.getByRole('link', { name: 'All figures' }).waitFor();
    assert.equal(await page.locator('istar-viewer').count(), 0);
    await go(() => page.goForward());
    assert.equal(await page.evaluate(() => window.isFirst === true), site.isClientSide === true);
    assert.deepEqual(uncaught, []);
    await close();
  });

  test(`${heading}: figures are as dark as the site`, async () => {
    for (const colorScheme of ['light', 'dark']) {
      const { page, close } = await open('', { colorScheme });
      for (const isDark of [true, false]) {
        await page.evaluate((items) => {
          for (const [name, value] of Object.entries(items)) localStorage.setItem(name, value);
        }, site.stored(isDark));
        await page.goto(files.base + site.page);
        await page.locator('istar-viewer').first().scrollIntoViewIfNeeded();
        await harness.event(page, 'load');
        assert.deepEqual(await darkness(page), { site: isDark, figure: isDark }, `${colorScheme}, ${isDark}`);
      }
      await close();
    }
  });

  test(`${heading}: its search finds pages beside figures`, async () => {
    const { page, uncaught, close } = await open(site.page);
    await harness.event(page, 'load');
    const found = await site.search(page);
    await found.click();
    await page.getByText(TEXT).filter({ visible: true }).first().waitFor();
    assert.deepEqual(uncaught, []);
    await close();
  });
}
