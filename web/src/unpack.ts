/** A module of wasm that was packed and written as text, as if it had been fetched. */
export async function unpacked(text: string): Promise<Response> {
  const packed = new Blob([Uint8Array.from(atob(text), (char) => char.charCodeAt(0))]);
  const bytes = packed.stream().pipeThrough(new DecompressionStream('deflate-raw'));
  return new Response(bytes, { headers: { 'content-type': 'application/wasm' } });
}
