// The page's side of the workers. What goes wrong there is told here, and not by an error that nobody catches.

function worker(file, answered, failed) {
  const made = new Worker(new URL(file, import.meta.url), { type: 'module' });
  made.addEventListener('message', ({ data }) => answered(data));
  made.addEventListener('error', (event) => {
    event.preventDefault();
    // A script that could not be fetched has no message.
    failed(event.message || `${file} could not be run.`);
  });
  return made;
}

/** The hall's meshes and its sheet of light. */
export async function hall() {
  let baker;
  try {
    return await new Promise((resolve, reject) => {
      const fail = (message) => reject(new Error(message));
      baker = worker('baker.js', ({ scene, fault }) => (scene ? resolve(scene) : fail(fault)), fail);
    });
  } finally {
    baker?.terminate();
  }
}

/** Loads pictures by name. `loaded` is called with a picture's name and textures, `failed` with what went wrong. */
export class Loader {
  #worker;
  #asked = new Map();
  #questions = 0;

  constructor(names, loaded, failed) {
    this.#worker = worker(
      'loader.js',
      (data) => {
        if (data.ask) this.#answer(data);
        else if (data.textures) loaded(data.name, data.textures);
        else failed(data.fault);
      },
      (fault) => {
        for (const ask of this.#asked.keys()) this.#answer({ ask, fault });
        failed(fault);
      },
    );
    for (const name of names) {
      const load = new URL(`../gallery/${name}.istar`, import.meta.url).href;
      this.#worker.postMessage({ name, load });
    }
  }

  /** The region at a place of a picture, as `found`; or a `fault`. */
  ask(name, at) {
    const ask = ++this.#questions;
    return new Promise((resolve) => {
      this.#asked.set(ask, resolve);
      this.#worker.postMessage({ ask, name, at });
    });
  }

  #answer(data) {
    this.#asked.get(data.ask)?.(data);
    this.#asked.delete(data.ask);
  }
}
