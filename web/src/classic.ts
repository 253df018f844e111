// For the script of the old kind: where it is from, which it can ask only while it starts. A page may hold its text itself.
const script = document.currentScript;

export const scriptUrl = (script instanceof HTMLScriptElement && script.src) || document.baseURI;
