// wasm-bindgen names each of the module's several hundred imports at length and with a hash, in both halves, and that does not
// compress: a tenth of the download. Here they get short names, and imports that do the same become one. Its loader takes a module
// in many forms, of which the viewer knows one.
import { readFileSync, writeFileSync } from 'node:fs';
import { TaskError } from './project.mjs';

/** One property of the glue's import object, as wasm-bindgen lays it out. */
const PROPERTY = /^ {8}(\w+): ((?:function\(|\S+,$)[\s\S]*?)(?=\n {8}\w+: |\n {4}\};)/gm;
const OPENING = 'const import0 = {\n        __proto__: null,\n';
const CLOSING = '\n    };';
const LOADER = 'async function __wbg_load(';
const EXPORTS = '\nexport { initSync, __wbg_init as default };';

/** Takes a response, of which the caller has seen that it is one. Browsers compile it while it arrives where its type is right. */
const SMALL_LOADER = `async function __wbg_init({ module_or_path: response }) {
    const imports = __wbg_get_imports();
    const isWasm = response.headers.get('content-type') === 'application/wasm';
    const { instance, module } = await (isWasm
        ? WebAssembly.instantiateStreaming(response, imports)
        : WebAssembly.instantiate(await response.arrayBuffer(), imports));
    return __wbg_finalize_init(instance, module);
}

export { __wbg_init as default };
`;

/** Rewrites both files in place. */
export function shortenImports(glue, module) {
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
  if (loader < 0 || text.indexOf(EXPORTS, loader) < 0)
    throw new TaskError(`${glue} has an unknown loader: see web/tasks/shorten.mjs`);
  writeFileSync(module, renameImports(readFileSync(module), shortByName));
  const rest = text.slice(end, loader) + SMALL_LOADER;
  writeFileSync(glue, text.slice(0, start) + properties.join('\n') + rest);
}

const HEADER_BYTES = 8;
const IMPORT_SECTION = 2;
const FUNCTION = 0;

function renameImports(bytes, names) {
  let at = HEADER_BYTES;
  while (at < bytes.length) {
    const [length, start] = readNumber(bytes, at + 1);
    const end = start + length;
    if (bytes[at] === IMPORT_SECTION) {
      const section = renamedSection(bytes, start, names);
      const size = Buffer.from(number(section.length));
      return Buffer.concat([bytes.subarray(0, at + 1), size, section, bytes.subarray(end)]);
    }
    at = end;
  }
  return bytes;
}

function renamedSection(bytes, start, names) {
  const [count, first] = readNumber(bytes, start);
  const parts = [Buffer.from(number(count))];
  let at = first;
  for (let i = 0; i < count; i++) {
    const [module, afterModule] = readText(bytes, at);
    const [name, afterName] = readText(bytes, afterModule);
    const short = names.get(name);
    if (!short || bytes[afterName] !== FUNCTION) {
      throw new TaskError(`The glue has no function ${name} for the module: see web/tasks/shorten.mjs`);
    }
    const [type, next] = readNumber(bytes, afterName + 1);
    parts.push(text(module), text(short), Buffer.from([FUNCTION, ...number(type)]));
    at = next;
  }
  return Buffer.concat(parts);
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

function text(value) {
  const bytes = Buffer.from(value);
  return Buffer.concat([Buffer.from(number(bytes.length)), bytes]);
}
