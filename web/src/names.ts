// What a file's regions are called. A module of its own, fetched only for files that tell: dist/istar-names.js.

/** Bytes of the header: before the root of the directory. */
const HEADER = 40;

/** The names in a file's head, which is there as a whole, by colour as 0xRRGGBBAA. Of a damaged table as many as can be read. */
export function readNames(head: Uint8Array): Map<number, string> {
  const names = new Map<number, string>();
  let at = HEADER;
  const byte = () => head[at++] ?? 0;
  const varint = () => {
    let value = 0;
    // No more than 32 bits.
    for (let scale = 1; scale < 2 ** 32; scale *= 128) {
      const next = byte();
      value += (next & 127) * scale;
      if (next < 128) break;
    }
    return value;
  };
  const text = new TextDecoder();
  // The number of regions.
  varint();
  for (let chunks = varint(); chunks > 0 && at < head.length; chunks--) {
    const tag = text.decode(head.subarray(at, at + 4));
    at += 4;
    const length = varint();
    const end = at + length;
    if (tag === 'name') {
      for (let count = varint(); count > 0 && at < end; count--) {
        const color = ((byte() << 24) | (byte() << 16) | (byte() << 8) | byte()) >>> 0;
        const bytes = varint();
        names.set(color, text.decode(head.subarray(at, at + bytes)));
        at += bytes;
      }
      return names;
    }
    at = end;
  }
  return names;
}
