// `npm start`: sets up and builds what is missing or out of date, then serves the gallery.
import { spawn } from 'node:child_process';
import { parseArgs } from 'node:util';
import { build } from './build.mjs';
import { at, cli, main } from './project.mjs';
import { setup } from './setup.mjs';

await main(import.meta.url, async () => {
  const { values } = parseArgs({ options: { port: { type: 'string' } } });
  await setup({ tests: false });
  await build();
  // The tool prints its address, and says so where the port is taken.
  const server = spawn(cli, ['view', at('dist'), '--port', values.port ?? process.env.PORT ?? '8080'], {
    stdio: 'inherit',
  });
  for (const signal of ['SIGINT', 'SIGTERM']) process.on(signal, () => server.kill(signal));
  server.on('exit', (code) => {
    process.exitCode = code ?? 0;
  });
});
