// Projects that install the package and build as README.md says, with its lines and nothing else.
import assert from 'node:assert/strict';
import { execSync, spawn } from 'node:child_process';
import { mkdirSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { createInterface } from 'node:readline';
import { after, before, test } from 'node:test';
import * as harness from '../browser/harness.mjs';
import { encodedQuilt } from '../browser/pictures.mjs';
import { answerFrom, code, install, project } from './installed.mjs';

const HEADING = 'From npm';
const [main] = code('README.md', HEADING, 'js');
const commands = code('README.md', HEADING, 'sh')[1].trim().split('\n');
const page = `<!doctype html>
<script type="module" src="main.js"></script>
<istar-viewer src="texels.istar" alt="Squares and discs" backend="webgl2"></istar-viewer>
<istar-viewer src="labels.istar" alt="The same, without loss" backend="webgl2"></istar-viewer>
`;

const projects = join(project, 'projects');
/** What the server's root is: the site of one of them. */
let served = projects;
const files = harness.serveFiles((request, response) => answerFrom(served, request, response));
let browser;
before(async () => {
  await install();
  rmSync(projects, { recursive: true, force: true });
  browser = await harness.launch();
});
after(() => browser?.close());

/** A project where these files are and these commands have run. */
function built(name, command, sources) {
  const folder = join(projects, name);
  for (const [path, text] of Object.entries({ 'package.json': '{ "type": "module" }', ...sources })) {
    mkdirSync(dirname(join(folder, path)), { recursive: true });
    writeFileSync(join(folder, path), text);
  }
  symlinkSync(join(project, 'node_modules'), join(folder, 'node_modules'));
  execSync(command, {
    cwd: folder,
    stdio: ['ignore', 'ignore', 'inherit'],
    env: { ...process.env, npm_config_offline: 'true' },
  });
  served = join(folder, 'dist');
  putPictures(served);
}

function putPictures(folder) {
  encodedQuilt(folder, 'texels', [64, 64], '--texel-size', '8');
  encodedQuilt(folder, 'labels', [64, 64], '--lossless');
}

/** Both of a page's figures are drawn: one with the module, and one with a worker and the encoder's module. */
async function draws(url = files.base) {
  const { page, uncaught, close } = await harness.newPage(browser);
  await page.goto(url);
  const settled = ({ name }) => name === 'load' || name === 'error';
  await page.waitForFunction(() => window.seen.filter(({ name }) => /load|error/.test(name)).length === 2);
  const seen = (await page.evaluate(() => window.seen)).filter(settled);
  assert.deepEqual(
    seen.map(({ name, detail }) => detail ?? name),
    ['load', 'load'],
  );
  assert.ok(harness.colors(await harness.shot(page)) > 1, 'the canvas is blank');
  assert.deepEqual(uncaught, []);
  await close();
}

for (const command of commands) {
  const [, name] = command.split(' ');
  test(command, async () => {
    // Vite takes the page along itself; others make a script for it.
    const place = name === 'vite' ? 'index.html' : 'dist/index.html';
    built(name, command, { 'main.js': main, [place]: page });
    await draws();
  });
}

test('npx vite, which serves while one works', async () => {
  // Not beside the others: it serves nothing that lies outside its own folder.
  writeFileSync(join(project, 'main.js'), main);
  writeFileSync(join(project, 'index.html'), page);
  mkdirSync(join(project, 'public'), { recursive: true });
  putPictures(join(project, 'public'));
  const vite = join(project, 'node_modules', '.bin', 'vite');
  const server = spawn(vite, ['--host', '127.0.0.1', '--port', '0', '--force'], {
    cwd: project,
    env: { ...process.env, NO_COLOR: '1' },
  });
  try {
    for await (const line of createInterface(server.stdout)) {
      const url = line.match(/http:\/\/127\.0\.0\.1:\d+\//)?.[0];
      if (!url) continue;
      await draws(url);
      return;
    }
    assert.fail('Vite ended without printing an address.');
  } finally {
    server.kill();
  }
});

test('npx esbuild with istar/inlined, and nothing beside the bundle', async () => {
  const sources = { 'main.js': "import 'istar/inlined';", 'dist/index.html': page };
  built('inlined', 'npx esbuild main.js --bundle --format=esm --outdir=dist', sources);
  await draws();
});
