// Keeps a page and its figures for times without a network. Copy the file beside the page, which says
// <script src="istar-offline.js" defer></script>: it registers itself as a service worker, for its own folder and those in it.
(() => {
  const CACHE = 'istar-offline-1';
  /** Bytes of a file that is kept: a larger one is for those who are connected. */
  const MOST = 64 * 1024 * 1024;

  if ('ServiceWorkerGlobalScope' in globalThis) work();
  else if (navigator.serviceWorker) register(document.currentScript.src).catch(console.warn);

  /** In the page: tells the worker what was fetched before it was there. */
  async function register(script) {
    const { serviceWorker } = navigator;
    await serviceWorker.register(script);
    const { active } = await serviceWorker.ready;
    const tell = (urls) => active.postMessage(urls);
    tell([location.href]);
    const observer = new PerformanceObserver((list) => tell(list.getEntries().map(({ name }) => name)));
    observer.observe({ type: 'resource', buffered: true });
  }

  function work() {
    addEventListener('install', () => skipWaiting());
    addEventListener('activate', (event) => event.waitUntil(clients.claim()));
    addEventListener('message', (event) => event.waitUntil(Promise.all(event.data.map((url) => keep(url)))));
    addEventListener('fetch', (event) => {
      const { method, url } = event.request;
      if (method === 'GET' && isOwn(url)) event.respondWith(answer(event));
    });
  }

  const isOwn = (url) => new URL(url).origin === location.origin;
  const named = (url) => url.split('#')[0];
  const underWay = new Map();

  /** Fetches a file as a whole, once at a time, and keeps it. */
  function keep(url, version) {
    const name = named(url);
    if (!underWay.has(name))
      underWay.set(
        name,
        fetchWhole(name, version).finally(() => underWay.delete(name)),
      );
    return underWay.get(name);
  }

  /** Unless it is there in the same version, or another's, or too large. */
  async function fetchWhole(url, version) {
    try {
      if (!isOwn(url)) return;
      const cache = await caches.open(CACHE);
      const kept = await cache.match(url);
      if (kept && (!version || versionOf(kept) === version)) return;
      const response = await fetch(url);
      if (response.status !== 200 || Number(response.headers.get('content-length')) > MOST) return;
      // Not every server tells how long a file is.
      if ((await response.clone().blob()).size <= MOST) await cache.put(url, response);
    } catch {
      // Another time.
    }
  }

  const versionOf = ({ headers }) => headers.get('etag') ?? headers.get('last-modified');

  /** From the network, else what is kept. */
  async function answer(event) {
    const { request } = event;
    try {
      const response = await fetch(request);
      if (response.ok) event.waitUntil(keep(request.url, versionOf(response)));
      if (response.status < 500) return response;
      return (await fromCache(request)) ?? response;
    } catch (cause) {
      const kept = await fromCache(request);
      if (kept) return kept;
      throw cause;
    }
  }

  async function fromCache(request) {
    const kept = await caches.match(named(request.url), { cacheName: CACHE });
    const range = /^bytes=(\d+)-(\d*)$/.exec(request.headers.get('range') ?? '');
    if (!kept || !range) return kept;
    // A cache holds whole files only.
    const bytes = await kept.blob();
    const from = Number(range[1]);
    const to = Math.min(range[2] ? Number(range[2]) + 1 : bytes.size, bytes.size);
    if (from >= bytes.size) return new Response(null, { status: 416 });
    const headers = new Headers(kept.headers);
    headers.set('content-range', `bytes ${from}-${to - 1}/${bytes.size}`);
    headers.set('content-length', String(to - from));
    return new Response(bytes.slice(from, to), { status: 206, headers });
  }
})();
