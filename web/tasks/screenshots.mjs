// Makes web/readme.png from the gallery: a piece of the map as it is, and a detail of it as PNG and as IStar side by side.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { at, cli, main, run } from './project.mjs';

const PANE = { width: 400, height: 300 };
const GAP = 8;
/** A place where three countries meet, in source pixels. */
const CENTER = { x: 3018, y: 684 };
const CLOSE = 15;

export async function screenshots() {
  const { PNG } = await import('pngjs');
  const source = PNG.sync.read(readFileSync(at('web', 'gallery', 'map.png')));
  const panes = [rendered(PNG, 1), magnified(PNG, source, CLOSE), rendered(PNG, CLOSE)];
  const strip = new PNG({ width: panes.length * (PANE.width + GAP) - GAP, height: PANE.height });
  for (const [i, pane] of panes.entries()) {
    PNG.bitblt(pane, strip, 0, 0, PANE.width, PANE.height, i * (PANE.width + GAP), 0);
  }
  writeFileSync(at('web', 'readme.png'), PNG.sync.write(strip));
}

function rendered(PNG, scale) {
  const folder = mkdtempSync(join(tmpdir(), 'istar-'));
  try {
    const png = join(folder, 'pane.png');
    const view = ['--center', `${CENTER.x},${CENTER.y}`, '--scale', String(scale)];
    run(cli, [
      'render',
      at('dist', 'gallery', 'map.istar'),
      '-o',
      png,
      ...view,
      '--size',
      `${PANE.width}x${PANE.height}`,
    ]);
    return PNG.sync.read(readFileSync(png));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

/** The source's own pixels, each as a square. */
function magnified(PNG, source, scale) {
  const pane = new PNG(PANE);
  for (let j = 0; j < PANE.height; j++) {
    for (let i = 0; i < PANE.width; i++) {
      const x = Math.floor(CENTER.x + (i + 0.5 - PANE.width / 2) / scale);
      const y = Math.floor(CENTER.y + (j + 0.5 - PANE.height / 2) / scale);
      const from = (y * source.width + x) * 4;
      source.data.copy(pane.data, (j * PANE.width + i) * 4, from, from + 4);
    }
  }
  return pane;
}

await main(import.meta.url, screenshots);
