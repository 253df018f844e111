/** What a canvas shows, in a format for pictures of pixels. */
export function blobOf(
  canvas: HTMLCanvasElement,
  { type, quality }: { type?: string; quality?: number },
): Promise<Blob> {
  return new Promise((resolve, reject) => {
    const give = (blob: Blob | null) => (blob ? resolve(blob) : reject(new Error('The view is empty.')));
    canvas.toBlob(give, type, quality);
  });
}
