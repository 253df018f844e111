// For the script of the old kind: where it is from, which it can ask only while it starts. A page may hold its text itself, and a
// server has no page.
const page: Document | undefined = globalThis.document;
const script = page?.currentScript;

export const scriptUrl = (script instanceof Object && 'src' in script && script.src) || page?.baseURI;
