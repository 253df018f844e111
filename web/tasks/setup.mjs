// Installs what is missing, and is done at once where nothing is. `npm run setup` does everything; `npm start` leaves out what only
// the tests need.
import { existsSync, rmSync, statSync } from 'node:fs';
import { join } from 'node:path';
import {
  at,
  bin,
  main,
  output,
  RUST_TARGET,
  run,
  runBeside,
  TaskError,
  WASM_BINDGEN,
  WASM_PACK,
} from './project.mjs';

const TEST_PACKAGES = ['chromium', 'chromium-driver', 'mesa-vulkan-drivers', 'libvulkan1'];
/** What tests use where they find it: Firefox, and what gives it WebGL2 without a screen. */
const WELCOME_PACKAGES = ['firefox-esr', 'xvfb', 'libegl1', 'libgl1', 'libgl1-mesa-dri'];
/** Nobody waits long for them where there is no network. */
const QUICK = ['-o', 'Acquire::Retries=0', '-o', 'Acquire::http::Timeout=10'];

/** How far these are optimized: they run for seconds, and it is not worth minutes to make them fast. What is timed is built as its authors say. */
const QUICKLY_BUILT = { 'wasm-pack': '0', 'wasm-bindgen': '1' };

export async function setup({ tests }) {
  await compiler();
  rustTarget();
  // While compilers keep the cores busy, the rest waits for the network.
  await Promise.all([cargoTools(tests), nodeModules(), tests ? testPackages() : undefined]);
}

async function cargoTools(tests) {
  // --locked fails to build for wasm-bindgen-cli: its lock file names a webpki-roots that no longer compiles.
  await cargoTool('wasm-bindgen', 'wasm-bindgen-cli', WASM_BINDGEN, []);
  if (tests) await cargoTool('wasm-pack', 'wasm-pack', WASM_PACK, ['--locked']);
  rmSync(at('.tools', 'build'), { recursive: true, force: true });
}

async function compiler() {
  if (output('cargo', ['--version']) === undefined) {
    throw new TaskError('Rust is missing. Install it from https://rustup.rs, then run this again.');
  }
  if (output('cc', ['--version']) === undefined) await debianPackages(['build-essential']);
}

function rustTarget() {
  const sysroot = output('rustc', ['--print', 'sysroot'])?.trim();
  if (sysroot && existsSync(join(sysroot, 'lib', 'rustlib', RUST_TARGET))) return;
  run('rustup', ['target', 'add', RUST_TARGET]);
}

export async function cargoTool(name, crate, version, options) {
  // Not all call themselves by their command's name.
  if (output(bin(name), ['--version'])?.trim().endsWith(` ${version}`)) return;
  console.log(`Installing ${crate} ${version} into .tools (some minutes, once)`);
  await runBeside(
    'cargo',
    ['install', crate, '--version', version, '--root', at('.tools'), '--force', ...options],
    {
      // One folder for all tools, because they share dependencies.
      CARGO_TARGET_DIR: at('.tools', 'build'),
      CARGO_PROFILE_RELEASE_DEBUG: '0',
      ...(name in QUICKLY_BUILT ? { CARGO_PROFILE_RELEASE_OPT_LEVEL: QUICKLY_BUILT[name] } : {}),
    },
  );
}

async function nodeModules() {
  const installed = at('node_modules', '.package-lock.json');
  if (existsSync(installed) && statSync(installed).mtimeMs >= statSync(at('package-lock.json')).mtimeMs)
    return;
  await runBeside('npm', ['ci']);
}

async function testPackages() {
  await debianPackages(TEST_PACKAGES);
  try {
    await debianPackages(WELCOME_PACKAGES, QUICK);
  } catch (error) {
    if (!(error instanceof TaskError)) throw error;
    console.log(`${error.message}\nThe tests in Firefox may be left out for that.`);
  }
}

async function debianPackages(names, options = []) {
  if (output('dpkg-query', ['--version']) === undefined) {
    console.log(`This is not Debian: make sure that these are installed: ${names.join(', ')}`);
    return;
  }
  const missing = names.filter(
    (name) => !output('dpkg-query', ['--status', name])?.includes('install ok installed'),
  );
  if (missing.length === 0) return;
  const install = ['install', '-y', '--no-install-recommends', ...missing];
  if (process.getuid?.() !== 0) {
    throw new TaskError(
      `Some packages are missing. Run this, then start again:\n  sudo sh -c 'apt-get update && apt-get ${install.join(' ')}'`,
    );
  }
  await runBeside('apt-get', [...options, 'update']);
  await runBeside('apt-get', [...options, ...install], { DEBIAN_FRONTEND: 'noninteractive' });
}

await main(import.meta.url, () => setup({ tests: true }));
