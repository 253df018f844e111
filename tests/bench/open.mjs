// What `npm run bench -- open` has of the web: the modules that pages fetch, in Node, on the files that the table of that name wrote,
// beside what that took natively. One thread; the least of several runs, of the processor's time: other work on the machine is none
// of it, and compiling is over after the first.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const RUNS = 8;
/** Seconds after which no more runs begin. */
const ENOUGH = 4;

/**
 * Prints the table. `folder` has the files and `native.tsv`: name, payload, seconds to draw labels and to write them as texels, to
 * read texels, and to pack them. `glue` and `modules` are where the build put them.
 */
export async function measureWeb(folder, glue, modules) {
  const load = async (name) => {
    const bound = await import(pathToFileURL(join(glue, `${name}.js`)));
    const headers = { 'content-type': 'application/wasm' };
    const module = new Response(readFileSync(join(modules, `${name}_bg.wasm`)), { headers });
    await bound.default({ module_or_path: module });
    return bound;
  };
  const context = standIn();
  const { fitTexels } = await load('istar_encoder');
  const { Archive, Renderer } = await load('istar');
  const { glsl } = await import(pathToFileURL(join(glue, 'picture.js')));
  const renderer = Renderer.onContext(context.canvas, context, glsl);
  console.log(`\nopen, web  ${'step'.padEnd(14)} wasm s  native s  ratio`);
  const rows = readFileSync(join(folder, 'native.tsv'), 'utf8').trim().split('\n');
  for (const row of rows) {
    const [name, payload, ...native] = row.split('\t');
    const [fit, read, pack] = native.map(Number);
    let bytes = readFileSync(join(folder, `${name}.${payload}.istar`));
    const print = (step, seconds, beside) =>
      console.log(
        `${name.padEnd(10)} ${step.padEnd(14)} ${seconds.toFixed(4)}    ${beside.toFixed(4)}  ${(seconds / beside).toFixed(2).padStart(5)}`,
      );
    let total = 0;
    if (payload === 'labels') {
      const fitted = least(() => fitTexels(bytes));
      print('labels', fitted.seconds, fit);
      bytes = fitted.result;
      total += fitted.seconds;
    }
    const tile = least(
      () => {
        const archive = Archive.open(bytes);
        const [offset, length] = archive.find(0, 0, 0);
        return archive.readTile(0, 0, 0, bytes.subarray(offset, offset + length), false);
      },
      (tile) => tile.free(),
    );
    print('texels', tile.seconds, read);
    const scene = least(
      () => renderer.upload(tile.result),
      (scene) => scene.free(),
    );
    print('pack', scene.seconds, pack);
    total += tile.seconds + scene.seconds;
    print(`all, ${payload}`, total, fit + read + pack);
    tile.result.free();
  }
}

/** The least seconds that something takes, and what came of it; `free` does away with what is not kept. */
function least(job, free = () => {}) {
  let [seconds, sum, result] = [Number.POSITIVE_INFINITY, 0, undefined];
  for (let run = 0; run < RUNS && (run < 3 || sum < ENOUGH); run += 1) {
    if (result !== undefined) free(result);
    const before = process.cpuUsage();
    result = job();
    const { user, system } = process.cpuUsage(before);
    seconds = Math.min(seconds, (user + system) / 1e6);
    sum += (user + system) / 1e6;
  }
  return { seconds, result };
}

/** Stands in for WebGL2, which Node has not: it takes everything and does nothing. What is packed for it is real. */
function standIn() {
  const answers = {
    getError: 0,
    getParameter: 1 << 14,
    getProgramParameter: true,
    getShaderParameter: true,
    isContextLost: false,
  };
  globalThis.OffscreenCanvas = class {};
  globalThis.WebGL2RenderingContext = class {
    canvas = new OffscreenCanvas();
    constructor() {
      // biome-ignore lint/correctness/noConstructorReturn: an object that has every method cannot be written as a class.
      return new Proxy(this, {
        get: (own, name) => own[name] ?? (() => answers[name] ?? {}),
      });
    }
  };
  return new WebGL2RenderingContext();
}
