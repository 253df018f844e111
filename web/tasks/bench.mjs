// `npm run bench`: what pictures cost, in tables; tests/bench/main.rs says which there are. Words in the arguments choose some.
import { rmSync } from 'node:fs';
import { at, main, run, VTRACER } from './project.mjs';
import { cargoTool } from './setup.mjs';

await main(import.meta.url, () => {
  const words = process.argv.slice(2);
  // Not in the set-up, because only one table needs it.
  if (words.length === 0 || words.includes('rivals')) {
    cargoTool('vtracer', 'vtracer', VTRACER, ['--locked']);
    rmSync(at('.tools', 'build'), { recursive: true, force: true });
  }
  run('cargo', ['bench', '--features', 'bench', '--bench', 'bench', '--', ...words]);
});
