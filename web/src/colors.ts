/** Hues in degrees up to which a word goes. */
const HUES: readonly [number, string][] = [
  [15, 'red'],
  [45, 'orange'],
  [68, 'yellow'],
  [165, 'green'],
  [200, 'turquoise'],
  [255, 'blue'],
  [290, 'purple'],
  [335, 'pink'],
  [360, 'red'],
];

/** What people call a colour, of 0xRRGGBBAA: `light blue`. For regions that have no name. */
export function colorWord(color: number): string {
  if ((color & 255) < 128) return 'transparent';
  const [red, green, blue] = [24, 16, 8].map((shift) => ((color >>> shift) & 255) / 255) as [
    number,
    number,
    number,
  ];
  const most = Math.max(red, green, blue);
  const spread = most - Math.min(red, green, blue);
  const lightness = most - spread / 2;
  if (lightness > 0.95) return 'white';
  if (lightness < 0.08) return 'black';
  const shade = lightness > 0.75 ? 'light ' : lightness < 0.3 ? 'dark ' : '';
  if (spread < 0.1) return `${shade}grey`;
  const turn =
    most === red
      ? (green - blue) / spread
      : most === green
        ? 2 + (blue - red) / spread
        : 4 + (red - green) / spread;
  const hue = (turn * 60 + 360) % 360;
  const word = HUES.find(([end]) => hue <= end)?.[1] ?? 'red';
  return word === 'orange' && lightness < 0.4 ? 'brown' : shade + word;
}
