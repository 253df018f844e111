// `npm run bench`: what pictures cost, in tables; tests/bench/main.rs says which there are, and rd.py (`rd`) and
// frames.mjs (`frames`) beside it are two more. Words in the arguments choose some.
import { existsSync, mkdirSync, rmSync } from 'node:fs';
import { measureWeb } from '../../tests/bench/open.mjs';
import { build, wasmModules } from './build.mjs';
import { at, cli, main, output, run, TaskError, VTRACER } from './project.mjs';
import { cargoTool, setup } from './setup.mjs';

/** What `rd` compares with, from the Python package index. */
const CODECS = [
  'brotli==1.2.1',
  'numpy==2.4.6',
  'pillow==13.0.0',
  'pillow-jxl-plugin==1.3.8',
  'resvg_py==0.5.0',
  'vtracer==0.6.15',
];
const PICTURES = ['emblem', 'map'];

await main(import.meta.url, async () => {
  const words = process.argv.slice(2);
  const moves = words.length === 0 || words.includes('frames');
  if (moves && words.length > 0) await frames();
  const others = words.filter((word) => word !== 'rd' && word !== 'frames');
  // All words that are pictures may belong to it.
  if (words.includes('rd')) rates(others.filter((word) => PICTURES.includes(word)));
  if (others.length < words.length && others.every((word) => PICTURES.includes(word))) return;
  // Not in the set-up, because only one table needs it.
  if (others.length === 0 || others.includes('rivals')) {
    await cargoTool('vtracer', 'vtracer', VTRACER, ['--locked']);
    rmSync(at('.tools', 'build'), { recursive: true, force: true });
  }
  const opens = others.length === 0 || others.includes('open');
  const folder = at('target', 'bench', 'open');
  mkdirSync(folder, { recursive: true });
  const env = opens ? { ISTAR_BENCH_OPEN: folder } : {};
  // Without what draws where that is not asked for: it takes long to build.
  const features = opens && others.length > 0 && !others.includes('gpu') ? 'bench' : 'bench,gpu';
  run('cargo', ['bench', '--features', features, '--bench', 'bench', '--', ...others], env);
  if (opens) {
    await wasmModules();
    await measureWeb(folder, at('target', 'web'), at('dist'));
  }
  if (words.length === 0) await frames();
});

/** A moving view in a browser. */
async function frames() {
  await setup({ tests: true });
  await build();
  // What it needs is there only now.
  const { measureFrames } = await import('../../tests/bench/frames.mjs');
  await measureFrames();
}

/** Bytes against quality, for IStar and others. */
function rates(pictures) {
  const python = at('.tools', 'codecs', 'bin', 'python');
  if (output('python3', ['--version']) === undefined) {
    throw new TaskError(
      'Python is missing, with which the other codecs run. Install python3 and python3-venv.',
    );
  }
  if (!existsSync(python)) run('python3', ['-m', 'venv', at('.tools', 'codecs')]);
  run(python, ['-m', 'pip', 'install', '--quiet', '--disable-pip-version-check', ...CODECS]);
  run('cargo', ['build', '--release', '--features', 'cli']);
  const [command, folder, out] = [cli, at('web', 'gallery'), at('target', 'bench')];
  const names = pictures.length > 0 ? pictures : PICTURES;
  run(python, [
    at('tests', 'bench', 'rd.py'),
    '--command',
    command,
    '--pictures',
    folder,
    '--out',
    out,
    ...names,
  ]);
}
