// Pictures that the browser tests make: a quilt, and one that is too large to be made.
import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { crc32 } from 'node:zlib';
import { PNG } from 'pngjs';
import { checkedCli as cli } from '../../web/tasks/project.mjs';

/** Discs on squares, each in one of some colours. */
function quilt(x, y) {
  const inDisc = Math.hypot((x % 64) - 31.5, (y % 64) - 31.5) < 22;
  const square = (x >> 6) * 7 + (y >> 6) * 3;
  return inDisc ? [40 * (square % 6), 200, 90] : [230, 30 * (square % 8), 60];
}

/** A quilt of that size as a file in a folder. */
export function encodedQuilt(folder, name, size, ...options) {
  return encoded(folder, name, size, quilt, ...options);
}

/** The same four times as large, which takes a fraction of the time for each of its pixels. */
export function encodedLargeQuilt(folder, name, size, ...options) {
  return encoded(folder, name, size, (x, y) => quilt(x >> 2, y >> 2), ...options);
}

/** A strip above three lands, one of which has a lake, in 96 × 64 pixels; the third land has no name. */
export function encodedLands(folder) {
  const names = join(folder, 'names.csv');
  writeFileSync(names, '#e6c800,North\n#c83232,West\n#329632,Middle\n#fafaff,Lake');
  const lands = (x, y) => {
    if (y < 16) return [0xe6, 0xc8, 0];
    if (x >= 40 && x < 56 && y >= 40 && y < 56) return [0xfa, 0xfa, 0xff];
    return x < 32 ? [0xc8, 0x32, 0x32] : x < 64 ? [0x32, 0x96, 0x32] : [0x28, 0x3c, 0xc8];
  };
  return encoded(folder, 'lands', [96, 64], lands, '--names', names, '--texel-size', '4');
}

/** A part of a picture as a file in a folder. */
export function encodedPart(folder, name, picture, [left, top, width, height], ...options) {
  const colorAt = (x, y) => {
    const from = 4 * ((top + y) * picture.width + left + x);
    return [...picture.data.subarray(from, from + 3)];
  };
  return encoded(folder, name, [width, height], colorAt, ...options);
}

/** A picture of that size, by the colour of each pixel, as a file in a folder. */
function encoded(folder, name, [width, height], colorAt, ...options) {
  const picture = new PNG({ width, height });
  for (let i = 0; i < width * height; i++) {
    picture.data.set([...colorAt(i % width, Math.floor(i / width)), 255], 4 * i);
  }
  const [png, file] = [join(folder, `${name}.png`), join(folder, `${name}.istar`)];
  writeFileSync(png, PNG.sync.write(picture));
  execFileSync(cli, ['encode', png, '-o', file, ...options], { stdio: ['ignore', 'ignore', 'inherit'] });
  return file;
}

function varint(number) {
  const bytes = [];
  for (; number > 0x7f; number = Math.floor(number / 128)) bytes.push((number % 128) | 0x80);
  return Buffer.from([...bytes, number]);
}

function u32(number) {
  const bytes = Buffer.alloc(4);
  bytes.writeUInt32LE(number >>> 0);
  return bytes;
}

/**
 * The head of a file of 65,536 × 65,536 pixels, all of whose tiles are that of a file of 1024 × 1024: as SPEC.md says. The file
 * itself is never made, only what is asked for: `slice`.
 */
export function huge(small) {
  const start = 40 + small.readUInt32LE(32);
  const tile = small.subarray(start);
  const entry = Buffer.concat([varint(tile.length), u32(crc32(tile))]);
  const leaf = (tiles) => Buffer.concat(Array(tiles).fill(entry));
  // Levels of 1, 4², 16² tiles are in the root; that of 64² tiles in 16 parts.
  const root = [varint(1000), varint(0)];
  const sections = [];
  for (const tiles of [1, 16, 256]) {
    root.push(varint(0), leaf(tiles));
    sections.push(Array(tiles).fill(tile));
  }
  const part = leaf(256);
  for (let i = 0; i < 16; i++) {
    root.push(varint(part.length), u32(crc32(part)), varint(256 * tile.length));
    sections.push([part, ...Array(256).fill(tile)]);
  }
  const header = Buffer.from(small.subarray(0, 36));
  header.writeUInt32LE(65536, 16);
  header.writeUInt32LE(65536, 20);
  header[28] = 10;
  header[29] = 4;
  const rootBytes = Buffer.concat(root);
  header.writeUInt32LE(rootBytes.length, 32);
  const head = Buffer.concat([header, u32(crc32(Buffer.concat([header, rootBytes]))), rootBytes]);
  const pieces = [head, ...sections.flat()];
  const length = pieces.reduce((sum, piece) => sum + piece.length, 0);
  const slice = (from, to) => {
    const found = [];
    let at = 0;
    for (const piece of pieces) {
      if (at < to && at + piece.length > from) {
        found.push(piece.subarray(Math.max(0, from - at), Math.max(0, Math.min(piece.length, to - at))));
      }
      at += piece.length;
    }
    return Buffer.concat(found);
  };
  return { length, slice, tile: tile.length };
}
