import { Archive, type Camera, type Tile } from '#wasm';
import { ViewerError, viewerError } from './errors.js';
import type { FittingJob } from './fitting.js';
import { changed, MemorySource, type Source } from './source.js';

/** Bytes that are asked for first: the head of most files, and all of a small one. */
const FIRST = 16384;
/** Tiles are fetched at once where no more than so many bytes lie between them, and as long as they are no more than so many. */
const MOST_BETWEEN = 8192;
const MOST_AT_ONCE = 256 * 1024;

/** A tile by its level, column and row. */
export interface TileId {
  level: number;
  x: number;
  y: number;
  /** All in one. */
  key: string;
}

/** A tile as it is in its file. */
export interface RawTile extends TileId {
  /** The file's first bytes. */
  head: Uint8Array;
  bytes: Uint8Array;
}

/** Bytes of the file, and what they are. */
export interface Piece {
  offset: number;
  length: number;
  /** The tiles in it, by where they are. */
  tiles: { id: TileId; offset: number; length: number }[];
  /** The part of the directory that it is. */
  directory: number | undefined;
}

/** A file that is read as it is needed. Its head is there. */
export class PictureFile {
  readonly archive: Archive;
  readonly #source: Source;
  /** The file's first bytes. */
  readonly #start: Uint8Array;
  readonly #etag: string | undefined;
  /** What regions are called, by their colour as 0xRRGGBBAA; empty until that is read. */
  names = new Map<number, string>();
  /** The same, once it is read. */
  named = Promise.resolve(this.names);

  private constructor(archive: Archive, source: Source, start: Uint8Array, etag: string | undefined) {
    this.archive = archive;
    this.#source = source;
    this.#start = start;
    this.#etag = etag;
    this.#readNames(start);
  }

  /** Where a file's head says that it has names, a module of its own reads them. */
  #readNames(start: Uint8Array): void {
    if ((start[30] ?? 0) & 1) {
      this.named = import('./names.js')
        .then(({ readNames }) => {
          this.names = readNames(start);
        }, console.warn)
        .then(() => this.names);
    }
  }

  /** The wasm module must be there. A file without texels is given some first, by a worker. */
  static async open(source: Source, signal: AbortSignal): Promise<PictureFile> {
    const { data, etag } = await source.getBytes(0, FIRST, signal);
    let start = new Uint8Array(data);
    const more = async (length: number) => {
      if (length <= start.length) return;
      // A file shorter than what was asked for has no more.
      const rest =
        start.length < FIRST
          ? new ArrayBuffer(0)
          : (await source.getBytes(start.length, length - start.length, signal, etag)).data;
      start = concat(start, new Uint8Array(rest));
      if (start.length < length) throw cutShort();
    };
    try {
      if (start.length === 0) throw new ViewerError('malformed', 'file: it is empty');
      for (let needs = Archive.needs(start); needs > 0; needs = Archive.needs(start)) await more(needs);
      const archive = Archive.open(start);
      if (!archive.holdsLabels) return new PictureFile(archive, source, start, etag);
      const { length } = archive;
      archive.free();
      await more(length);
      const file = await PictureFile.open(new MemorySource(await fitted(start, signal)), signal);
      file.#readNames(start);
      return file;
    } catch (cause) {
      throw viewerError(cause, 'malformed');
    }
  }

  free(): void {
    this.archive.free();
  }

  /** The tiles that a camera shows, the nearest to the middle first. */
  view(camera: Camera): TileId[] {
    const numbers = this.archive.view(camera);
    const ids: TileId[] = [];
    for (let i = 0; i < numbers.length; i += 3) {
      ids.push(tileId(numbers[i] ?? 0, numbers[i + 1] ?? 0, numbers[i + 2] ?? 0));
    }
    return ids;
  }

  /** The tile of the next coarser level that shows what a tile does. */
  coarser({ level, x, y }: TileId): TileId | undefined {
    return level + 1 < this.archive.levels ? tileId(level + 1, x >> 2, y >> 2) : undefined;
  }

  /** What to fetch for some tiles, those that come first first: several that lie together at once. */
  pieces(tiles: TileId[]): Piece[] {
    const pieces: Piece[] = [];
    const directories = new Set<number>();
    for (const id of tiles) {
      const [offset, length, directory] = this.archive.find(id.level, id.x, id.y);
      if (offset === undefined || length === undefined) {
        throw new ViewerError('unsupported', 'The file is a part of a picture: merge its shards.');
      }
      if (directory !== undefined) {
        if (!directories.has(directory)) pieces.push({ offset, length, tiles: [], directory });
        directories.add(directory);
        continue;
      }
      const tile = { id, offset, length };
      const near = pieces.find((piece) => {
        const end = Math.max(offset + length, piece.offset + piece.length);
        const both = end - Math.min(offset, piece.offset);
        const between = both - length - piece.length;
        return piece.directory === undefined && between <= MOST_BETWEEN && both <= MOST_AT_ONCE;
      });
      if (near) {
        const end = Math.max(offset + length, near.offset + near.length);
        near.offset = Math.min(offset, near.offset);
        near.length = end - near.offset;
        near.tiles.push(tile);
      } else {
        pieces.push({ offset, length, tiles: [tile], directory: undefined });
      }
    }
    return pieces;
  }

  /** Fetches a piece, and reads a tile of it where `each` asks for it. */
  async read(
    piece: Piece,
    signal: AbortSignal,
    each: (raw: RawTile, tile: Tile | ViewerError) => void,
  ): Promise<void> {
    const bytes = await this.#bytes(piece.offset, piece.length, signal);
    try {
      if (piece.directory !== undefined) this.archive.addDirectory(piece.directory, bytes);
    } catch (cause) {
      throw await this.#damaged(cause, signal);
    }
    for (const { id, offset, length } of piece.tiles) {
      const from = offset - piece.offset;
      const raw = { ...id, head: this.#start, bytes: bytes.subarray(from, from + length) };
      let tile: Tile;
      // The archive may be gone since the tile before.
      signal.throwIfAborted();
      try {
        tile = await this.#tile(raw, signal);
      } catch (cause) {
        each(raw, await this.#damaged(cause, signal));
        continue;
      }
      each(raw, tile);
    }
  }

  /** Reads a tile. What the module does not know is labels, to which a worker gives texels. */
  async #tile(raw: RawTile, signal: AbortSignal): Promise<Tile> {
    const read = (drawn: boolean) => this.archive.readTile(raw.level, raw.x, raw.y, raw.bytes, drawn);
    try {
      return read(false);
    } catch (cause) {
      if (viewerError(cause, 'malformed').kind !== 'unsupported') throw cause;
      raw.bytes = await fitted(raw, signal);
      signal.throwIfAborted();
      return read(true);
    }
  }

  async #bytes(offset: number, length: number, signal: AbortSignal): Promise<Uint8Array> {
    const known = this.#start.subarray(offset, offset + length);
    if (known.length === length) return known;
    const from = offset + known.length;
    const { data } = await this.#source.getBytes(from, length - known.length, signal, this.#etag);
    const bytes = concat(known, new Uint8Array(data));
    if (bytes.length < length) throw await this.#damaged(cutShort(), signal);
    return bytes;
  }

  /** Bytes that do not fit the head are of a newer file, where that has another head; else the file is damaged. */
  async #damaged(cause: unknown, signal: AbortSignal): Promise<ViewerError> {
    const error = viewerError(cause, 'malformed');
    if (error.kind !== 'malformed') return error;
    // The header has the checksum of all that follows in the head, and that those of tiles.
    const before = this.#start.subarray(0, 40);
    const { data } = await this.#source.getBytes(0, before.length, signal, this.#etag);
    const now = new Uint8Array(data);
    return before.every((byte, i) => byte === now[i]) ? error : changed();
  }
}

/** Texels for labels. What makes them is fetched only then. */
async function fitted(job: FittingJob, signal: AbortSignal): Promise<Uint8Array> {
  const module = await import('./fitting.js').catch((cause) => {
    throw new ViewerError('network', 'The encoder could not be fetched.', cause);
  });
  return module.fitted(job, signal);
}

function tileId(level: number, x: number, y: number): TileId {
  return { level, x, y, key: `${level}/${x}/${y}` };
}

function cutShort(): ViewerError {
  return new ViewerError('malformed', 'file: it was cut short');
}

function concat(a: Uint8Array, b: Uint8Array): Uint8Array<ArrayBuffer> {
  const both = new Uint8Array(a.length + b.length);
  both.set(a);
  both.set(b, a.length);
  return both;
}
