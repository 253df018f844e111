// What the tests of the package share: the packed tarball in a project of its own, and a server that knows policies.
import { execFileSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readFileSync } from 'node:fs';
import { basename, extname, join, normalize } from 'node:path';
import { at, whenChanged } from '../../web/tasks/project.mjs';

/** The project: what the fixtures build with, and the package. */
export const project = at('target', 'package');

function npm(folder, ...words) {
  mkdirSync(folder, { recursive: true });
  return execFileSync('npm', words, { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });
}

/** Packs the package as it would be published: what npm tells of it. */
export function packed(folder = project) {
  const said = JSON.parse(npm(folder, 'pack', at(), '--json', '--pack-destination', folder));
  // Newer npm answers by the package's name.
  return Array.isArray(said) ? said[0] : said.istar;
}

/** Makes a project of what package.json and its lock file in `from` say, and installs the packed package there; unless it is all there. */
export async function install(folder = project, from = at('tests', 'package', 'fixtures')) {
  const { filename } = packed(folder);
  const inputs = ['package.json', 'package-lock.json'].map((name) => join(from, name));
  for (const path of [...inputs, at('.npmrc')]) copyFileSync(path, join(folder, basename(path)));
  await whenChanged(join(folder, 'node_modules', '.package-lock.json'), inputs, () =>
    npm(folder, 'ci', '--silent'),
  );
  const tarball = join(folder, filename);
  await whenChanged(join(folder, 'node_modules', 'istar', 'package.json'), [tarball, ...inputs], () =>
    npm(folder, 'install', '--silent', '--no-save', '--prefer-offline', tarball),
  );
}

/** The code blocks under a heading of a page of ours: language, the name of the file that each is, if it is one, and text. */
function blocks(page, heading) {
  const found = [];
  let inSection = false;
  let block;
  for (const line of readFileSync(at(page), 'utf8').split('\n')) {
    const [, language, name] = line.match(/^```(\w+)(?: title="(.+)")?$/) ?? [];
    // Code may have lines that look like headings.
    if (line === '```') block = undefined;
    else if (block) block.text += `${line}\n`;
    else if (line.startsWith('#')) inSection = line.replace(/^#+ /, '') === heading;
    else if (language) {
      block = { language, name, text: '' };
      if (inSection) found.push(block);
    }
  }
  if (found.length === 0) throw new Error(`${page} has no code under “${heading}”.`);
  return found;
}

/** The code under a heading of a page of ours: the texts of its blocks in some language. */
export function code(page, heading, language) {
  return blocks(page, heading)
    .filter((block) => block.language === language)
    .map(({ text }) => text);
}

/** The files that blocks under a heading are: their texts by their names. */
export function filesOf(page, heading) {
  const named = blocks(page, heading).filter(({ name }) => name);
  return Object.fromEntries(named.map(({ name, text }) => [name, text]));
}

const TYPES = {
  '.html': 'text/html',
  '.css': 'text/css',
  '.js': 'text/javascript',
  '.json': 'application/json',
  '.png': 'image/png',
  '.svg': 'image/svg+xml',
  '.wasm': 'application/wasm',
};

/** Answers with files of a folder, whole; folders with their index.html. */
export function answerFrom(folder, request, response, headers = {}) {
  const name = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
  let path = join(folder, normalize(name));
  if (path.endsWith('/')) path = join(path, 'index.html');
  if (!existsSync(path)) {
    response.writeHead(404, headers).end();
    return;
  }
  response.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'application/octet-stream', ...headers });
  response.end(readFileSync(path));
}
