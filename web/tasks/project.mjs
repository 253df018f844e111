// What every task shares: where things lie, the tools' versions, how to run a command. Node built-ins only, because set-up runs
// before node_modules exists.
import { spawn, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

export const root = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
export const at = (...parts) => join(root, ...parts);

/** Cargo's output, which may lie elsewhere; what the web tasks make lies in target/web and dist. */
export const cargoTarget = resolve(root, process.env.CARGO_TARGET_DIR ?? 'target');
export const cli = join(cargoTarget, 'release', 'istar');
/** The same with checks, from which the tests of Rust are built as well. */
export const checkedCli = join(cargoTarget, 'debug', 'istar');
export const bin = (name) => at('.tools', 'bin', name);
export const nodeBin = (name) => at('node_modules', '.bin', name);

export const RUST_TARGET = 'wasm32-unknown-unknown';
/** wasm-bindgen must be the version of the crate in Cargo.toml. */
export const WASM_BINDGEN = '0.2.130';
export const WASM_PACK = '0.15.1';
/** What the bench compares with. */
export const VTRACER = '0.6.5';

/** A failure that needs no stack trace: the message says what to do, or the command has said it. */
export class TaskError extends Error {}

/** Runs a command in the project's root with its output on the terminal; throws where it fails. */
export function run(command, args, env = {}) {
  const { status, error, signal } = spawnSync(command, args, {
    cwd: root,
    stdio: 'inherit',
    env: { ...process.env, ...env },
  });
  if (error) throw new TaskError(`${command} could not be run: ${error.message}`);
  if (status !== 0) throw new TaskError(`${command} ${args.join(' ')} failed (${signal ?? status}).`);
}

/** The same, while others run. */
export function runBeside(command, args, env = {}) {
  return new Promise((done, fail) => {
    const child = spawn(command, args, { cwd: root, stdio: 'inherit', env: { ...process.env, ...env } });
    child.on('error', (error) => fail(new TaskError(`${command} could not be run: ${error.message}`)));
    child.on('close', (status, signal) => {
      if (status === 0) done();
      else fail(new TaskError(`${command} ${args.join(' ')} failed (${signal ?? status}).`));
    });
  });
}

/** What a command prints, or undefined where it fails or does not exist. */
export function output(command, args) {
  const { status, stdout } = spawnSync(command, args, { cwd: root, encoding: 'utf8' });
  return status === 0 ? stdout : undefined;
}

/** Writes only what differs, so that what depends on the file is not built again. */
export function writeIfChanged(path, content) {
  const bytes = Buffer.from(content);
  if (existsSync(path) && readFileSync(path).equals(bytes)) return;
  mkdirSync(dirname(path), { recursive: true });
  writeFileSync(path, bytes);
}

/** Does a job unless it has been done with the same inputs and its output is still there. */
export async function whenChanged(output, inputs, job) {
  const hash = createHash('sha256');
  for (const input of inputs) hash.update(existsSync(input) ? readFileSync(input) : input).update('\0');
  const key = hash.digest('hex');
  const stamp = at('target', 'stamps', output.slice(root.length).replaceAll(/\W+/g, '-'));
  if (existsSync(output) && existsSync(stamp) && readFileSync(stamp, 'utf8') === key) return;
  mkdirSync(dirname(output), { recursive: true });
  await job();
  writeIfChanged(stamp, key);
}

/** Runs a task when its file is the one that was started; a TaskError ends in one line and exit status 1. */
export async function main(url, task) {
  if (resolve(process.argv[1] ?? '') !== fileURLToPath(url)) return;
  try {
    await task();
  } catch (error) {
    if (!(error instanceof TaskError)) throw error;
    console.error(`\n${error.message}`);
    process.exitCode = 1;
  }
}
