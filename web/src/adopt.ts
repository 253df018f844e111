/** Of the modules that are fetched later: one for all figures. */
const sheets = new Map<string, CSSStyleSheet>();

/** Adds styles to a figure, before the sheet that hides what is hidden. */
export function adopt(root: ShadowRoot, css: string): void {
  const sheet = sheets.get(css) ?? new CSSStyleSheet();
  if (!sheets.has(css)) sheet.replaceSync(css);
  sheets.set(css, sheet);
  root.adoptedStyleSheets = [sheet, ...root.adoptedStyleSheets];
}
