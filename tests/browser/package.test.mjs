// The package: small enough, and importable where there is no page.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { at } from '../../web/tasks/project.mjs';

test('script and module stay within web/size-limit.json', () => {
  const limit = JSON.parse(readFileSync(at('web', 'size-limit.json'), 'utf8')).gzip_bytes;
  const sizes = ['istar.js', 'istar_bg.wasm'].map(
    (name) => gzipSync(readFileSync(at('dist', name)), { level: 9 }).length,
  );
  const total = sizes[0] + sizes[1];
  console.log(`istar.js ${sizes[0]} + istar_bg.wasm ${sizes[1]} = ${total} of ${limit} bytes gzipped`);
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
