/** What is said in the page's language, by the English text. */
export type Words = Readonly<Record<string, string>>;

let words: Words = {};

export function setWords(next: Words): void {
  words = next;
}

export function wordsNow(): Words {
  return words;
}

/** A text in the page's language; English where it has none. What is in {braces} is put in. */
export function say(text: string, values: Record<string, string | number> = {}): string {
  return String(words[text] ?? text).replace(/\{(\w+)\}/g, (brace, name) => String(values[name] ?? brace));
}
