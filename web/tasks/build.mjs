// Builds everything into dist and target. A step whose inputs are unchanged is skipped.
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import {
  at,
  bin,
  cargoTarget,
  cli,
  main,
  nodeBin,
  RUST_TARGET,
  run,
  TaskError,
  WASM_BINDGEN,
  whenChanged,
  writeIfChanged,
} from './project.mjs';
import { shortenImports } from './shorten.mjs';

const PAGES = ['index.html', 'view.html', 'page.css', 'view.js'];

export async function build() {
  wasm();
  await bundle();
  pages();
  // After the pages: the command line tool carries them inside.
  nativeCli();
  gallery();
}

/** target/web: the module, its glue and their types, from wasm-bindgen; dist/istar_bg.wasm: the same, smaller. */
export function wasm() {
  const features = ['--no-default-features', '--features', 'gpu'];
  run('cargo', ['build', '--lib', '--profile', 'wasm', '--target', RUST_TARGET, ...features]);
  const compiled = join(cargoTarget, RUST_TARGET, 'wasm', 'istar.wasm');
  const bound = at('target', 'web', 'istar_bg.wasm');
  whenChanged(bound, [compiled, WASM_BINDGEN, at('web', 'tasks', 'shorten.mjs')], () => {
    // Without a default path: the bundle must name the module once, in engine.ts, where bundlers find it.
    const options = ['--target', 'web', '--omit-default-module-path', '--out-dir', at('target', 'web')];
    run(bin('wasm-bindgen'), [...options, compiled]);
    shortenImports(at('target', 'web', 'istar.js'), bound);
  });
  const small = at('dist', 'istar_bg.wasm');
  // No feature flags: with --all-features the result is refused by Chromium (invalid import kind).
  const options = ['-Oz', '--converge', '--strip-debug', '--strip-producers'];
  whenChanged(small, [bound, at('package-lock.json'), ...options], () =>
    run(nodeBin('wasm-opt'), [...options, bound, '-o', small]),
  );
}

export async function bundle() {
  const { build, transform } = await import('esbuild');
  const minifiedText = {
    name: 'minified-css-as-text',
    setup(on) {
      on.onLoad({ filter: /\.css$/ }, async ({ path }) => {
        const { code } = await transform(readFileSync(path, 'utf8'), { loader: 'css', minify: true });
        return { contents: code, loader: 'text' };
      });
    },
  };
  const { outputFiles } = await build({
    absWorkingDir: at(),
    entryPoints: ['web/src/element.ts'],
    tsconfig: 'web/tsconfig.json',
    bundle: true,
    minify: true,
    format: 'esm',
    target: 'es2022',
    write: false,
    plugins: [minifiedText],
  });
  const script = outputFiles[0].text;
  const names = script.split('istar_bg.wasm').length - 1;
  if (names !== 1) throw new TaskError(`dist/istar.js names istar_bg.wasm ${names} times, not once.`);
  writeIfChanged(at('dist', 'istar.js'), script);
}

export function pages() {
  for (const name of PAGES) writeIfChanged(at('dist', name), readFileSync(at('web', name)));
}

export function nativeCli() {
  run('cargo', ['build', '--release', '--bin', 'istar', '--features', 'cli']);
}

export function gallery() {
  for (const file of readdirSync(at('web', 'gallery')).filter((name) => name.endsWith('.png'))) {
    const picture = at('web', 'gallery', file);
    const encoded = at('dist', 'gallery', file.replace('.png', '.istar'));
    whenChanged(encoded, [picture, ...encoderSources()], () => {
      console.log(`Encoding ${file}`);
      run(cli, ['encode', picture, '-o', encoded]);
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

await main(import.meta.url, build);
