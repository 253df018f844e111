// The light in the hall, worked out once for every surface: panels in the ceiling, a lamp for each picture, what bounces, corners that are
// darker, and soft shadows below frames and benches.
import { BENCHES, HEIGHT, HUNG, halfSize, PANELS, ROOMS } from './hall.js';
import { add, dot, scale, subtract } from './vectors.js';

/** Texels a metre, and of the sheet that has all of them. */
const DENSITY = 22;
const SHEET = 1024;

const PANEL_LIGHT = [1.0, 0.985, 0.955];
const LAMP_LIGHT = [1.0, 0.93, 0.82];
const BOUNCED = [0.36, 0.34, 0.315];

/** Lamps hang from the ceiling, away from the wall. */
const LAMPS = HUNG.map((picture) => {
  const from = add(add(picture.at, scale(picture.normal, 2.3)), [0, HEIGHT - 0.1 - picture.at[1], 0]);
  const towards = subtract(picture.at, from);
  const length = Math.hypot(...towards);
  const spread = Math.max(...halfSize(picture)) / length;
  return {
    from,
    towards: scale(towards, 1 / length),
    strength: 0.42 * length * length,
    spread,
    room: roomOf(picture.at[2]),
  };
});

function roomOf(z) {
  return Math.max(
    0,
    ROOMS.findIndex(({ near, far }) => z <= near + 0.01 && z >= far - 0.01),
  );
}

/** Light that falls on a place of a room, from in front of it. */
export function lightAt(room, at, normal) {
  const sum = [...BOUNCED];
  const take = (light, amount) => {
    for (let i = 0; i < 3; i++) sum[i] += light[i] * amount;
  };
  for (const [i, panel] of PANELS.entries()) {
    // Of the rooms beside only what comes through the doors.
    const share = i === room ? 1 : Math.abs(i - room) === 1 ? 0.12 : 0;
    if (share === 0) continue;
    const parts = [3, 4];
    let amount = 0;
    for (let k = 0; k < parts[0] * parts[1]; k++) {
      const u = ((k % parts[0]) + 0.5) / parts[0];
      const v = (Math.floor(k / parts[0]) + 0.5) / parts[1];
      const from = [
        panel.x[0] + u * (panel.x[1] - panel.x[0]),
        panel.y,
        panel.z[0] + v * (panel.z[1] - panel.z[0]),
      ];
      const way = subtract(from, at);
      const distance = Math.max(Math.hypot(...way), 0.2);
      const facing = Math.max(dot(way, normal) / distance, 0);
      amount += (facing * Math.max(way[1], 0)) / distance ** 3;
    }
    const area = (panel.x[1] - panel.x[0]) * (panel.z[1] - panel.z[0]);
    take(PANEL_LIGHT, (share * 0.5 * amount * area) / (parts[0] * parts[1]));
  }
  for (const lamp of LAMPS) {
    if (lamp.room !== room) continue;
    const way = subtract(at, lamp.from);
    const distance = Math.hypot(...way);
    const facing = Math.max(-dot(way, normal) / distance, 0);
    const along = dot(way, lamp.towards) / distance;
    const off = Math.sqrt(Math.max(1 - along * along, 0)) / Math.max(along, 1e-3);
    const beam = along <= 0 ? 0 : Math.exp(-((off / (1.3 * lamp.spread)) ** 3));
    take(LAMP_LIGHT, (lamp.strength * facing * beam) / (distance * distance));
  }
  return sum;
}

/** How much of the light is left at a distance from where surfaces meet. */
function corner(distance) {
  return 1 - 0.42 * Math.exp(-distance / 0.4);
}

/** How much a box with soft edges covers of a place, `x` and `y` from its middle. */
function softBox(x, y, [halfX, halfY], blur) {
  const edge = (away, half) => {
    const t = Math.min(Math.max((half - Math.abs(away)) / blur + 0.5, 0), 1);
    return t * t * (3 - 2 * t);
  };
  return edge(x, halfX) * edge(y, halfY);
}

/** What is left of the light on a surface where things stand before it. */
function shadow(surface, at) {
  let left = 1;
  for (const picture of HUNG) {
    if (dot(picture.normal, surface.normal) < 0.99) continue;
    const way = subtract(at, picture.at);
    if (Math.abs(dot(way, picture.normal)) > 0.05) continue;
    const half = halfSize(picture);
    const [x, y] = [dot(way, picture.right), way[1]];
    left *= 1 - 0.5 * softBox(x, y + 0.09, [half[0] - 0.01, half[1]], 0.2);
    left *= 1 - 0.35 * softBox(x, y + 0.02, half, 0.07);
  }
  if (surface.normal[1] > 0.9) {
    for (const { min, max } of BENCHES) {
      const middle = [0, 2].map((axis) => (min[axis] + max[axis]) / 2);
      const half = [0, 2].map((axis) => (max[axis] - min[axis]) / 2);
      left *= 1 - 0.62 * softBox(at[0] - middle[0], at[2] - middle[1], half, 0.55);
    }
  }
  return left;
}

/** Linear light as a byte of sRGB, about; what is too bright is bent. */
export function shown(light) {
  const bent = light < 0.8 ? light : 0.8 + 0.2 * (1 - Math.exp(-(light - 0.8) / 0.2));
  return Math.min(Math.max(bent, 0), 1) ** (1 / 2.2);
}

/** Puts surfaces on one sheet, row after row, the highest first; says of each where. */
function placed(surfaces) {
  const of = surfaces.map((surface) => ({
    surface,
    size: surface.size.map((along) => Math.max(Math.ceil(along * DENSITY), 4)),
  }));
  const sorted = [...of].sort((a, b) => b.size[1] - a.size[1]);
  let [x, y, row] = [4, 0, 0];
  for (const one of sorted) {
    if (x + one.size[0] + 2 > SHEET) [x, y, row] = [4, y + row, 0];
    one.at = [x + 1, y + 1];
    x += one.size[0] + 2;
    row = Math.max(row, one.size[1] + 2);
  }
  if (y + row > SHEET) throw new Error('The light does not fit on its sheet.');
  return of;
}

/** A sheet of light for surfaces, and for each the place of its corner and the lengths of its sides there, from 0 to 1. */
export function baked(surfaces) {
  const texels = new Uint8Array(4 * SHEET * SHEET);
  // The first are plain light, for what has its own.
  texels.fill(255, 0, 4 * 3);
  for (let row = 1; row < 3; row++) texels.fill(255, 4 * SHEET * row, 4 * (SHEET * row + 3));
  let seed = 1;
  const noise = () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 32 - 0.5;
  };
  const places = placed(surfaces).map(({ surface, size, at: [left, top] }) => {
    const [columns, rows] = size;
    for (let j = -1; j <= rows; j++) {
      for (let i = -1; i <= columns; i++) {
        const u = (Math.min(Math.max(i + 0.5, 0), columns) / columns) * surface.size[0];
        const v = (Math.min(Math.max(j + 0.5, 0), rows) / rows) * surface.size[1];
        const at = add(surface.corner, add(scale(surface.u, u), scale(surface.v, v)));
        const light = lightAt(surface.room, at, surface.normal);
        const around = [u, surface.size[0] - u, v, surface.size[1] - v].reduce(
          (product, distance) => product * corner(distance),
          shadow(surface, at),
        );
        const to = 4 * ((top + j) * SHEET + left + i);
        for (let c = 0; c < 3; c++) {
          texels[to + c] = 255 * shown(light[c] * around * surface.color[c]) + 0.5 + 0.6 * noise();
        }
        texels[to + 3] = 255;
      }
    }
    return { corner: [left / SHEET, top / SHEET], sides: size.map((n) => n / SHEET) };
  });
  return { size: SHEET, texels, places, plain: [1.5 / SHEET, 1.5 / SHEET] };
}
