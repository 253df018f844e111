// Builds everything into dist and target. A step whose inputs are unchanged is skipped.
import { readdirSync, readFileSync } from 'node:fs';
import { homedir } from 'node:os';
import { join } from 'node:path';
import { packageFiles } from './package.mjs';
import {
  at,
  bin,
  cargoTarget,
  checkedCli,
  cli,
  main,
  nodeBin,
  output,
  RUST_TARGET,
  run,
  runBeside,
  TaskError,
  WASM_BINDGEN,
  whenChanged,
  writeIfChanged,
} from './project.mjs';
import { bundled, VIEWER_FETCHES } from './script.mjs';
import { shortenNames } from './shorten.mjs';

const PAGES = ['index.html', 'view.html', 'museum.html', 'page.css', 'view.js', 'istar-offline.js'];

export async function build() {
  await buildWith(cli, ['--release', '--features', 'cli']);
}

/** The same with the tool that tests use, which shares all it is built from with them. */
export async function buildForTests() {
  await buildWith(checkedCli, ['--features', 'cli,gpu']);
  await packageFiles();
}

async function buildWith(tool, options) {
  // Beside the modules, of which the larger keeps one core busy for long: what the tool is made of.
  await Promise.all([wasmModules(), runBeside('cargo', ['build', '--lib', ...options])]);
  await bundle();
  pages();
  // After the pages: the command line tool carries them inside.
  run('cargo', ['build', '--bin', 'istar', ...options]);
  await gallery(tool);
}

/**
 * Rust puts the stack first: the lowest bytes are its far end, and no address is computed from there. What is small enough is put
 * where it is called, and nothing larger: the same code twice is packed less well than a call. A sum that is written twice is not:
 * what keeps it in a local, and what splits data where it is zero, are left out.
 */
const SMALL = [
  '--rse',
  '--code-folding',
  '--gufa-optimizing',
  '--merge-similar-functions',
  '--coalesce-locals-learning',
  '-Oz',
  '--converge',
  '--low-memory-unused',
  '--always-inline-max-function-size=7',
  '--flexible-inline-max-function-size=7',
  '--one-caller-inline-max-function-size=25',
  '--reorder-locals',
  '--skip-pass=local-cse',
  '--skip-pass=memory-packing',
];

/** Both modules, side by side: most of the time each keeps one core busy. */
export async function wasmModules() {
  await Promise.all([wasm(), encoderWasm()]);
}

/** target/web: the viewer's module, its glue and their types, from wasm-bindgen; dist/istar_bg.wasm: the same, smaller. */
function wasm() {
  return wasmModule({ name: 'istar', profile: 'wasm', features: 'gpu', optimize: SMALL });
}

/** The same for what fits texels to labels: a viewer fetches it for files that hold these. */
function encoderWasm() {
  return wasmModule({
    name: 'istar_encoder',
    profile: 'wasm-encoder',
    features: 'encode,pack',
    optimize: ['-O3'],
  });
}

async function wasmModule({ name, profile, features, optimize }) {
  const target = ['--target', RUST_TARGET, '--no-default-features', '--features', features];
  // Where a panic was is said by file: not by where this machine keeps it.
  const home = process.env.CARGO_HOME ?? join(homedir(), '.cargo');
  const flags = JSON.stringify([`--remap-path-prefix=${home}/registry/src/=`]);
  const config = ['--config', `target.${RUST_TARGET}.rustflags=${flags}`];
  await runBeside('cargo', ['build', '--lib', '--profile', profile, ...target, ...config]);
  if (features === 'gpu') shaders(['build', '--lib', '--profile', profile, ...target, ...config]);
  const compiled = join(cargoTarget, RUST_TARGET, profile, 'istar.wasm');
  const bound = at('target', 'web', `${name}_bg.wasm`);
  await whenChanged(bound, [compiled, WASM_BINDGEN, at('web', 'tasks', 'shorten.mjs')], () => {
    // Without a default path: a bundle must name its module once, where bundlers find it.
    const options = ['--target', 'web', '--omit-default-module-path', '--encode-into', 'always'];
    options.push('--out-dir', at('target', 'web'));
    run(bin('wasm-bindgen'), [...options, '--out-name', name, compiled]);
    shortenNames(at('target', 'web', `${name}.js`), bound);
  });
  const small = at('dist', `${name}_bg.wasm`);
  // No feature flags: with --all-features the result is refused by Chromium (invalid import kind).
  // The list of features in the module is for such tools alone: the last of them takes it away.
  const options = [...optimize, '--strip-debug', '--strip-producers', '--strip-target-features'];
  await whenChanged(small, [bound, at('package-lock.json'), ...options], () =>
    runBeside(nodeBin('wasm-opt'), [...options, bound, '-o', small]),
  );
}

/** target/web/picture.js, material.js and their types: the shaders, as the crate's build script has written them in such a build. */
function shaders(build) {
  const messages = output('cargo', [...build, '--quiet', '--message-format=json']) ?? '';
  const parsed = messages
    .split('\n')
    .filter(Boolean)
    .map((line) => JSON.parse(line));
  const own = ({ reason, package_id }) =>
    reason === 'build-script-executed' && /\bistar[@#]/.test(package_id);
  const folder = parsed.find(own)?.out_dir;
  if (!folder) throw new TaskError('Cargo does not say where it has put the shaders.');
  writeIfChanged(at('target', 'web', 'picture.js'), readFileSync(join(folder, 'picture.js')));
  const types = 'export const wgsl: string;\nexport const glsl: [string, string][];\n';
  writeIfChanged(at('target', 'web', 'picture.d.ts'), types);
  writeIfChanged(at('target', 'web', 'material.js'), readFileSync(join(folder, 'material.js')));
  writeIfChanged(
    at('target', 'web', 'material.d.ts'),
    'export const wgsl: string;\nexport const glsl: string;\n',
  );
}

export async function bundle() {
  await bundled('web/src/define.ts', 'istar.js', VIEWER_FETCHES);
  await bundled('web/src/fitting.ts', 'istar-labels.js', ['istar-fitter.js']);
  await bundled('web/src/fitter.ts', 'istar-fitter.js', ['istar_encoder_bg.wasm']);
  await bundled('web/src/absorb.ts', 'istar-absorb.js', ['istar_encoder_bg.wasm']);
  await bundled('web/src/names.ts', 'istar-names.js', []);
  await bundled('web/src/export.ts', 'istar-export.js', ['istar-labels.js']);
  for (const name of ['hash', 'walk', 'controls', 'webgl2', 'webgpu'])
    await bundled(`web/src/${name}.ts`, `istar-${name}.js`, []);
  await bundled('web/src/legend.ts', 'istar-legend.js', ['istar-hash.js']);
  await bundled('web/src/material.ts', 'istar-material.js', ['istar_encoder_bg.wasm']);
  await bundled('web/src/cpu.ts', 'istar-cpu.js', ['istar-painter.js']);
  await bundled('web/src/painter.ts', 'istar-painter.js', ['istar_encoder_bg.wasm']);
}

export function pages() {
  const museum = readdirSync(at('web', 'museum')).map((name) => `museum/${name}`);
  for (const name of [...PAGES, ...museum]) writeIfChanged(at('dist', name), readFileSync(at('web', name)));
}

async function gallery(tool) {
  for (const file of readdirSync(at('web', 'gallery')).filter((name) => name.endsWith('.png'))) {
    const picture = at('web', 'gallery', file);
    const encoded = at('dist', 'gallery', file.replace('.png', '.istar'));
    await whenChanged(encoded, [picture, ...encoderSources()], () => {
      console.log(`Encoding ${file}`);
      run(tool, ['encode', picture, '-o', encoded]);
    });
  }
}

/** The tool itself would do, but it carries the pages inside, and so changes with each of them. */
function encoderSources() {
  const drawing = at('src', 'gpu');
  const sources = readdirSync(at('src'), { recursive: true })
    .map((name) => at('src', name))
    .filter((path) => path.endsWith('.rs') && !path.startsWith(drawing) && path !== at('src', 'wasm.rs'));
  return [...sources.sort(), at('Cargo.toml'), at('Cargo.lock')];
}

await main(import.meta.url, async () => {
  await build();
  await packageFiles();
});
