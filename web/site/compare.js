// Lays another file over a viewer's picture, in the viewer's view, as far as the slider says.
for (const section of document.querySelectorAll('.compare')) compare(section);

function compare(section) {
  const { name, width } = section.dataset;
  const viewer = section.querySelector('istar-viewer');
  const rival = section.querySelector('.rival');
  const image = rival.querySelector('img');
  const slider = section.querySelector('input[type=range]');
  const output = section.querySelector('output');
  const form = section.querySelector('form');
  let view;
  image.style.width = `${width}px`;

  const show = () => {
    const chosen = form.elements.rival;
    const kind = chosen.value;
    const { bytes } = [...section.querySelectorAll('[name=rival]')].find(({ checked }) => checked).dataset;
    const src = `gallery/${name}.${kind}`;
    if (image.getAttribute('src') !== src) image.src = src;
    rival.style.clipPath = `inset(0 0 0 ${slider.value}%)`;
    section.style.setProperty('--split', `${slider.value}%`);
    output.textContent = `IStar ${kb(viewer.dataset.bytes)} | ${kind.toUpperCase()} ${kb(bytes)}${view ? `, at ${zoom(view.scale)}×` : ''}`;
    if (!view) return;
    const { x, y, scale, rotation, flipped } = view;
    const middle = `translate(${viewer.clientWidth / 2}px, ${viewer.clientHeight / 2}px)`;
    const turn = `rotate(${rotation}deg) scale(${flipped ? -scale : scale}, ${scale})`;
    image.style.transform = `${middle} ${turn} translate(${-x}px, ${-y}px)`;
    rival.hidden = false;
  };
  viewer.addEventListener('viewchange', ({ detail }) => {
    view = detail;
    show();
  });
  slider.addEventListener('input', show);
  form.addEventListener('change', show);
  show();
}

function kb(bytes) {
  return `${(bytes / 1000).toFixed(0)} KB`;
}

function zoom(scale) {
  return scale >= 100 ? Math.round(scale) : Number(scale.toPrecision(3));
}
