// wasm-bindgen names each of the module's several hundred imports and exports at length, some with a hash, in both halves, and that
// does not compress: a tenth of the download. Here they get short names, and imports that do the same become one. What the viewer has
// no use for goes: most other ways to load a module, and to free what it made.
import { appendFileSync, readFileSync, writeFileSync } from 'node:fs';
import { TaskError } from './project.mjs';

/** One property of the glue's import object, as wasm-bindgen lays it out. */
const PROPERTY = /^ {8}(\w+): ((?:function\(|\S+,$)[\s\S]*?)(?=\n {8}\w+: |\n {4}\};)/gm;
const OPENING = 'const import0 = {\n        __proto__: null,\n';
const CLOSING = '\n    };';
const DISPOSE = /^if \(Symbol\.dispose\) .*\n/gm;
/** TypeScript has checked what is handed over. */
const CLASS_CHECK = /^ *_assertClass\(.*\n|^function _assertClass\([\s\S]*?\n\}\n/gm;
const NO_REGISTRY =
  /\(typeof FinalizationRegistry === 'undefined'\)\n.*\n {4}: (?=new FinalizationRegistry)/g;
const LOADER = 'async function __wbg_load(';
/** Where imports come from, in each of them. */
const FROM = /"\.\/\w+_bg\.js": import0/;
const SHORT_FROM = 'i';
const EXPORT = '\nexport { initSync, __wbg_init as default };';

/** Takes a response, of which the caller has seen that it is one. Browsers compile it while it arrives where its type is right. */
const SMALL_LOADER = `async function __wbg_init({ module_or_path: response }) {
    const imports = __wbg_get_imports();
    const isWasm = response.headers.get('content-type') === 'application/wasm';
    const { instance, module } = await (isWasm
        ? WebAssembly.instantiateStreaming(response, imports)
        : WebAssembly.instantiate(await response.arrayBuffer(), imports));
    return __wbg_finalize_init(instance, module);
}

function initSync({ module }) {
    return __wbg_finalize_init(new WebAssembly.Instance(module, __wbg_get_imports()), module);
}

export { wasmModule as compiled, initSync, __wbg_init as default };
`;
/** What one thread may give another, which starts it by `initSync`. */
const COMPILED = 'export const compiled: WebAssembly.Module | undefined;\n';

/** Rewrites both files in place. */
export function shortenNames(glue, module) {
  const text = readFileSync(glue, 'utf8');
  const start = text.indexOf(OPENING) + OPENING.length;
  const end = text.indexOf(CLOSING, start);
  if (start < OPENING.length || end < 0)
    throw new TaskError(`${glue} has an unknown layout: see web/tasks/shorten.mjs`);

  const shortByBody = new Map();
  const shortByName = new Map();
  for (const [, name, body] of text.slice(start, end + CLOSING.length).matchAll(PROPERTY)) {
    const same = body.replace(/,$/, '');
    if (!shortByBody.has(same)) shortByBody.set(same, `i${shortByBody.size.toString(36)}`);
    shortByName.set(name, shortByBody.get(same));
  }
  const properties = [...shortByBody].map(([body, short]) =>
    // As methods.
    body.startsWith('function(') ? `        ${short}${body.slice(8)},` : `        ${short}: ${body},`,
  );
  const loader = text.indexOf(LOADER, end);
  if (loader < 0 || text.indexOf(EXPORT, loader) < 0 || !FROM.test(text))
    throw new TaskError(`${glue} has an unknown loader: see web/tasks/shorten.mjs`);
  const exportNames = new Map();
  const shortExport = (name) => {
    // Tests look into the memory.
    if (name === 'memory') return name;
    if (!exportNames.has(name)) exportNames.set(name, `e${exportNames.size.toString(36)}`);
    return exportNames.get(name);
  };
  const bound = renamed(readFileSync(module), IMPORT_SECTION, (bytes, start, parts) => {
    const [, afterModule] = readText(bytes, start);
    const [name, at] = readText(bytes, afterModule);
    const short = shortByName.get(name);
    if (!short || bytes[at] !== FUNCTION) {
      throw new TaskError(`The glue has no function ${name} for the module: see web/tasks/shorten.mjs`);
    }
    parts.push(textBytes(SHORT_FROM), textBytes(short));
    return at;
  });
  const small = renamed(bound, EXPORT_SECTION, (bytes, start, parts) => {
    const [name, at] = readText(bytes, start);
    parts.push(textBytes(shortExport(name)));
    return at;
  });
  writeFileSync(module, small);
  const before = text.slice(0, start) + properties.join('\n') + text.slice(end, loader) + SMALL_LOADER;
  const after = before
    .replace(FROM, `${SHORT_FROM}: import0`)
    .replace(DISPOSE, '')
    .replace(CLASS_CHECK, '')
    .replace(NO_REGISTRY, '')
    .replace(/\bwasm\.(\w+)/g, (_, name) => `wasm.${shortExport(name)}`);
  writeFileSync(glue, after);
  appendFileSync(glue.replace(/js$/, 'd.ts'), COMPILED);
}

const HEADER_BYTES = 8;
const IMPORT_SECTION = 2;
const EXPORT_SECTION = 7;
const FUNCTION = 0;

/** A module with one of its sections of named things changed: `rename` reads the names of one, puts others, and says where they end. */
function renamed(bytes, kind, rename) {
  for (let at = HEADER_BYTES, end = at; at < bytes.length; at = end) {
    const [length, start] = readNumber(bytes, at + 1);
    end = start + length;
    if (bytes[at] !== kind) continue;
    const [count, first] = readNumber(bytes, start);
    const parts = [Buffer.from(number(count))];
    for (let i = 0, from = first; i < count; i++) {
      const named = rename(bytes, from, parts);
      // What it is, in a byte, and its number.
      [, from] = readNumber(bytes, named + 1);
      parts.push(bytes.subarray(named, from));
    }
    const section = Buffer.concat(parts);
    const size = Buffer.from(number(section.length));
    return Buffer.concat([bytes.subarray(0, at + 1), size, section, bytes.subarray(end)]);
  }
  return bytes;
}

/** A LEB128 number and where the next thing begins. */
function readNumber(bytes, start) {
  let value = 0;
  let at = start;
  for (let shift = 0; ; shift += 7) {
    const byte = bytes[at++];
    value |= (byte & 127) << shift;
    if (byte < 128) return [value, at];
  }
}

function readText(bytes, start) {
  const [length, at] = readNumber(bytes, start);
  return [bytes.toString('utf8', at, at + length), at + length];
}

function number(value) {
  const bytes = [];
  let left = value;
  for (; left > 127; left >>>= 7) bytes.push((left & 127) | 128);
  return [...bytes, left];
}

function textBytes(value) {
  const bytes = Buffer.from(value);
  return Buffer.concat([Buffer.from(number(bytes.length)), bytes]);
}
