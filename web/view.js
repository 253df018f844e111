// The full-window page: shows ?src=picture.istar.
const src = new URLSearchParams(location.search).get('src') || 'picture.istar';
const name = src.split('/').at(-1) ?? src;
const viewer = document.querySelector('istar-viewer');
document.title = `${name} – IStar`;
viewer.setAttribute('alt', name);
viewer.setAttribute('src', src);
