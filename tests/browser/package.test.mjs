// The package: small enough, and importable where there is no page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { at } from '../../web/tasks/project.mjs';

test('script, module and shaders stay within web/size-limit.json', () => {
  const limit = JSON.parse(readFileSync(at('web', 'size-limit.json'), 'utf8')).gzip_bytes;
  const size = (name) => gzipSync(readFileSync(at('dist', name)), { level: 9 }).length;
  const [script, module] = ['istar.js', 'istar_bg.wasm'].map(size);
  // A browser fetches those of one back end: the larger counts.
  const shaders = Math.max(...['istar-webgl2.js', 'istar-webgpu.js'].map(size));
  const total = script + module + shaders;
  console.log(
    `istar.js ${script} + istar_bg.wasm ${module} + shaders ${shaders} = ${total} of ${limit} bytes gzipped`,
  );
  assert.ok(total <= limit, `${total} bytes gzipped, ${total - limit} too many`);
});

test('importing on a server touches no DOM', async () => {
  assert.equal(globalThis.HTMLElement, undefined);
  const { IStarViewer } = await import(at('dist', 'istar.js'));
  assert.equal(typeof IStarViewer, 'function');
});

test('no lock file names a registry', () => {
  for (const folder of [[], ['tests', 'package', 'fixtures'], ['tests', 'recipes']]) {
    assert.doesNotMatch(readFileSync(at(...folder, 'package-lock.json'), 'utf8'), /"resolved": "http/);
  }
});
