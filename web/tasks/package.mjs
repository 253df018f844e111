// What the npm package has beyond what pages load: its entries for programs, scripts for other ways to load it, types, and the list of
// its elements.
import { cpSync, readFileSync, rmSync } from 'node:fs';
import { deflateRawSync } from 'node:zlib';
import { at, main, nodeBin, run, TaskError, writeIfChanged } from './project.mjs';
import { bundled, script, VIEWER_FETCHES } from './script.mjs';

export async function packageFiles() {
  await bundled('web/src/index.ts', 'index.js', VIEWER_FETCHES);
  // One element, and one module of wasm, also for programs that import both.
  await bundled('web/src/define.ts', 'element.js', ['index.js'], {
    outside: { './element.js': './index.js' },
  });
  await classic();
  await inlined();
  declarations();
  await manifest();
}

/** A script of the old kind has no address of its own but while it starts. */
async function classic() {
  await bundled('web/src/define.ts', 'istar.classic.js', VIEWER_FETCHES, {
    format: 'iife',
    globalName: 'istar',
    define: { 'import.meta.url': 'scriptUrl' },
    inject: [at('web', 'src', 'classic.ts')],
  });
}

/** All that the viewer could fetch is inside, packed: modules of wasm, and the workers, which share the encoder's. */
async function inlined() {
  const worker = (entry) =>
    script(entry, { format: 'iife', outside: {}, instead: { './fetched.js': 'web/src/inlined-encoder.ts' } });
  await bundled('web/src/define.ts', 'istar-inlined.js', [], {
    outside: {},
    instead: { './fetched.js': 'web/src/inlined.ts' },
    inside: {
      viewer: packed('istar_bg.wasm'),
      encoder: packed('istar_encoder_bg.wasm'),
      fitter: await worker('web/src/fitter.ts'),
      painter: await worker('web/src/painter.ts'),
    },
  });
}

function packed(name) {
  return deflateRawSync(readFileSync(at('dist', name)), { level: 9 }).toString('base64');
}

/** Entries of the package that have types of ours. */
const TYPED = ['index', 'define', 'legend', 'material'];

/** dist/types: what the entries' types need of all that TypeScript tells, and those for frameworks. */
function declarations() {
  const made = at('target', 'types');
  const kept = at('dist', 'types');
  rmSync(made, { recursive: true, force: true });
  const options = ['--noEmit', 'false', '--declaration', '--emitDeclarationOnly'];
  run(nodeBin('tsc'), ['-p', 'web', ...options, '--rootDir', 'web/src', '--outDir', made]);
  const texts = new Map();
  const take = (name) => {
    if (texts.has(name)) return;
    const text = readFileSync(`${made}/${name}.d.ts`, 'utf8');
    texts.set(name, text);
    for (const [, from] of text.matchAll(/from '([^']+)'/g)) {
      // What the modules of wasm are like is nobody's business.
      if (!/^\.\/\w+\.js$/.test(from))
        throw new TaskError(`The package's types need ${from}: see ${name}.ts`);
      take(from.slice(2, -3));
    }
  };
  TYPED.forEach(take);
  rmSync(kept, { recursive: true, force: true });
  for (const [name, text] of texts) writeIfChanged(`${kept}/${name}.d.ts`, text);
  cpSync(at('web', 'frameworks'), kept, { recursive: true });
}

/** dist/custom-elements.json: what the elements have, by their types and the comments on them. */
async function manifest() {
  const { create, ts } = await import('@custom-elements-manifest/analyzer');
  const entries = { 'dist/element.js': 'element', 'dist/istar-legend.js': 'legend' };
  const modules = Object.entries(entries).map(([path, types]) => {
    const text = readFileSync(at('dist', 'types', `${types}.d.ts`), 'utf8');
    return ts.createSourceFile(path, text, ts.ScriptTarget.ES2022, true);
  });
  const { readme, ...found } = create({ modules });
  for (const module of found.modules) {
    module.declarations = module.declarations.filter(({ customElement }) => customElement);
    for (const element of module.declarations) {
      const inner = ['#private', 'observedAttributes'];
      // Of a static property the setter is told once more.
      const isFirst = ({ name }, i) => i === element.members.findIndex((member) => member.name === name);
      element.members = element.members.filter(isFirst).filter(({ name }) => !inner.includes(name));
      element.superclass = { name: 'HTMLElement' };
      const declaration = { name: element.name, module: module.path };
      module.exports.push({ kind: 'custom-element-definition', name: element.tagName, declaration });
    }
  }
  writeIfChanged(at('dist', 'custom-elements.json'), `${JSON.stringify(found, null, 2)}\n`);
}

await main(import.meta.url, packageFiles);
