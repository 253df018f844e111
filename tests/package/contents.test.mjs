// The tarball: what is in it, how large it is, and that its entries, types and list of elements are true.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { at } from '../../web/tasks/project.mjs';
import { install, packed, project } from './installed.mjs';

before(() => install());

const FILES = [
  'LICENSE-APACHE',
  'LICENSE-MIT',
  'README.md',
  'dist/custom-elements.json',
  'dist/element.js',
  'dist/index.js',
  'dist/istar-absorb.js',
  'dist/istar-controls.js',
  'dist/istar-cpu.js',
  'dist/istar-export.js',
  'dist/istar-fitter.js',
  'dist/istar-hash.js',
  'dist/istar-inlined.js',
  'dist/istar-labels.js',
  'dist/istar-legend.js',
  'dist/istar-material.js',
  'dist/istar-names.js',
  'dist/istar-offline.js',
  'dist/istar-painter.js',
  'dist/istar-walk.js',
  'dist/istar-webgl2.js',
  'dist/istar-webgpu.js',
  'dist/istar.classic.js',
  'dist/istar.js',
  'dist/istar_bg.wasm',
  'dist/istar_encoder_bg.wasm',
  'package.json',
];
/** The encoder is most of it, twice. */
const MOST_BYTES = 1_580_000;

test('the tarball holds these files and types, and is no larger than it should be', () => {
  const { files, size } = packed();
  const paths = files.map(({ path }) => path);
  assert.deepEqual(paths.filter((path) => !path.startsWith('dist/types/')).sort(), FILES);
  for (const path of paths) assert.match(path, /^(dist\/types\/\w+\.d\.ts|[^/]+|dist\/[^/]+)$/);
  console.log(`${size} bytes packed`);
  assert.ok(size <= MOST_BYTES, `${size} bytes, ${size - MOST_BYTES} too many`);
});

test('every entry is there, and none but those with side effects has any', () => {
  const { exports, sideEffects } = JSON.parse(readFileSync(at('package.json'), 'utf8'));
  const folder = join(project, 'node_modules', 'istar');
  for (const entry of Object.values(exports).flatMap((entry) => Object.values(Object(entry)))) {
    if (entry.startsWith?.('./')) assert.ok(existsSync(join(folder, entry)), entry);
  }
  assert.ok(!sideEffects.some((pattern) => pattern.endsWith('index.js')));
});

test('a server that renders pages may import every entry', () => {
  const script = `
    import { createElement } from 'react';
    import { renderToString } from 'react-dom/server';
    import { IStarViewer, settings } from 'istar';
    import { IStarViewer as Tag } from 'istar/element';
    import { IStarViewer as Inlined } from 'istar/inlined';
    import { IStarLegend } from 'istar/legend';
    import { IStarMaterial } from 'istar/material';
    import 'istar/classic';
    import elements from 'istar/custom-elements.json' with { type: 'json' };
    if (globalThis.document || Tag !== IStarViewer || !Inlined || !IStarLegend || !IStarMaterial.wgsl || !elements || !settings) throw 1;
    const image = createElement('img', { src: 'map.png', alt: 'A map' });
    console.log(renderToString(createElement('istar-viewer', { src: 'map.istar', interactive: true }, image)));
  `;
  const html = execFileSync('node', ['--no-warnings', '--input-type=module', '-e', script], {
    cwd: project,
    encoding: 'utf8',
  });
  assert.match(
    html,
    /<istar-viewer src="map\.istar" interactive="">.*<img src="map\.png" alt="A map"\/><\/istar-viewer>/,
  );
});

// Our own types are checked with those of the frameworks once, which takes a while.
const RESOLUTIONS = {
  bundler: ['--module', 'esnext'],
  nodenext: ['--module', 'nodenext', '--skipLibCheck'],
};
for (const [resolution, options] of Object.entries(RESOLUTIONS)) {
  test(`types for programs, React, Vue and Svelte (${resolution})`, () => {
    cpSync(at('tests', 'package', 'types'), join(project, 'types'), { recursive: true });
    const tsc = join(project, 'node_modules', '.bin', 'tsc');
    try {
      execFileSync(tsc, ['-p', 'types', '--moduleResolution', resolution, ...options], {
        cwd: project,
        encoding: 'utf8',
      });
    } catch ({ stdout }) {
      assert.fail(stdout);
    }
  });
}

test('the list of elements says what the types say', () => {
  const { modules } = JSON.parse(readFileSync(at('dist', 'custom-elements.json'), 'utf8'));
  const types = (name) => readFileSync(at('dist', 'types', `${name}.d.ts`), 'utf8');
  const keys = (name, of) => {
    const [, body] = types(name).match(new RegExp(`interface ${of} \\{([^}]*)\\}`));
    return [...body.matchAll(/^ {4}'?([\w-]+)'?\??:/gm)].map(([, key]) => key).sort();
  };
  const names = (list = []) => list.map(({ name }) => name).sort();
  const [viewer, legend] = modules.map(({ declarations }) => declarations[0]);
  assert.deepEqual(names(viewer.attributes), keys('attributes', 'ViewerAttributes'));
  assert.deepEqual(names(legend.attributes), keys('attributes', 'LegendAttributes'));
  assert.deepEqual(names(viewer.events), keys('events', 'ViewerEvents'));
  for (const thing of [viewer, legend].flatMap(({ attributes, events = [], cssProperties }) => [
    ...attributes,
    ...events,
    ...cssProperties,
  ])) {
    assert.ok(thing.description, `nothing is said of ${thing.name}`);
  }
});
