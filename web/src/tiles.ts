import type { Camera, Tile } from '#wasm';
import type { PictureFile, Piece, RawTile, TileId } from './archive.js';
import type { Renderer, Scene } from './engine.js';
import { ViewerError, viewerError } from './errors.js';

/** Requests under way at once: what a browser opens to one server without HTTP/2. */
const MOST_REQUESTS = 6;
/** Tiles that are on no screen are kept as long as all take no more than this, here and on the GPU, in bytes. */
const BUDGET = 192 * 1024 * 1024;
/** On small devices, for each GB that they have: where the browser tells. */
const BUDGET_A_GB = 64 * 1024 * 1024;

/** A tile that is there. */
export interface Loaded {
  id: RawTile;
  tile: Tile;
  /** Where it is drawn; once it has been. */
  scene: Scene | undefined;
  /** The frame that last showed it. */
  used: number;
  /** The styles that it has on the GPU: their version, and the pixel ratio that they were written for. */
  styled?: { version: number; ratio: number };
  /** The numbers of its regions, then their colours, once they were asked for. */
  regions?: Uint32Array;
}

/** What a view shows. */
export interface Frame {
  /** What is there of it, coarser tiles first: finer ones cover them. */
  tiles: Loaded[];
  /** Nothing finer is on its way. */
  complete: boolean;
}

interface Loading {
  piece: Piece;
  controller: AbortController;
}

/** The tiles of a picture that a view needs, fetched as it moves, and those that it needed, as long as there is room. */
export class Tiles {
  readonly file: PictureFile;
  #renderer: Renderer;
  /** Of each view what it lacks, and the keys of what it holds: that stays as long as it does. */
  readonly #views = new Map<object, { needed: TileId[]; held: Set<string> }>();
  readonly #changed: () => void;
  readonly #failed: (cause: unknown) => void;
  /** All that are there. */
  readonly there = new Map<string, Loaded>();
  /** Tiles that cannot be read: what is coarser stands in for them. */
  readonly #damaged = new Map<string, ViewerError>();
  #loading: Loading[] = [];
  #frame = 0;
  #bytes = 0;

  /** `changed` is called when there is more to show, `failed` when there never will be anything. */
  constructor(file: PictureFile, renderer: Renderer, changed: () => void, failed: (cause: unknown) => void) {
    this.file = file;
    this.#renderer = renderer;
    this.#changed = changed;
    this.#failed = failed;
  }

  free(): void {
    for (const { controller } of this.#loading) controller.abort();
    this.#loading = [];
    for (const loaded of this.there.values()) {
      dropScene(loaded);
      loaded.tile.free();
    }
    this.there.clear();
    this.file.free();
  }

  /** Goes on with another renderer: the last one lost all that it had. */
  moveTo(renderer: Renderer): void {
    this.#renderer = renderer;
    for (const loaded of this.there.values()) this.#bytes -= dropScene(loaded);
  }

  /** A view is gone. */
  forget(view: object): void {
    this.#views.delete(view);
  }

  /** What is there of a view. What is missing is sent for, and what is no longer wanted is not waited for. */
  frame(camera: Camera, view: object): Frame {
    this.#frame++;
    const shown = new Map<string, Loaded>();
    const missing = new Map<string, TileId>();
    const coarsest = new Map<string, TileId>();
    for (const wanted of this.file.view(camera)) {
      let isThere = this.#show(wanted, shown, missing);
      for (let id = this.file.coarser(wanted); id; id = this.file.coarser(id)) {
        // The coarsest are always there, so that there never is a hole.
        if (!this.file.coarser(id)) coarsest.set(id.key, id);
        if (!isThere) isThere = this.#show(id, shown);
      }
    }
    for (const id of coarsest.values()) {
      const loaded = this.there.get(id.key);
      if (loaded) loaded.used = this.#frame;
    }
    const first = [...coarsest.values()].filter(
      (id) => !this.there.has(id.key) && !this.#damaged.has(id.key),
    );
    const needed = [...new Map([...first.map((id) => [id.key, id] as const), ...missing]).values()];
    this.#views.set(view, { needed, held: new Set([...shown.keys(), ...coarsest.keys()]) });
    const all = [...this.#views.values()].flatMap(({ needed }) => needed);
    this.#fetch([...new Map(all.map((id) => [id.key, id])).values()]);
    this.#makeRoom();
    const tiles = [...shown.values()].sort((a, b) => b.id.level - a.id.level);
    if (tiles.length === 0 && needed.length === 0) {
      // Nothing came, and nothing will.
      this.#failed([...this.#damaged.values()][0]);
    }
    return { tiles, complete: missing.size === 0 };
  }

  /** Adds a tile to what is shown, or else to what is missing. Whether it is there. */
  #show(id: TileId, shown: Map<string, Loaded>, missing?: Map<string, TileId>): boolean {
    const loaded = this.there.get(id.key);
    if (loaded) {
      loaded.used = this.#frame;
      if (!loaded.scene) {
        loaded.scene = this.#renderer.upload(loaded.tile, loaded.id);
        this.#bytes += loaded.scene.bytes;
      }
      shown.set(id.key, loaded);
    } else if (!this.#damaged.has(id.key)) {
      missing?.set(id.key, id);
    }
    return !!loaded;
  }

  #fetch(needed: TileId[]): void {
    let pieces: Piece[];
    try {
      pieces = this.file.pieces(needed);
    } catch (cause) {
      this.#failed(cause);
      return;
    }
    const wanted = new Set(needed.map(({ key }) => key));
    const directories = new Set(pieces.map(({ directory }) => directory));
    this.#loading = this.#loading.filter(({ piece, controller }) => {
      const isWanted =
        piece.directory === undefined
          ? piece.tiles.some(({ id }) => wanted.has(id.key))
          : directories.has(piece.directory);
      if (!isWanted) controller.abort();
      return isWanted;
    });
    const under = this.#loading.flatMap(({ piece }) => piece.tiles.map(({ id }) => id.key));
    const left = needed.filter(({ key }) => !under.includes(key));
    for (const piece of this.file.pieces(left)) {
      if (this.#loading.length === MOST_REQUESTS) break;
      const { directory } = piece;
      const isUnderWay =
        directory !== undefined && this.#loading.some(({ piece }) => piece.directory === directory);
      if (!isUnderWay) this.#load(piece);
    }
  }

  async #load(piece: Piece): Promise<void> {
    const loading = { piece, controller: new AbortController() };
    this.#loading.push(loading);
    const { signal } = loading.controller;
    try {
      await this.file.read(piece, signal, (id, tile) => {
        if (signal.aborted) {
          if (!(tile instanceof ViewerError)) tile.free();
        } else if (!(tile instanceof ViewerError)) this.#add(id, tile);
        else if (tile.kind === 'malformed') this.#damaged.set(id.key, tile);
        else throw tile;
      });
    } catch (cause) {
      if (!signal.aborted) this.#failed(viewerError(cause, 'malformed'));
      return;
    } finally {
      this.#loading = this.#loading.filter((other) => other !== loading);
    }
    // Also where nothing new is to be seen: there may be more to be fetched.
    if (!signal.aborted) this.#changed();
  }

  #add(id: RawTile, tile: Tile): void {
    if (this.there.has(id.key)) {
      tile.free();
      return;
    }
    this.there.set(id.key, { id, tile, scene: undefined, used: this.#frame });
    this.#bytes += tile.bytes;
    // Others of its piece may take a while.
    this.#changed();
  }

  /** Those that no view holds and that were used least recently go, on the GPU too. */
  #makeRoom(): void {
    const { deviceMemory = 4 } = navigator as { deviceMemory?: number };
    const budget = Math.min(BUDGET, BUDGET_A_GB * deviceMemory);
    if (this.#bytes <= budget) return;
    const held = new Set([...this.#views.values()].flatMap(({ held }) => [...held]));
    const idle = [...this.there.values()].filter(({ id }) => !held.has(id.key));
    idle.sort((a, b) => a.used - b.used);
    for (const loaded of idle) {
      if (this.#bytes <= budget) return;
      this.there.delete(loaded.id.key);
      this.#bytes -= loaded.tile.bytes + dropScene(loaded);
      loaded.tile.free();
    }
  }
}

/** Takes a tile from where it is drawn; the bytes that it took there. */
function dropScene(loaded: Loaded): number {
  const bytes = loaded.scene?.bytes ?? 0;
  loaded.scene?.free();
  loaded.scene = undefined;
  delete loaded.styled;
  return bytes;
}
