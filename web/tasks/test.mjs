// `npm test`: everything a change must pass, in order, up to the first failure. `npm test NAME…` runs the named steps only.
import { existsSync, readdirSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { delimiter, join } from 'node:path';
import { buildForTests, wasmModules } from './build.mjs';
import { at, main, nodeBin, run, TaskError, whenChanged } from './project.mjs';
import { setup } from './setup.mjs';

/** The software Vulkan driver, so that tests draw the same with and without a graphics card. */
const LAVAPIPE = '/usr/share/vulkan/icd.d/lvp_icd.x86_64.json';
const vulkan = { XDG_RUNTIME_DIR: tmpdir(), ...(existsSync(LAVAPIPE) ? { VK_DRIVER_FILES: LAVAPIPE } : {}) };

const steps = {
  setup: () => setup({ tests: true }),
  format: () => run('cargo', ['fmt', '--check']),
  lint: () => run(nodeBin('biome'), ['check', '--error-on-warnings', '.']),
  build: buildForTests,
  types: async () => {
    // The types of the wasm modules are made with them.
    await wasmModules();
    run(nodeBin('tsc'), ['-p', 'web']);
  },
  clippy: () => {
    const clippy = (...options) => run('cargo', ['clippy', ...options, '--', '-D', 'warnings']);
    clippy('--all-targets', '--features', 'bench,gpu');
    // As others build it, who have no use for all of it: to read, as a library, and for the command.
    clippy('--lib', '--no-default-features');
    clippy('--lib');
    clippy('--features', 'cli');
  },
  rust: () => run('cargo', ['test', '--features', 'cli,gpu'], vulkan),
  wasm: () => {
    // With the browser's own software driver, and with another: each has errors of its own.
    for (const driver of existsSync(LAVAPIPE) ? [{}, vulkan] : [{}]) {
      run(
        at('.tools', 'bin', 'wasm-pack'),
        [
          'test',
          '--headless',
          '--chrome',
          '--mode',
          'no-install',
          '.',
          '--no-default-features',
          '--features',
          'gpu,encode,strokes',
        ],
        {
          PATH: [at('.tools', 'bin'), at('node_modules', '.bin'), process.env.PATH].join(delimiter),
          CHROMEDRIVER: process.env.CHROMEDRIVER ?? '/usr/bin/chromedriver',
          // These tests are small: what takes time is compiling.
          CARGO_PROFILE_DEV_OPT_LEVEL: '1',
          ...driver,
        },
      );
    }
  },
  browser: () => nodeTests('browser'),
  package: () => nodeTests('package'),
};

/** Only where they are named, because what they need takes long to install. */
const others = {
  recipes: async () => {
    const folder = at('.tools', 'docs');
    const wanted = at('tests', 'recipes', 'requirements.txt');
    await whenChanged(join(folder, 'bin', 'mdbook'), [wanted], () => {
      run('python3', ['-m', 'venv', '--clear', folder]);
      const pip = ['-m', 'pip', 'install', '--quiet', '--disable-pip-version-check'];
      run(join(folder, 'bin', 'python'), [...pip, '-r', wanted]);
    });
    nodeTests('recipes');
  },
};

function nodeTests(name) {
  const folder = at('tests', name);
  const files = readdirSync(folder).filter((name) => name.endsWith('.test.mjs'));
  // One file at a time: software rendering keeps every core busy.
  run('node', [
    '--test',
    '--test-concurrency=1',
    '--test-reporter=spec',
    ...files.map((name) => `${folder}/${name}`),
  ]);
}

await main(import.meta.url, async () => {
  const wanted = process.argv.slice(2);
  const all = { ...steps, ...others };
  const unknown = wanted.filter((name) => !(name in all));
  if (unknown.length > 0) {
    throw new TaskError(`There is no step ${unknown.join(', ')}. Steps: ${Object.keys(all).join(', ')}`);
  }
  const times = [];
  for (const name of wanted.length > 0 ? wanted : Object.keys(steps)) {
    console.log(`\n── ${name}`);
    const start = performance.now();
    try {
      await all[name]();
    } catch (error) {
      if (error instanceof TaskError) throw new TaskError(`${name} failed: ${error.message}`);
      throw error;
    }
    times.push(`${name} ${((performance.now() - start) / 1000).toFixed(1)} s`);
    console.log(`── ${times.at(-1)}`);
  }
  console.log(`\nAll passed: ${times.join(', ')}`);
});
