// `npm run site`: our own pages, static, in target/site: a comparison, the guide, the API from the elements' types, and the file format.
import { copyFileSync, cpSync, mkdirSync, readdirSync, readFileSync, rmSync, statSync } from 'node:fs';
import { basename } from 'node:path';
import { Marked } from 'marked';
import { build } from './build.mjs';
import { packageFiles } from './package.mjs';
import { at, main, writeIfChanged } from './project.mjs';

const SITE = at('target', 'site');
const PAGES = [
  ['index.html', 'Compare'],
  ['guide.html', 'Guide'],
  ['documentation.html', 'In documentation'],
  ['api.html', 'API'],
  ['format.html', 'File format'],
  ['museum.html', 'Museum'],
];
/** Where the site has what our pages link to in the repository. */
const LINKS = {
  'web/museum.html': 'museum.html',
  'web/recipes.md': 'documentation.html',
  'src/container/SPEC.md': 'format.html',
  'web/readme.png': 'readme.png',
  'web/viewer-dark.png': 'viewer-dark.png',
  'web/viewer-light.png': 'viewer-light.png',
  'web/gallery/SOURCES.md': 'SOURCES.md',
};
const COPIED = [
  'LICENSE-MIT',
  'LICENSE-APACHE',
  'web/readme.png',
  'web/viewer-dark.png',
  'web/viewer-light.png',
  'web/gallery/SOURCES.md',
  'web/page.css',
];

/** The site from what is in dist. */
export function site() {
  rmSync(SITE, { recursive: true, force: true });
  mkdirSync(`${SITE}/istar`, { recursive: true });
  const scripts = readdirSync(at('dist')).filter((name) => /^istar.*\.(js|wasm)$/.test(name));
  for (const name of scripts) copyFileSync(at('dist', name), `${SITE}/istar/${name}`);
  for (const path of COPIED) copyFileSync(at(path), `${SITE}/${basename(path)}`);
  cpSync(at('web', 'gallery'), `${SITE}/gallery`, { recursive: true });
  cpSync(at('dist', 'gallery'), `${SITE}/gallery`, { recursive: true });
  for (const name of ['site.css', 'compare.js']) copyFileSync(at('web', 'site', name), `${SITE}/${name}`);
  museum();
  page('index.html', comparison());
  page('guide.html', markdown('README.md'));
  page('documentation.html', markdown('web/recipes.md'));
  page('api.html', api());
  page('format.html', markdown('src/container/SPEC.md'));
}

/** A page of its own kind: its scripts lie beside the pictures there, and the material with the others of the package. */
function museum() {
  copyFileSync(at('web', 'museum.html'), `${SITE}/museum.html`);
  for (const name of readdirSync(at('web', 'museum'))) {
    const text = readFileSync(at('web', 'museum', name), 'utf8');
    writeIfChanged(
      `${SITE}/museum/${name}`,
      text.replaceAll('../istar-material.js', '../istar/istar-material.js'),
    );
  }
}

function page(name, body) {
  const title = PAGES.find(([file]) => file === name)[1];
  const links = PAGES.map(
    ([file, text]) => `<a href="${file}"${file === name ? ' aria-current="page"' : ''}>${text}</a>`,
  );
  const html = `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>${title} – IStar</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="page.css">
<link rel="stylesheet" href="site.css">
<script type="module" src="istar/istar.js"></script>
</head>
<body>
<nav aria-label="Pages">${links.join('\n')}</nav>
<main>${body}</main>
</body>
</html>
`;
  writeIfChanged(`${SITE}/${name}`, html);
}

function markdown(path) {
  const marked = new Marked({
    walkTokens(token) {
      if (token.type === 'link' || token.type === 'image') token.href = LINKS[token.href] ?? token.href;
      if (token.type === 'html')
        token.text = token.text.replace(
          /((?:src|srcset)=")([^"]+)/g,
          (_, before, path) => before + (LINKS[path] ?? path),
        );
    },
  });
  return marked.parse(readFileSync(at(path), 'utf8'));
}

/** One picture, one view, two files: what lies left of the slider is IStar's, what lies right of it the other's. */
function comparison() {
  const bytes = (name) => statSync(`${SITE}/gallery/${name}`).size;
  const choice = (name, kind, checked) =>
    `<label><input type="radio" name="rival" value="${kind}" data-bytes="${bytes(`${name}.${kind}`)}"${checked ? ' checked' : ''}> ${kind.toUpperCase()}</label>`;
  const figure = (
    name,
    alt,
    width,
    kinds,
  ) => `<section class="compare" data-name="${name}" data-width="${width}">
<form>${kinds.map((kind, i) => choice(name, kind, i === 0)).join(' ')}</form>
<div class="both">
<istar-viewer src="gallery/${name}.istar" alt="${alt}" data-bytes="${bytes(`${name}.istar`)}"><img src="gallery/${name}.png" alt="${alt}"></istar-viewer>
<div class="rival" hidden><img alt=""></div>
</div>
<input type="range" min="0" max="100" value="50" aria-label="How much of the picture is IStar’s">
<output></output>
</section>`;
  return `<h1>IStar beside PNG and SVG</h1>
<p>The same picture in two files, left and right of the slider. Zoom in: wheel, pinch, double click or <kbd>+</kbd>.</p>
${figure('emblem', 'A letter A beside a shield with small lettering', 4096, ['png', 'svg'])}
${figure('map', 'The countries of the world', 5792, ['png'])}
<script type="module" src="compare.js"></script>`;
}

function api() {
  const { modules } = JSON.parse(readFileSync(at('dist', 'custom-elements.json'), 'utf8'));
  const marked = new Marked();
  const cell = (text = '') => `<td>${marked.parseInline(text)}</td>`;
  const table = (title, rows) =>
    rows.length === 0
      ? ''
      : `<h3>${title}</h3><div class="wide-table"><table>${rows.join('\n')}</table></div>`;
  const row = (name, type, description) =>
    `<tr><th scope="row"><code>${escaped(name)}</code></th><td><code>${escaped(type)}</code></td>${cell(description)}</tr>`;
  const typed = (list = []) =>
    list.map(({ name, type, description }) => row(name, type?.text ?? '', description));
  const method = ({ name, parameters = [], return: result, description }) => {
    const takes = parameters.map(({ name, type }) => `${name}: ${type.text}`).join(', ');
    return row(`${name}()`, `(${takes}) => ${result?.type?.text ?? 'void'}`, description);
  };
  const elements = modules.flatMap(({ declarations }) => declarations);
  const sections = elements.map(
    ({ tagName, description, attributes, events, members = [], slots, cssParts, cssProperties }) =>
      [
        `<h2><code>&lt;${tagName}&gt;</code></h2>${marked.parse(description)}`,
        table('Attributes', typed(attributes)),
        table('Properties', typed(members.filter(({ kind }) => kind === 'field'))),
        table('Methods', members.filter(({ kind }) => kind === 'method').map(method)),
        table('Events', typed(events)),
        table('Slots', typed(slots?.map((slot) => ({ ...slot, name: slot.name || '(none)' })))),
        table('Parts', typed(cssParts)),
        table('Custom properties', typed(cssProperties)),
      ].join('\n'),
  );
  const types = ['style', 'events'].map(
    (name) => `<pre><code>${escaped(readFileSync(at('dist', 'types', `${name}.d.ts`), 'utf8'))}</code></pre>`,
  );
  return `<h1>API</h1>${sections.join('\n')}<h2>Types</h2>${types.join('\n')}`;
}

function escaped(text) {
  return text.replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('>', '&gt;');
}

await main(import.meta.url, async () => {
  await build();
  await packageFiles();
  site();
  console.log('The site is in target/site.');
});
