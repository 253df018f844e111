import theme from './theme.css';

/** A new element with a class, for parts of the shadow tree. Pages reach it by the same name, with `::part`. */
export function make<Name extends keyof HTMLElementTagNameMap>(
  name: Name,
  part: string,
  ...children: (Node | string)[]
): HTMLElementTagNameMap[Name] {
  const element = document.createElement(name);
  element.className = part;
  element.setAttribute('part', part);
  element.append(...children);
  return element;
}

/** A place for what the page puts inside the element with `slot="…"`; without, for the rest; and what is there else. */
export function slot(name: string, ...content: Node[]): HTMLSlotElement {
  return Object.assign(make('slot', '', ...content), { name });
}

/** As CSS has it, of a colour as 0xRRGGBBAA. */
export function cssColor(color: number): string {
  return `#${color.toString(16).padStart(8, '0')}`;
}

/** A sheet for the shadow trees of an element. Adopted, because a strict content security policy refuses a style element. */
export function sheetOf(css: string): CSSStyleSheet {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(css + theme);
  return sheet;
}

/** Gives people a file to keep. */
export function download(file: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(file);
  link.download = name;
  link.click();
  // Once the browser has taken it.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
