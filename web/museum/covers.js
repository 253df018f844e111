// What covers the floor, and the cards beside the pictures, drawn with the canvas. Of each all levels, each half as large.
import { HUNG } from './hall.js';
import { CARDS } from './mesh.js';

const FLOOR = 1024;
/** Planks across a repeat, and pieces along one. */
const PLANKS = 12;

function canvas(width, height) {
  return Object.assign(document.createElement('canvas'), { width, height });
}

function levels(image) {
  const all = [image];
  for (let last = image; last.width > 1 || last.height > 1; last = all.at(-1)) {
    const next = canvas(Math.max(last.width >> 1, 1), Math.max(last.height >> 1, 1));
    const context = next.getContext('2d');
    context.imageSmoothingQuality = 'high';
    context.drawImage(last, 0, 0, next.width, next.height);
    all.push(next);
  }
  return all;
}

/** Oak planks that repeat. */
export function floor() {
  const image = canvas(FLOOR, FLOOR);
  const context = image.getContext('2d');
  let seed = 7;
  const random = () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 2 ** 32;
  };
  const width = FLOOR / PLANKS;
  for (let plank = 0; plank < PLANKS; plank++) {
    const shift = random() * FLOOR;
    const lengths = [0.38, 0.62].map((share) => share * FLOOR);
    let along = 0;
    for (const length of lengths) {
      const tone = 0.86 + 0.2 * random();
      const [x, y] = [plank * width, shift + along];
      // Twice, since it goes on at the other end.
      for (const top of [y, y - FLOOR]) {
        context.fillStyle = `rgb(${[156, 122, 88].map((channel) => channel * tone).join(' ')})`;
        context.fillRect(x, top, width, length);
        context.fillStyle = 'rgb(40 26 16 / 0.55)';
        context.fillRect(x, top, 1.5, length);
        context.fillRect(x, top, width, 1.5);
      }
      for (let i = 0; i < 26; i++) {
        const [from, long, at] = [random() * length, (0.2 + 0.5 * random()) * length, x + random() * width];
        context.strokeStyle = `rgb(60 38 20 / ${0.05 + 0.1 * random()})`;
        context.lineWidth = 0.6 + 1.2 * random();
        for (const top of [y, y - FLOOR]) {
          context.beginPath();
          context.moveTo(at, top + from);
          context.bezierCurveTo(
            at + 3,
            top + from + long / 3,
            at - 3,
            top + from + (2 * long) / 3,
            at,
            top + Math.min(from + long, length),
          );
          context.stroke();
        }
      }
      along += length;
    }
  }
  return levels(image);
}

/** The cards of the pictures on walls. */
export function cards() {
  const [width, height] = [512, 256];
  const image = canvas(width * CARDS.columns, height * CARDS.rows);
  const context = image.getContext('2d');
  for (const [i, { title, note, file }] of HUNG.entries()) {
    const [x, y] = [(i % CARDS.columns) * width, Math.floor(i / CARDS.columns) * height];
    context.fillStyle = '#fbfaf7';
    context.fillRect(x, y, width, height);
    context.fillStyle = '#22211f';
    context.font = '600 40px Georgia, "Times New Roman", serif';
    context.fillText(title, x + 32, y + 76, width - 64);
    context.font = '26px system-ui, sans-serif';
    context.fillStyle = '#55524c';
    context.fillText(note, x + 32, y + 128, width - 64);
    context.fillText(`${file}.istar`, x + 32, y + 206, width - 64);
  }
  return levels(image);
}
