/** What draws a picture. */
export type Backend = 'webgpu' | 'webgl2' | 'cpu';
export type BackendChoice = Backend | 'auto';

/** The page's address may force a back end (`?backend=webgl2`), for comparing them; else the attribute does. */
export function chosenBackend(attribute: string | null): BackendChoice {
  const forced = new URLSearchParams(location.search).get('backend');
  return [forced, attribute].find(isBackend) ?? 'auto';
}

function isBackend(name: string | null): name is Backend {
  return name === 'webgpu' || name === 'webgl2' || name === 'cpu';
}
