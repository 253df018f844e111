// What is under a place of the view.
import { DOOR, PICTURES, ROOMS } from './hall.js';
import { axes, dot, subtract } from './vectors.js';

/** No farther than that, in metres. */
const FAR = 20;

/** The picture at a place of the view, and the place in it; `x` and `y` are -1 to 1, to the right and upwards. */
export function hit(visitor, [x, y], aspect, fovy) {
  const tangent = Math.tan(fovy / 2);
  const { forward, right, up } = axes(visitor);
  const ray = forward.map((n, i) => n + x * tangent * aspect * right[i] + y * tangent * up[i]);
  let best;
  for (const picture of PICTURES) {
    const facing = dot(ray, picture.normal);
    if (facing >= 0) continue;
    const distance = dot(subtract(picture.at, visitor.at), picture.normal) / facing;
    if (distance < 0 || distance > (best?.distance ?? FAR)) continue;
    const way = subtract(along(visitor.at, ray, distance), picture.at);
    const u = dot(way, picture.right) / picture.width + 0.5;
    const v = 0.5 - dot(way, picture.up) / picture.height;
    if (Math.min(u, v) < 0 || Math.max(u, v) > 1 || isBehindWall(visitor.at, ray, distance)) continue;
    const [left, top, end, lower] = picture.part;
    best = { picture, distance, at: [left + u * (end - left), top + v * (lower - top)] };
  }
  return best;
}

const along = (from, ray, distance) => from.map((n, i) => n + distance * ray[i]);

/** Whether a ray goes through a wall between two rooms, elsewhere than through its door. A door is convex: both faces of the wall tell. */
function isBehindWall(from, ray, distance) {
  const faces = ROOMS.slice(1).flatMap(({ near }, i) => [ROOMS[i].far, near]);
  return faces.some((z) => {
    const until = (z - from[2]) / ray[2];
    if (!(until > 0 && until < distance)) return false;
    const [x, y] = along(from, ray, until);
    return Math.abs(x) > DOOR.half || y > DOOR.height;
  });
}
