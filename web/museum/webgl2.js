// Draws the hall with WebGL2. Pictures are drawn by the material's functions, pasted in.
import { ATTRIBUTES, BLANK, CORNER } from './mesh.js';

const HEAD = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
`;

const VERTEX = `${HEAD}
layout(location = 0) in vec3 place;
layout(location = 1) in vec2 light;
layout(location = 2) in vec2 cover;
layout(location = 3) in vec3 color;
uniform mat4 lens;
centroid out vec2 onSheet;
out vec2 onCover;
out vec3 own;
void main() {
  onSheet = light;
  onCover = cover;
  own = color;
  gl_Position = lens * vec4(place, 1.0);
}
`;

/** Less than a step of a colour, so that soft light shows no steps. */
const DITHER = `
vec3 dithered(vec3 color) {
  float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  return color + (noise - 0.5) / 255.0;
}
`;

const SURFACE = `${HEAD}
centroid in vec2 onSheet;
in vec2 onCover;
in vec3 own;
uniform sampler2D sheet;
uniform sampler2D covering;
out vec4 shown;
${DITHER}
void main() {
  shown = vec4(dithered(own * texture(sheet, onSheet).rgb * texture(covering, onCover).rgb), 1.0);
}
`;

/** Left of the split an ordinary texture, its levels and what filters them as the hardware has it. */
const picture = (material) => `${HEAD}
${material}
in vec2 onCover;
in vec3 own;
uniform sampler2D ordinary;
uniform float split;
out vec4 shown;
${DITHER}
void main() {
  vec2 dx = dFdx(onCover);
  vec2 dy = dFdy(onCover);
  vec4 color;
  if (gl_FragCoord.x < split) {
    vec2 size = vec2(textureSize(ordinary, 0) << int(texelFetch(istar_about, ivec2(0), 0).w));
    color = textureGrad(ordinary, onCover / size, dx / size, dy / size);
  } else {
    color = istar_sample(onCover, dx, dy);
  }
  shown = vec4(dithered(own * (color.rgb + 1.0 - color.a)), 1.0);
}
`;

/** Throws where there is no WebGL2. */
export function create(canvas, material, { sheet, meshes, pictures }, covers) {
  const gl = canvas.getContext('webgl2', { antialias: true, alpha: false });
  if (!gl) throw new Error('This browser has no WebGL2.');
  // A renderer on another canvas follows: this context need not be restored.
  const lost = new Promise((resolve) => {
    canvas.addEventListener('webglcontextlost', resolve, { once: true });
  });
  const anisotropic = gl.getExtension('EXT_texture_filter_anisotropic');
  const surfaces = program(gl, SURFACE);
  const framed = program(gl, picture(material));
  const sheetTexture = texture(gl, 'rgba8unorm', [
    { width: sheet.size, height: sheet.size, data: sheet.texels },
  ]);
  const blank = texture(gl, 'rgba8unorm', BLANK);
  const groups = Object.entries(meshes).map(([name, mesh]) => ({
    ...buffers(gl, mesh),
    texture: covers[name] ? imageTexture(gl, covers[name]) : blank,
  }));
  const frames = pictures.map((mesh) => buffers(gl, mesh));
  const [smooth, ordinary, repeated] = [0, 1, 2].map(() => gl.createSampler());
  for (const sampler of [smooth, ordinary, repeated]) {
    gl.samplerParameteri(sampler, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.samplerParameteri(sampler, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    const wrap = sampler === repeated ? gl.REPEAT : gl.CLAMP_TO_EDGE;
    gl.samplerParameteri(sampler, gl.TEXTURE_WRAP_S, wrap);
    gl.samplerParameteri(sampler, gl.TEXTURE_WRAP_T, wrap);
    if (anisotropic && sampler !== smooth) {
      gl.samplerParameterf(sampler, anisotropic.TEXTURE_MAX_ANISOTROPY_EXT, 16);
    }
  }
  /** Of each file its textures, by name. */
  const files = new Map();

  const use = ({ linked, at }, lens) => {
    gl.useProgram(linked);
    gl.uniformMatrix4fv(at('lens'), false, lens);
  };
  const bind = (unit, bound, sampler) => {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, bound);
    gl.bindSampler(unit, sampler);
  };

  return {
    backend: 'WebGL2',
    isHalf: false,
    /** Kept once the browser has taken the context away: then nothing is drawn any longer. */
    lost,
    addFile(name, textures) {
      files.set(
        name,
        textures.map(({ name, format, levels }) => ({ name, format, texture: texture(gl, format, levels) })),
      );
    },
    draw(lens, split, order) {
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.enable(gl.DEPTH_TEST);
      gl.clearColor(0, 0, 0, 1);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      use(surfaces, lens);
      gl.uniform1i(surfaces.at('sheet'), 0);
      gl.uniform1i(surfaces.at('covering'), 1);
      bind(0, sheetTexture, null);
      for (const { array, count, texture } of groups) {
        bind(1, texture, repeated);
        gl.bindVertexArray(array);
        gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_SHORT, 0);
      }
      use(framed, lens);
      gl.uniform1f(framed.at('split'), split);
      for (const [i, name] of order) {
        const textures = files.get(name);
        const mesh = frames[i];
        if (!textures || !mesh) continue;
        for (const [unit, { name, format, texture }] of textures.entries()) {
          gl.uniform1i(framed.at(name), unit);
          bind(unit, texture, format === 'rgba8unorm' ? smooth : null);
        }
        gl.uniform1i(framed.at('ordinary'), textures.length);
        bind(textures.length, textures.at(-1).texture, ordinary);
        gl.bindVertexArray(mesh.array);
        gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_SHORT, 0);
      }
    },
  };
}

function program(gl, fragment) {
  const linked = gl.createProgram();
  for (const [kind, text] of [
    [gl.VERTEX_SHADER, VERTEX],
    [gl.FRAGMENT_SHADER, fragment],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(linked, shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
      throw new Error(gl.getShaderInfoLog(shader) ?? 'lost');
  }
  gl.linkProgram(linked);
  if (!gl.getProgramParameter(linked, gl.LINK_STATUS))
    throw new Error(gl.getProgramInfoLog(linked) ?? 'lost');
  const places = new Map();
  const at = (name) => {
    if (!places.has(name)) places.set(name, gl.getUniformLocation(linked, name));
    return places.get(name);
  };
  return { linked, at };
}

function buffers(gl, { corners, indices }) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
  let from = 0;
  for (const [place, numbers] of ATTRIBUTES.entries()) {
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, numbers, gl.FLOAT, false, 4 * CORNER, 4 * from);
    from += numbers;
  }
  return { array, count: indices.length };
}

/** A texture of the material, or one like it. */
function texture(gl, format, levels) {
  const [internal, channels, type] = {
    r32uint: [gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT],
    rgba32uint: [gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT],
    rgba8unorm: [gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE],
  }[format];
  const made = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(gl.TEXTURE_2D, made);
  const [{ width, height }] = levels;
  gl.texStorage2D(gl.TEXTURE_2D, levels.length, internal, width, height);
  for (const [level, { width, height, data }] of levels.entries()) {
    gl.texSubImage2D(gl.TEXTURE_2D, level, 0, 0, width, height, channels, type, data);
  }
  const filter = format === 'rgba8unorm' ? gl.LINEAR : gl.NEAREST;
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  return made;
}

function imageTexture(gl, levels) {
  const made = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texStorage2D(gl.TEXTURE_2D, levels.length, gl.RGBA8, levels[0].width, levels[0].height);
  for (const [level, image] of levels.entries()) {
    gl.texSubImage2D(gl.TEXTURE_2D, level, 0, 0, gl.RGBA, gl.UNSIGNED_BYTE, image);
  }
  return made;
}
