// A picture as a material of somebody else's 3D scene: textures, and functions to paste into shaders. A module of its own:
// dist/istar-material.js, `istar/material`.
import { Material } from '#encoder';
import { glsl, wgsl } from '#material';
import { loadEncoder } from './encoder.js';
import { ViewerError, viewerError } from './errors.js';

/** What a texture's texels are: one number of four bytes, four of them, or four of one byte that are 0 to 1. */
export type MaterialFormat = 'r32uint' | 'rgba32uint' | 'rgba8unorm';

/** A texture to create and to fill. */
export interface MaterialTexture {
  /** What the shader calls it. */
  name: string;
  format: MaterialFormat;
  width: number;
  height: number;
  /** Row by row, the first row first. */
  data: Uint32Array<ArrayBuffer> | Uint8Array<ArrayBuffer>;
  /** Each half as wide and high as the one before, with the first; only one but for colours. */
  levels: { width: number; height: number; data: Uint32Array<ArrayBuffer> | Uint8Array<ArrayBuffer> }[];
}

/**
 * A picture as a material. A shader that has `wgsl` or `glsl` pasted in calls `istar_sample(place, dx, dy)`: the premultiplied sRGB colour of
 * a pixel whose middle is `place` in the picture, in its pixels, y downwards; `dx` and `dy` are the derivatives of that by the screen, as
 * `dpdx` and `dpdy` (`dFdx`, `dFdy`) give them.
 */
export class IStarMaterial {
  /** For WebGPU: the textures and a sampler are in bindings 0 to 6 of group 1. */
  static readonly wgsl: string = wgsl;
  /** For WebGL2, GLSL ES 3.00: goes after `#version` and `precision highp float; precision highp int;`. */
  static readonly glsl: string = glsl;

  readonly wgsl: string = wgsl;
  readonly glsl: string = glsl;
  /** Source pixels. */
  readonly width: number;
  readonly height: number;
  /** In the order of their bindings. The last is colours, to be filtered linearly between texels and levels; the others are tables. */
  readonly textures: MaterialTexture[];
  readonly #material: Material;

  private constructor(material: Material) {
    this.#material = material;
    this.width = material.width;
    this.height = material.height;
    this.textures = Material.names().map((name, texture, { length }) => {
      const isColors = texture === length - 1;
      const levels = Array.from({ length: isColors ? material.levels : 1 }, (_, level) => {
        const [width = 1, height = 1] = material.shape(texture, level);
        const bytes = material.bytes(texture, level) as Uint8Array<ArrayBuffer>;
        return { width, height, data: isColors ? bytes : new Uint32Array(bytes.buffer) };
      });
      const isWide = material.shape(texture, 0)[2] === 4;
      const format = isColors ? 'rgba8unorm' : isWide ? 'rgba32uint' : 'r32uint';
      const [first] = levels;
      if (!first) throw new ViewerError('gpu', `There is nothing in ${name}.`);
      return { name, format, ...first, levels };
    });
  }

  /**
   * Reads a file, by its address or its bytes. That takes a moment for large pictures: call it in a worker where a page must not wait. The
   * encoder (0.6 MB) is fetched with the first. An error has a name that says what is wrong: `network`, `http`, `malformed`, `unsupported`
   * or `limit`.
   */
  static async load(file: string | URL | Uint8Array): Promise<IStarMaterial> {
    try {
      const [bytes] = await Promise.all([file instanceof Uint8Array ? file : fetched(file), loadEncoder()]);
      return new IStarMaterial(Material.open(bytes));
    } catch (cause) {
      // What stops the module itself is that memory ran out.
      const step = cause instanceof WebAssembly.RuntimeError ? 'limit' : 'malformed';
      const { kind, message } = viewerError(cause, step);
      throw Object.assign(new Error(message, { cause }), { name: kind });
    }
  }

  /** The region at a place in source pixels, and its colour as 0xRRGGBBAA; none outside. */
  regionAt(x: number, y: number): { region: number; color: number } | undefined {
    const region = this.#material.regionAt(x, y);
    return region === undefined ? undefined : { region, color: this.#material.regionColor(region) ?? 0 };
  }

  /** Gives the memory of the picture back, which `regionAt` needs; `textures` stay. */
  free(): void {
    this.#material.free();
  }
}

async function fetched(url: string | URL): Promise<Uint8Array> {
  const lost = (cause: unknown) => {
    throw new ViewerError('network', `${url} could not be fetched.`, cause);
  };
  const response = await fetch(url).catch(lost);
  if (!response.ok) throw new ViewerError('http', `${url} could not be fetched (${response.status}).`);
  return new Uint8Array(await response.arrayBuffer().catch(lost));
}
