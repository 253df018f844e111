// The hall as triangles. A corner has a place, a place on the sheet of light, a place on what covers it (a picture's in source pixels), and
// light of its own.
import { BENCHES, FRAME, HUNG, halfSize, PANELS, PICTURES, surfaces } from './hall.js';
import { baked, lightAt, shown } from './light.js';
import { add, scale } from './vectors.js';

/** Numbers of each attribute of a corner, one after the other, and of all. */
export const ATTRIBUTES = [3, 2, 2, 3];
export const CORNER = 10;
/** The levels of a white texture, for what nothing covers. */
export const BLANK = [{ width: 1, height: 1, data: new Uint8Array(4).fill(255) }];
/** Metres that the floor's planks take until they repeat. */
const FLOOR_REPEATS = 2.4;
/** Corners along each side of a picture: light changes over it. */
const LIT = 12;

const WHITE = [1, 1, 1];
const PAPER = [0.94, 0.93, 0.9];
const WOOD = [0.055, 0.04, 0.032];
const BRASS = [0.62, 0.47, 0.2];
const SEAT = [0.16, 0.13, 0.11];

/** A mesh that grows. */
class Mesh {
  corners = [];
  indices = [];

  quad(four) {
    const first = this.corners.length / CORNER;
    for (const { at, light, cover, color = WHITE } of four)
      this.corners.push(...at, ...light, ...cover, ...color);
    this.indices.push(first, first + 1, first + 2, first, first + 2, first + 3);
  }

  get data() {
    return { corners: new Float32Array(this.corners), indices: new Uint16Array(this.indices) };
  }
}

/** All meshes of the hall, by what covers them, and the sheet of light. */
export function built() {
  const faces = surfaces();
  const sheet = baked(faces);
  const meshes = { plain: new Mesh(), floor: new Mesh(), labels: new Mesh() };
  for (const [i, surface] of faces.entries()) addSurface(meshes[surface.cover], surface, sheet.places[i]);
  const own = (at, color) => ({ at, light: sheet.plain, cover: [0, 0], color });
  for (const panel of PANELS) addPanel(meshes.plain, panel, own);
  for (const { min, max } of BENCHES) {
    addBox(meshes.plain, [min[0], max[1] - 0.07, min[2]], max, SEAT, own);
    for (const x of [min[0] + 0.12, max[0] - 0.18]) {
      addBox(meshes.plain, [x, 0, min[2] + 0.04], [x + 0.06, max[1] - 0.07, max[2] - 0.04], WOOD, own);
    }
  }
  for (const picture of PICTURES) addFrame(meshes.plain, picture, own);
  for (const [i, picture] of HUNG.entries()) addLabel(meshes.labels, picture, i, sheet.plain);
  const pictures = PICTURES.map((picture) => pictureMesh(picture, sheet.plain).data);
  const data = Object.fromEntries(Object.entries(meshes).map(([name, mesh]) => [name, mesh.data]));
  return { sheet, meshes: data, pictures };
}

function addSurface(mesh, surface, place) {
  const [width, height] = surface.size;
  const corner = (u, v) => {
    const at = add(surface.corner, add(scale(surface.u, u), scale(surface.v, v)));
    const light = [0, 1].map(
      (axis) => place.corner[axis] + ([u, v][axis] / surface.size[axis]) * place.sides[axis],
    );
    return { at, light, cover: [at[0] / FLOOR_REPEATS, at[2] / FLOOR_REPEATS] };
  };
  const part = (left, lower, right, upper) =>
    mesh.quad([corner(left, lower), corner(right, lower), corner(right, upper), corner(left, upper)]);
  if (!surface.hole) {
    part(0, 0, width, height);
    return;
  }
  const [from, to, upTo] = surface.hole;
  part(0, 0, from, height);
  part(to, 0, width, height);
  part(from, upTo, to, height);
}

/** Light that something of a colour shows, at a place of the room that it is in. */
function lit(at, normal, color, strength = 1) {
  const room = at[2] > -9.2 ? 0 : at[2] > -18.7 ? 1 : 2;
  return lightAt(room, at, normal).map((light, i) => shown(strength * light * color[i]));
}

function addPanel(mesh, { x, y, z }, own) {
  const four = [
    [x[0], y, z[0]],
    [x[1], y, z[0]],
    [x[1], y, z[1]],
    [x[0], y, z[1]],
  ];
  mesh.quad(four.map((at) => own(at, [1, 0.995, 0.98])));
}

function addBox(mesh, min, max, color, own) {
  const [a, b] = [min, max];
  const face = (normal, four) =>
    mesh.quad(four.map((at) => own(at, lit(at, normal, color, at[1] < 0.1 ? 0.4 : 1))));
  face(
    [0, 1, 0],
    [
      [a[0], b[1], b[2]],
      [b[0], b[1], b[2]],
      [b[0], b[1], a[2]],
      [a[0], b[1], a[2]],
    ],
  );
  face(
    [0, 0, 1],
    [
      [a[0], a[1], b[2]],
      [b[0], a[1], b[2]],
      [b[0], b[1], b[2]],
      [a[0], b[1], b[2]],
    ],
  );
  face(
    [0, 0, -1],
    [
      [b[0], a[1], a[2]],
      [a[0], a[1], a[2]],
      [a[0], b[1], a[2]],
      [b[0], b[1], a[2]],
    ],
  );
  face(
    [1, 0, 0],
    [
      [b[0], a[1], b[2]],
      [b[0], a[1], a[2]],
      [b[0], b[1], a[2]],
      [b[0], b[1], b[2]],
    ],
  );
  face(
    [-1, 0, 0],
    [
      [a[0], a[1], a[2]],
      [a[0], a[1], b[2]],
      [a[0], b[1], b[2]],
      [a[0], b[1], a[2]],
    ],
  );
}

/** A place before a picture: along it, up it, and out from the wall. */
function before({ at, right, up, normal }, x, y, out) {
  return add(at, add(scale(right, x), add(scale(up, y), scale(normal, out))));
}

/** Four bars with a mitre, and the mat; in the floor a border of brass. */
function addFrame(mesh, picture, own) {
  const [outerX, outerY] = picture.flat
    ? [picture.width / 2 + 0.05, picture.height / 2 + 0.05]
    : halfSize(picture);
  const bar = picture.flat ? 0.05 : FRAME.width;
  const [innerX, innerY] = [outerX - bar, outerY - bar];
  const depth = picture.flat ? 0 : FRAME.depth;
  const color = picture.flat ? BRASS : WOOD;
  // The corners of the outer and of the inner rectangle, around.
  const signs = [
    [-1, -1],
    [1, -1],
    [1, 1],
    [-1, 1],
  ];
  for (let i = 0; i < 4; i++) {
    const [a, b] = [signs[i], signs[(i + 1) % 4]];
    const outer = (sign, out) => before(picture, sign[0] * outerX, sign[1] * outerY, out);
    const inner = (sign, out) => before(picture, sign[0] * innerX, sign[1] * innerY, out);
    // Of a bar that faces up the light is more.
    const up = [0.45, 0.8, 1.5, 0.8][i];
    const face = (four, normal, strength) =>
      mesh.quad(four.map((at) => own(at, lit(at, normal, color, strength))));
    face(
      [outer(a, depth), outer(b, depth), inner(b, depth), inner(a, depth)],
      picture.normal,
      picture.flat ? 1 : 1.6,
    );
    if (picture.flat) continue;
    face([outer(a, 0), outer(b, 0), outer(b, depth), outer(a, depth)], picture.normal, up);
    face(
      [inner(a, depth), inner(b, depth), inner(b, 0.01), inner(a, 0.01)],
      picture.normal,
      [1.4, 0.7, 0.3, 0.7][i],
    );
  }
  if (picture.flat) return;
  // The mat is darker below the upper bar, whose shadow falls on it.
  // It lies over the picture's rim.
  const [x, y] = [picture.width / 2 - 0.004, picture.height / 2 - 0.004];
  const paper = (px, py, strength) => {
    const at = before(picture, px, py, 0.012);
    return own(at, lit(at, picture.normal, PAPER, strength));
  };
  // In steps, since light changes over it.
  const band = (left, lower, right, upper, top = 1) => {
    for (let i = 0; i < LIT; i++) {
      const isWide = right - left > upper - lower;
      const [s, t] = [i / LIT, (i + 1) / LIT];
      const [l, r] = isWide ? [left + s * (right - left), left + t * (right - left)] : [left, right];
      const [d, u] = isWide ? [lower, upper] : [lower + s * (upper - lower), lower + t * (upper - lower)];
      mesh.quad([paper(l, d, 1), paper(r, d, 1), paper(r, u, top), paper(l, u, top)]);
    }
  };
  const shade = innerY - 0.05;
  band(-innerX, shade, innerX, innerY, 0.6);
  band(-innerX, y, innerX, shade);
  band(-innerX, -innerY, innerX, -y);
  band(-innerX, -y, -x, y);
  band(x, -y, innerX, y);
  // What is seen until the picture is there.
  const behind = (px, py) => own(before(picture, px, py, 0.006), [0.8, 0.79, 0.76]);
  mesh.quad([behind(-x, -y), behind(x, -y), behind(x, y), behind(-x, y)]);
}

/** Cards are on one texture, in two columns. */
export const CARDS = { columns: 2, rows: 4, width: 0.5, height: 0.25 };

function addLabel(mesh, picture, index, light) {
  const [half, halfY] = halfSize(picture);
  const [x, y] = [half + 0.18 + CARDS.width / 2, -halfY + CARDS.height / 2 + 0.1];
  const [column, row] = [index % CARDS.columns, Math.floor(index / CARDS.columns)];
  const corner = (sx, sy) => {
    const at = before(picture, x + (sx * CARDS.width) / 2, y + (sy * CARDS.height) / 2, 0.012);
    const cover = [(column + 0.5 + sx / 2) / CARDS.columns, (row + 0.5 - sy / 2) / CARDS.rows];
    return { at, light, cover, color: lit(at, picture.normal, WHITE, 1.1) };
  };
  mesh.quad([corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)]);
}

function pictureMesh(picture, light) {
  const mesh = new Mesh();
  const [left, top, right, lower] = picture.part;
  const corner = (i, j) => {
    const [u, v] = [i / LIT, j / LIT];
    const at = before(
      picture,
      (u - 0.5) * picture.width,
      (v - 0.5) * picture.height,
      picture.flat ? 0 : 0.01,
    );
    const cover = [left + u * (right - left), lower + v * (top - lower)];
    return { at, light, cover, color: lit(at, picture.normal, WHITE, picture.flat ? 0.85 : 1) };
  };
  for (let j = 0; j < LIT; j++) {
    for (let i = 0; i < LIT; i++)
      mesh.quad([corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]);
  }
  return mesh;
}
