// What the tests of the package share: the packed tarball in a project of its own, and a server that knows policies.
import { execFileSync } from 'node:child_process';
import { copyFileSync, existsSync, mkdirSync, readFileSync } from 'node:fs';
import { extname, join, normalize } from 'node:path';
import { at, whenChanged } from '../../web/tasks/project.mjs';

/** The project: what the fixtures build with, and the package. */
export const project = at('target', 'package');

const npm = (...words) =>
  execFileSync('npm', words, { cwd: project, encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });

/** Packs the package as it would be published: what npm tells of it. */
export function packed() {
  mkdirSync(project, { recursive: true });
  const words = ['pack', at(), '--json', '--pack-destination', project];
  const said = JSON.parse(npm(...words));
  // Newer npm answers by the package's name.
  return Array.isArray(said) ? said[0] : said.istar;
}

/** Makes the project, and installs the packed package there, unless it is all there. */
export function install() {
  const { filename } = packed();
  const inputs = ['package.json', 'package-lock.json'].map((name) =>
    at('tests', 'package', 'fixtures', name),
  );
  for (const path of [...inputs, at('.npmrc')]) copyFileSync(path, join(project, path.split('/').at(-1)));
  whenChanged(join(project, 'node_modules', '.package-lock.json'), inputs, () => npm('ci', '--silent'));
  const tarball = join(project, filename);
  whenChanged(join(project, 'node_modules', 'istar', 'package.json'), [tarball, ...inputs], () =>
    npm('install', '--silent', '--no-save', '--prefer-offline', tarball),
  );
}

/** The code under a heading of a page of ours: the texts of its blocks in some language. */
export function code(page, heading, language) {
  const text = readFileSync(at(page), 'utf8');
  const sections = text.split(/^#+ /m).slice(1);
  const section = sections.find((section) => section.startsWith(`${heading}\n`));
  if (!section) throw new Error(`${page} has no heading “${heading}”.`);
  return [...section.matchAll(/^```(\w+)\n([\s\S]*?)^```/gm)]
    .filter(([, found]) => found === language)
    .map(([, , block]) => block);
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
