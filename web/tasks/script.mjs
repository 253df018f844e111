// Scripts of dist from their TypeScript, by esbuild.
import { readFileSync } from 'node:fs';
import { at, TaskError, writeIfChanged } from './project.mjs';

/** Modules of web/src that are files of their own in dist, fetched only when used. */
const FETCHED = {
  './absorb.js': './istar-absorb.js',
  './controls.js': './istar-controls.js',
  './cpu.js': './istar-cpu.js',
  './export.js': './istar-export.js',
  './fitting.js': './istar-labels.js',
  './hash.js': './istar-hash.js',
  './names.js': './istar-names.js',
  './walk.js': './istar-walk.js',
  './webgl2.js': './istar-webgl2.js',
  './webgpu.js': './istar-webgpu.js',
};

/** What the viewer's script fetches, some of it only when used. */
export const VIEWER_FETCHES = ['istar_bg.wasm', ...Object.values(FETCHED).map((path) => path.slice(2))];

/** A script in dist, which names each of the files that it fetches once. */
export async function bundled(entry, name, fetched, options) {
  const text = await script(entry, options);
  for (const file of fetched) {
    const names = text.split(file).length - 1;
    if (names !== 1) throw new TaskError(`dist/${name} names ${file} ${names} times, not once.`);
  }
  writeIfChanged(at('dist', name), text);
}

/**
 * The text of a script. `outside` says which modules stay files of their own, `instead` which other files stand in for modules, and
 * `inside` what imports that begin with `inside:` are; all else are esbuild's options.
 */
export async function script(entry, { outside = FETCHED, instead = {}, inside = {}, ...options } = {}) {
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
  const modules = {
    name: 'modules-elsewhere',
    setup(on) {
      on.onResolve({ filter: /^\.\/\w+\.js$/ }, ({ path }) => {
        if (path in outside) return { path: outside[path], external: true };
        return path in instead ? { path: at(instead[path]) } : undefined;
      });
      on.onResolve({ filter: /^inside:/ }, ({ path }) => ({ path: path.slice(7), namespace: 'inside' }));
      on.onLoad({ filter: /.*/, namespace: 'inside' }, ({ path }) => ({
        contents: inside[path],
        loader: 'text',
      }));
    },
  };
  const { outputFiles } = await build({
    absWorkingDir: at(),
    entryPoints: [entry],
    tsconfig: 'web/tsconfig.json',
    bundle: true,
    minify: true,
    // The glue's own, at every call of the module.
    mangleProps: /^__(wbg_ptr|wrap|destroy_into_raw)$/,
    format: 'esm',
    target: 'es2022',
    write: false,
    plugins: [minifiedText, modules],
    ...options,
  });
  return outputFiles[0].text;
}
