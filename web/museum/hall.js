// What the hall is made of, in metres: x to the right, y upwards, z towards who enters. Three rooms in a row, open to each other.

export const WIDTH = 10;
export const DEPTH = 9;
export const HEIGHT = 4.6;
/** Between two rooms. */
export const WALL = 0.5;
export const DOOR = { half: 1.7, height: 3.3 };
export const ROOMS = [0, 1, 2].map((i) => ({ near: -i * (DEPTH + WALL), far: -i * (DEPTH + WALL) - DEPTH }));
export const END = ROOMS[2].far;

const WALLS = [
  [0.93, 0.92, 0.89],
  [0.42, 0.49, 0.47],
  [0.55, 0.34, 0.31],
].map((color) => color.map((channel) => channel ** 2.2));
const CEILING = [0.86, 0.86, 0.84];
const FLOOR = [1, 1, 1];
const STONE = [0.6, 0.59, 0.56];

/**
 * The pictures: a file, the part of it that is shown in source pixels, where the middle hangs, which way it looks (0 is towards who
 * enters, 90 to the right), and how wide it is.
 */
export const PICTURES = [
  {
    file: 'emblem',
    title: 'Emblem',
    note: 'All of it: large flat areas beside fine lettering',
    part: [0, 0, 4096, 4096],
    at: [-WIDTH / 2, 1.85, -4.4],
    turn: 90,
    width: 2.5,
  },
  {
    file: 'map',
    title: 'Europe',
    note: 'A detail of the map',
    part: [2703, 290, 3604, 933],
    at: [WIDTH / 2, 1.8, -4.6],
    turn: -90,
    width: 3.2,
  },
  {
    file: 'emblem',
    title: 'The shield’s words',
    note: 'A detail of the emblem',
    part: [2250, 1230, 3690, 2510],
    at: [-WIDTH / 2, 1.8, ROOMS[1].near - 4.5],
    turn: 90,
    width: 2.5,
  },
  {
    file: 'map',
    title: 'Canada and Greenland',
    note: 'A detail of the map: islands of a few pixels',
    part: [837, 40, 2240, 965],
    at: [WIDTH / 2, 1.8, ROOMS[1].near - 4.5],
    turn: -90,
    width: 3.2,
  },
  {
    file: 'map',
    title: 'Malay Archipelago',
    note: 'A detail of the map',
    part: [4248, 1010, 5600, 2020],
    at: [-WIDTH / 2, 1.8, ROOMS[2].near - 4.5],
    turn: 90,
    width: 2.9,
  },
  {
    file: 'emblem',
    title: 'Letter A',
    note: 'A detail of the emblem',
    part: [60, 1320, 1940, 3130],
    at: [WIDTH / 2, 1.8, ROOMS[2].near - 4.5],
    turn: -90,
    width: 2.2,
  },
  {
    file: 'map',
    title: 'The countries of the world',
    note: 'All of it',
    part: [0, 0, 5792, 2896],
    at: [0, 2.15, END],
    turn: 0,
    width: 6.2,
  },
  {
    file: 'map',
    title: 'The same, in the floor',
    note: 'Look along it: what is far is as sharp as a pixel',
    part: [0, 0, 5792, 2896],
    at: [0, 0.004, ROOMS[1].near - 4.5],
    flat: true,
    width: 6,
  },
  {
    file: 'map',
    title: 'Africa',
    note: 'A detail of the map',
    part: [2542, 804, 3797, 2060],
    at: [0, 1.85, 0],
    turn: 180,
    width: 2.6,
  },
];

for (const picture of PICTURES) {
  const [left, top, right, lower] = picture.part;
  picture.height = (picture.width * (lower - top)) / (right - left);
  const angle = ((picture.turn ?? 0) * Math.PI) / 180;
  picture.normal = picture.flat ? [0, 1, 0] : [Math.sin(angle), 0, Math.cos(angle)];
  picture.right = picture.flat ? [1, 0, 0] : [Math.cos(angle), 0, -Math.sin(angle)];
  picture.up = picture.flat ? [0, 0, -1] : [0, 1, 0];
}

/** Those on walls: each has a lamp, a mat and a card. */
export const HUNG = PICTURES.filter(({ flat }) => !flat);

/** From the picture to the frame, and the frame itself: its width and depth. */
export const MAT = 0.16;
export const FRAME = { width: 0.055, depth: 0.05 };

/** What is between the wall and the frame's outside, half of it. */
export function halfSize({ width, height }) {
  const around = MAT + FRAME.width;
  return [width / 2 + around, height / 2 + around];
}

export const BENCHES = [-4.5, ROOMS[2].near - 4.6].map((z) => ({
  min: [-0.95, 0, z - 0.24],
  max: [0.95, 0.44, z + 0.24],
}));

/** Light panels in the ceiling. */
export const PANELS = ROOMS.map(({ near, far }) => ({
  x: [-2.6, 2.6],
  z: [far + 1.9, near - 1.9],
  y: HEIGHT - 0.02,
}));

/**
 * The surfaces that light is baked for: a corner, two sides with their lengths, which way they look, a colour, what covers them, and
 * holes.
 */
export function surfaces() {
  const all = [];
  const [left, right] = [-WIDTH / 2, WIDTH / 2];
  for (const [room, { near, far }] of ROOMS.entries()) {
    const color = WALLS[room];
    const depth = near - far;
    const add = (surface) => all.push({ room, color, cover: 'plain', ...surface });
    add({ corner: [left, 0, near], u: [0, 0, -1], v: [0, 1, 0], size: [depth, HEIGHT], normal: [1, 0, 0] });
    add({ corner: [right, 0, far], u: [0, 0, 1], v: [0, 1, 0], size: [depth, HEIGHT], normal: [-1, 0, 0] });
    const isFirst = room === 0;
    const isLast = room === ROOMS.length - 1;
    const hole = [WIDTH / 2 - DOOR.half, WIDTH / 2 + DOOR.half, DOOR.height];
    add({
      corner: [left, 0, far],
      u: [1, 0, 0],
      v: [0, 1, 0],
      size: [WIDTH, HEIGHT],
      normal: [0, 0, 1],
      hole: isLast ? undefined : hole,
    });
    add({
      corner: [right, 0, near],
      u: [-1, 0, 0],
      v: [0, 1, 0],
      size: [WIDTH, HEIGHT],
      normal: [0, 0, -1],
      hole: isFirst ? undefined : hole,
    });
    add({
      corner: [left, 0, near],
      u: [1, 0, 0],
      v: [0, 0, -1],
      size: [WIDTH, depth],
      normal: [0, 1, 0],
      color: FLOOR,
      cover: 'floor',
    });
    add({
      corner: [left, HEIGHT, far],
      u: [1, 0, 0],
      v: [0, 0, 1],
      size: [WIDTH, depth],
      normal: [0, -1, 0],
      color: CEILING,
    });
    if (isLast) continue;
    // The doorway to the next room.
    const { half, height } = DOOR;
    const through = far - WALL;
    add({
      corner: [-half, 0, far],
      u: [0, 0, -1],
      v: [0, 1, 0],
      size: [WALL, height],
      normal: [1, 0, 0],
      color: STONE,
    });
    add({
      corner: [half, 0, through],
      u: [0, 0, 1],
      v: [0, 1, 0],
      size: [WALL, height],
      normal: [-1, 0, 0],
      color: STONE,
    });
    add({
      corner: [-half, height, through],
      u: [1, 0, 0],
      v: [0, 0, 1],
      size: [2 * half, WALL],
      normal: [0, -1, 0],
      color: STONE,
    });
    add({
      corner: [-half, 0, far],
      u: [1, 0, 0],
      v: [0, 0, -1],
      size: [2 * half, WALL],
      normal: [0, 1, 0],
      color: FLOOR,
      cover: 'floor',
    });
  }
  return all;
}
