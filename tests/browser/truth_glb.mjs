// An OBJ and its image as one GLB: the same material and the same filters as pointbake writes, so
// that only the layout, its texels and the mesh differ.
import { readFile } from 'node:fs/promises';
import path from 'node:path';

const kFloat = 5126, kUint = 5125, kVertices = 34962, kIndices = 34963;
const kLinear = 9729, kLinearMipmapLinear = 9987, kClampToEdge = 33071, kRepeat = 10497;

// Positions, texture coordinates (v down, as glTF has them) and corners; polygons become fans.
function read_obj(text) {
  const places = [], uvs = [];
  const mesh = { positions: [], uvs: [], corners: [] };
  const known = new Map();
  const vertex = (corner) => {
    if (known.has(corner)) return known.get(corner);
    const [v, vt] = corner.split('/').map((n) => parseInt(n, 10) - 1);
    mesh.positions.push(...places[v]);
    mesh.uvs.push(uvs[vt][0], 1 - uvs[vt][1]);
    known.set(corner, known.size);
    return known.size - 1;
  };
  for (const line of text.split('\n')) {
    const [kind, ...rest] = line.trim().split(/\s+/);
    if (kind === 'v') places.push(rest.slice(0, 3).map(Number));
    if (kind === 'vt') uvs.push(rest.slice(0, 2).map(Number));
    if (kind !== 'f') continue;
    const polygon = rest.map(vertex);
    for (let i = 2; i < polygon.length; ++i) mesh.corners.push(polygon[0], polygon[i - 1], polygon[i]);
  }
  return mesh;
}

const padded = (bytes, fill) => Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);

function chunk(type, bytes, fill) {
  const body = padded(bytes, fill);
  const head = Buffer.alloc(8);
  head.writeUInt32LE(body.length, 0);
  head.write(type, 4, 'latin1');
  return Buffer.concat([head, body]);
}

// The bounds that glTF wants of positions, as floats.
function bounds(positions) {
  const min = [Infinity, Infinity, Infinity], max = [-Infinity, -Infinity, -Infinity];
  positions.forEach((x, i) => {
    min[i % 3] = Math.min(min[i % 3], x);
    max[i % 3] = Math.max(max[i % 3], x);
  });
  return { min, max };
}

export async function glb_of_obj(file) {
  const text = await readFile(file, 'utf8');
  const library = path.join(path.dirname(file), /^mtllib\s+(.+?)\s*$/m.exec(text)[1]);
  const images = [...(await readFile(library, 'utf8')).matchAll(/^map_Kd\s+(.+?)\s*$/gm)];
  if (images.length !== 1) throw new Error(`${library}: ${images.length} images, 1 is expected`);
  const image = path.join(path.dirname(library), images[0][1]);

  const mesh = read_obj(text);
  const positions = new Float32Array(mesh.positions), uvs = new Float32Array(mesh.uvs);
  const wrap = mesh.uvs.some((x) => x < 0 || x > 1) ? kRepeat : kClampToEdge;
  const parts = [Buffer.from(positions.buffer), Buffer.from(uvs.buffer),
                 Buffer.from(new Uint32Array(mesh.corners).buffer), await readFile(image)];
  let byteOffset = 0;
  const bufferViews = parts.map((part, i) => {
    const view = { buffer: 0, byteOffset, byteLength: part.length };
    if (i < 3) view.target = i === 2 ? kIndices : kVertices;
    byteOffset += padded(part, 0).length;
    return view;
  });
  const json = {
    asset: { version: '2.0' },
    extensionsUsed: ['KHR_materials_unlit'],
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 0 }] }],
    accessors: [
      { bufferView: 0, componentType: kFloat, count: positions.length / 3, type: 'VEC3', ...bounds(positions) },
      { bufferView: 1, componentType: kFloat, count: uvs.length / 2, type: 'VEC2' },
      { bufferView: 2, componentType: kUint, count: mesh.corners.length, type: 'SCALAR' },
    ],
    materials: [{ pbrMetallicRoughness: { baseColorTexture: { index: 0 } }, doubleSided: true,
                  extensions: { KHR_materials_unlit: {} } }],
    textures: [{ sampler: 0, source: 0 }],
    samplers: [{ magFilter: kLinear, minFilter: kLinearMipmapLinear, wrapS: wrap, wrapT: wrap }],
    images: [{ bufferView: 3, mimeType: /\.png$/i.test(image) ? 'image/png' : 'image/jpeg' }],
    bufferViews,
    buffers: [{ byteLength: byteOffset }],
  };
  const chunks = [chunk('JSON', Buffer.from(JSON.stringify(json)), ' '),
                  chunk('BIN\0', Buffer.concat(parts.map((part) => padded(part, 0))), 0)];
  const head = Buffer.alloc(12);
  head.write('glTF', 0, 'latin1');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([head, ...chunks]);
}
