// The same with WebGPU.
import { ATTRIBUTES, BLANK, CORNER } from './mesh.js';

const SAMPLES = 4;

const COMMON = `
struct Seen { lens: mat4x4<f32>, split: vec4<f32> }
@group(0) @binding(0) var<uniform> seen: Seen;
struct Corner {
  @builtin(position) position: vec4<f32>,
  @location(0) @interpolate(perspective, centroid) light: vec2<f32>,
  @location(1) cover: vec2<f32>,
  @location(2) color: vec3<f32>,
}
@vertex fn place(
  @location(0) at: vec3<f32>,
  @location(1) light: vec2<f32>,
  @location(2) cover: vec2<f32>,
  @location(3) color: vec3<f32>,
) -> Corner {
  return Corner(seen.lens * vec4(at, 1.0), light, cover, color);
}
// Less than a step of a colour, so that soft light shows no steps.
fn dithered(color: vec3<f32>, at: vec2<f32>) -> vec4<f32> {
  let noise = fract(52.9829189 * fract(dot(at, vec2(0.06711056, 0.00583715))));
  return vec4(color + (noise - 0.5) / 255.0, 1.0);
}
`;

const SURFACE = `${COMMON}
@group(1) @binding(0) var sheet: texture_2d<f32>;
@group(1) @binding(1) var covering: texture_2d<f32>;
@group(0) @binding(1) var smooth_sampler: sampler;
@group(0) @binding(2) var repeated: sampler;
@fragment fn paint(corner: Corner) -> @location(0) vec4<f32> {
  let light = textureSample(sheet, smooth_sampler, corner.light).rgb;
  let cover = textureSample(covering, repeated, corner.cover).rgb;
  return dithered(corner.color * light * cover, corner.position.xy);
}
`;

/** Left of the split an ordinary texture. */
const picture = (material) => `${COMMON}
${material}
@group(0) @binding(1) var ordinary: sampler;
@fragment fn paint(corner: Corner) -> @location(0) vec4<f32> {
  let dx = dpdx(corner.cover);
  let dy = dpdy(corner.cover);
  var color: vec4<f32>;
  if corner.position.x < seen.split.x {
    let texel = f32(1u << textureLoad(istar_about, vec2(0u), 0).w);
    let size = vec2<f32>(textureDimensions(istar_colors, 0)) * texel;
    color = textureSampleGrad(istar_colors, ordinary, corner.cover / size, dx / size, dy / size);
  } else {
    color = istar_sample(corner.cover, dx, dy);
  }
  return dithered(corner.color * (color.rgb + 1.0 - color.a), corner.position.xy);
}
`;

/** Throws where there is no WebGPU. */
export async function create(canvas, material, { sheet, meshes, pictures }, covers) {
  const adapter = await navigator.gpu?.requestAdapter();
  if (!adapter) throw new Error('This browser has no WebGPU.');
  const device = await adapter.requestDevice();
  const format = navigator.gpu.getPreferredCanvasFormat();
  const surfaces = await pipeline(device, SURFACE, format);
  const framed = await pipeline(device, picture(material), format);
  // A canvas that has had one kind of context has no other: only now.
  const context = canvas.getContext('webgpu');
  context.configure({ device, format, alphaMode: 'opaque' });

  const linear = { minFilter: 'linear', magFilter: 'linear', mipmapFilter: 'linear' };
  const repeat = { addressModeU: 'repeat', addressModeV: 'repeat' };
  const [smooth, ordinary, repeated] = [
    device.createSampler(linear),
    device.createSampler({ ...linear, maxAnisotropy: 16 }),
    device.createSampler({ ...linear, ...repeat, maxAnisotropy: 16 }),
  ];
  const uniforms = device.createBuffer({ size: 80, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
  const bound = (pipeline, group, resources) =>
    device.createBindGroup({
      layout: pipeline.getBindGroupLayout(group),
      entries: resources.map((resource, binding) => ({ binding, resource })),
    });
  const buffer = { buffer: uniforms };
  const seenSurfaces = bound(surfaces, 0, [buffer, smooth, repeated]);
  const seenPictures = bound(framed, 0, [buffer, ordinary]);
  const sheetTexture = texture(device, 'rgba8unorm', [
    { width: sheet.size, height: sheet.size, data: sheet.texels },
  ]);
  const blank = texture(device, 'rgba8unorm', BLANK);
  const groups = Object.entries(meshes).map(([name, mesh]) => {
    const cover = covers[name] ? imageTexture(device, covers[name]) : blank;
    return {
      ...buffers(device, mesh),
      covering: bound(surfaces, 1, [sheetTexture.createView(), cover.createView()]),
    };
  });
  const frames = pictures.map((mesh) => buffers(device, mesh));
  const files = new Map();
  let depth;
  let drawn;

  return {
    backend: 'WebGPU',
    isHalf: true,
    /** Kept once the device is gone, unless it was destroyed on purpose: then nothing is drawn any longer. */
    lost: new Promise((resolve) => {
      device.lost.then(({ reason }) => {
        if (reason !== 'destroyed') resolve();
      });
    }),
    addFile(name, textures) {
      const views = textures.map(({ format, levels }) => texture(device, format, levels).createView());
      files.set(name, bound(framed, 1, [...views, smooth]));
    },
    draw(lens, split, order) {
      const size = [canvas.width, canvas.height];
      if (depth?.width !== size[0] || depth?.height !== size[1]) {
        depth?.destroy();
        drawn?.destroy();
        const usage = GPUTextureUsage.RENDER_ATTACHMENT;
        depth = device.createTexture({ size, format: 'depth24plus', sampleCount: SAMPLES, usage });
        drawn = device.createTexture({ size, format, sampleCount: SAMPLES, usage });
      }
      device.queue.writeBuffer(uniforms, 0, new Float32Array([...lens, split, 0, 0, 0]));
      const encoder = device.createCommandEncoder();
      const pass = encoder.beginRenderPass({
        colorAttachments: [
          {
            view: drawn.createView(),
            resolveTarget: context.getCurrentTexture().createView(),
            clearValue: [0, 0, 0, 1],
            loadOp: 'clear',
            storeOp: 'discard',
          },
        ],
        depthStencilAttachment: {
          view: depth.createView(),
          depthClearValue: 1,
          depthLoadOp: 'clear',
          depthStoreOp: 'discard',
        },
      });
      const paint = ({ corners, indices, count }) => {
        pass.setVertexBuffer(0, corners);
        pass.setIndexBuffer(indices, 'uint16');
        pass.drawIndexed(count);
      };
      pass.setPipeline(surfaces);
      pass.setBindGroup(0, seenSurfaces);
      for (const group of groups) {
        pass.setBindGroup(1, group.covering);
        paint(group);
      }
      pass.setPipeline(framed);
      pass.setBindGroup(0, seenPictures);
      for (const [i, name] of order) {
        const tables = files.get(name);
        if (!tables) continue;
        pass.setBindGroup(1, tables);
        paint(frames[i]);
      }
      pass.end();
      device.queue.submit([encoder.finish()]);
    },
  };
}

function pipeline(device, code, format) {
  const module = device.createShaderModule({ code });
  let from = 0;
  const attributes = ATTRIBUTES.map((numbers, shaderLocation) => {
    const attribute = { shaderLocation, offset: 4 * from, format: `float32x${numbers}` };
    from += numbers;
    return attribute;
  });
  return device.createRenderPipelineAsync({
    layout: 'auto',
    vertex: { module, buffers: [{ arrayStride: 4 * CORNER, attributes }] },
    fragment: { module, targets: [{ format }] },
    primitive: { topology: 'triangle-list' },
    depthStencil: { format: 'depth24plus', depthWriteEnabled: true, depthCompare: 'less' },
    multisample: { count: SAMPLES },
  });
}

function buffers(device, { corners, indices }) {
  const made = (data, usage) => {
    const buffer = device.createBuffer({
      size: Math.ceil(data.byteLength / 4) * 4,
      usage,
      mappedAtCreation: true,
    });
    new data.constructor(buffer.getMappedRange()).set(data);
    buffer.unmap();
    return buffer;
  };
  return {
    corners: made(corners, GPUBufferUsage.VERTEX),
    indices: made(indices, GPUBufferUsage.INDEX),
    count: indices.length,
  };
}

/** A texture of the material, or one like it. */
function texture(device, format, levels) {
  const [{ width, height }] = levels;
  const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST;
  const made = device.createTexture({ size: [width, height], mipLevelCount: levels.length, format, usage });
  for (const [mipLevel, { width, height, data }] of levels.entries()) {
    const bytesPerRow = data.byteLength / height;
    device.queue.writeTexture({ texture: made, mipLevel }, data, { bytesPerRow }, [width, height]);
  }
  return made;
}

function imageTexture(device, levels) {
  const size = [levels[0].width, levels[0].height];
  const usage =
    GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST | GPUTextureUsage.RENDER_ATTACHMENT;
  const made = device.createTexture({ size, mipLevelCount: levels.length, format: 'rgba8unorm', usage });
  for (const [mipLevel, source] of levels.entries()) {
    device.queue.copyExternalImageToTexture({ source }, { texture: made, mipLevel }, [
      source.width,
      source.height,
    ]);
  }
  return made;
}
