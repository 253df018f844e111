// The little algebra that the hall needs. Matrices are columns after one another.

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, by) => [a[0] * by, a[1] * by, a[2] * by];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const mix = (a, b, t) => a.map((n, i) => n + (b[i] - n) * t);

/** Which way a visitor looks who is turned so far to the right, and up. */
export function towards(turn, tilt) {
  return [Math.sin(turn) * Math.cos(tilt), Math.sin(tilt), -Math.cos(turn) * Math.cos(tilt)];
}

/** Where forward, right and up are for a visitor. */
export function axes({ turn, tilt }) {
  return {
    forward: towards(turn, tilt),
    right: [Math.cos(turn), 0, Math.sin(turn)],
    up: towards(turn, tilt + Math.PI / 2),
  };
}

/** From places in the hall to the screen's clip space, for an eye; depth from 0 to 1 where `isHalf`, else from -1. */
export function lens(visitor, aspect, fovy, isHalf) {
  const [near, far] = [0.04, 80];
  const { at } = visitor;
  const { forward, right, up } = axes(visitor);
  const f = 1 / Math.tan(fovy / 2);
  const [depth, shift] = isHalf
    ? [far / (far - near), (-far * near) / (far - near)]
    : [(far + near) / (far - near), (-2 * far * near) / (far - near)];
  const rows = [
    [...scale(right, f / aspect), (-f / aspect) * dot(right, at)],
    [...scale(up, f), -f * dot(up, at)],
    [...scale(forward, depth), -depth * dot(forward, at) + shift],
    [...forward, -dot(forward, at)],
  ];
  const matrix = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) matrix[4 * column + row] = rows[row][column];
  }
  return matrix;
}
