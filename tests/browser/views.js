// What the page draws: models with the sampler that their file asks for, and with none at all
// (level 0, many samples per pixel), which is what they should look like.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

export const kSide = 512;  // of a picture, in pixels; at the nearest distance the model fills it
const kSamples = 4096;     // of the reference's side: 8 x 8 per pixel when near, 150 x 150 from afar
const kFov = 30, kSine = Math.sin(THREE.MathUtils.degToRad(kFov / 2));
const kBackground = 0x808080;  // grey, far from magenta
export const kAnisotropy = { trilinear: 1, 'anisotropic 16x': 16 };

const renderer = new THREE.WebGLRenderer({ antialias: false });  // only inner pixels are compared
renderer.setPixelRatio(1);
renderer.setSize(kSide, kSide);  // sRGB output and no tone mapping are three's defaults
document.body.append(renderer.domElement);
if (renderer.capabilities.getMaxAnisotropy() < 16) throw new Error('no 16x anisotropic filter here');

const camera = new THREE.PerspectiveCamera(kFov, 1);

// Colours of level 0 in linear light; alpha holds the depth, 0 stays for what is not covered.
function plain_material(material) {
  const map = material.map.clone();
  map.minFilter = map.magFilter = THREE.LinearFilter;
  map.generateMipmaps = false;
  const plain = new THREE.MeshBasicMaterial({ map, side: material.side });
  plain.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace('#include <dithering_fragment>',
      'gl_FragColor.a = 0.5 + 0.5 * gl_FragCoord.z;');
  };
  return plain;
}

// A GLB as a scene, the way any page loads it: only the anisotropy is ours.
export async function load(url) {
  const { scene } = await new GLTFLoader().loadAsync(url);
  const meshes = [];
  scene.traverse((node) => { if (node.isMesh) meshes.push(node); });
  for (const mesh of meshes) {
    const { material } = mesh;
    if (!material.isMeshBasicMaterial || !material.map) throw new Error(`${url}: not unlit with a texture`);
    if (material.map.minFilter !== THREE.LinearMipmapLinearFilter)
      throw new Error(`${url}: its sampler asks for no mip levels`);
    mesh.userData.materials = { plain: plain_material(material) };
    for (const [filter, anisotropy] of Object.entries(kAnisotropy)) {
      const filtered = material.clone();
      filtered.map = material.map.clone();
      filtered.map.anisotropy = anisotropy;
      mesh.userData.materials[filter] = filtered;
    }
  }
  const root = new THREE.Scene();
  root.add(scene);
  root.updateMatrixWorld(true);
  return { root, meshes };
}

export function dispose(model) {
  for (const mesh of model.meshes) {
    mesh.geometry.dispose();
    for (const material of Object.values(mesh.userData.materials)) {
      material.map.dispose();
      material.dispose();
    }
  }
}

// The middle of the box, and the farthest vertex from it.
export function sphere_of(model) {
  const center = new THREE.Box3().setFromObject(model.root, true).getCenter(new THREE.Vector3());
  let radius = 0;
  const place = new THREE.Vector3();
  for (const mesh of model.meshes) {
    const { position } = mesh.geometry.attributes;
    for (let i = 0; i < position.count; ++i) {
      place.fromBufferAttribute(position, i).applyMatrix4(mesh.matrixWorld);
      radius = Math.max(radius, place.distanceTo(center));
    }
  }
  return { center, radius };
}

// Even over the sphere, none of them along an axis.
export function directions(count) {
  return Array.from({ length: count }, (_, i) => {
    const y = 1 - (2 * i + 1) / count, angle = i * Math.PI * (3 - Math.sqrt(5));
    return new THREE.Vector3(Math.cos(angle), 0, Math.sin(angle)).multiplyScalar(Math.sqrt(1 - y * y)).setY(y);
  });
}

// `times` 1: the sphere touches the picture's sides. Returns the side of the square of pixels in the
// middle that the sphere covers.
export function look(sphere, direction, times) {
  const distance = times * sphere.radius / kSine;
  camera.near = distance - 1.01 * sphere.radius;
  camera.far = distance + 1.01 * sphere.radius;
  camera.position.copy(direction).multiplyScalar(distance).add(sphere.center);
  camera.lookAt(sphere.center);
  camera.clearViewOffset();
  camera.updateProjectionMatrix();
  const part = Math.tan(Math.asin(kSine / times)) / Math.tan(Math.asin(kSine));
  return Math.min(kSide, 2 * Math.ceil(part * kSide / 2 + 1));
}

export const is_background = (pixels, p) => [0, 1, 2].every((c) => pixels[p + c] === (kBackground & 255));

function use(model, name) {
  for (const mesh of model.meshes) mesh.material = mesh.userData.materials[name];
}

// The square's pixels as the page shows them: RGBA bytes, from the bottom up.
export function shown(model, filter, side) {
  use(model, filter);
  renderer.setRenderTarget(null);
  renderer.setClearColor(kBackground, 1);
  renderer.render(model.root, camera);
  const pixels = new Uint8Array(4 * side * side);
  const gl = renderer.getContext(), corner = (kSide - side) / 2;
  gl.readPixels(corner, corner, side, side, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  return pixels;
}

// Means of count x count samples; alpha is 0 if one of them is not covered.
const averaging = new THREE.ShaderMaterial({
  glslVersion: THREE.GLSL3,
  uniforms: { samples: { value: null }, count: { value: 0 } },
  vertexShader: 'void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }',
  fragmentShader: `
    uniform highp sampler2D samples;
    uniform int count;
    out highp vec4 mean;
    void main() {
      ivec2 corner = ivec2(gl_FragCoord.xy) * count;
      highp vec4 sum = vec4(0.0);
      bool is_covered = true;
      for (int y = 0; y < count; ++y) {
        highp vec4 row = vec4(0.0);
        for (int x = 0; x < count; ++x) {
          highp vec4 s = texelFetch(samples, corner + ivec2(x, y), 0);
          is_covered = is_covered && s.a > 0.0;
          row += s;
        }
        sum += row;
      }
      mean = sum / float(count * count);
      if (!is_covered) mean.a = 0.0;
    }`,
  depthTest: false,
});
const averaging_scene = new THREE.Scene();
averaging_scene.add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), averaging));
averaging_scene.children[0].frustumCulled = false;

// The square's pixels as they should be: linear light, and the mean depth (0.5 to 1) as alpha.
export function ideal(model, side) {
  const count = Math.floor(kSamples / side);
  const samples = new THREE.WebGLRenderTarget(count * side, count * side,
    { type: THREE.HalfFloatType, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
  const means = new THREE.WebGLRenderTarget(side, side, { type: THREE.FloatType, depthBuffer: false });
  use(model, 'plain');
  const corner = (kSide - side) / 2;
  camera.setViewOffset(kSide, kSide, corner, corner, side, side);
  renderer.setClearColor(0, 0);
  renderer.setRenderTarget(samples);
  renderer.render(model.root, camera);
  camera.clearViewOffset();

  averaging.uniforms.samples.value = samples.texture;
  averaging.uniforms.count.value = count;
  renderer.setRenderTarget(means);
  renderer.render(averaging_scene, camera);
  const pixels = new Float32Array(4 * side * side);
  renderer.readRenderTargetPixels(means, 0, 0, side, side, pixels);
  renderer.setRenderTarget(null);
  samples.dispose();
  means.dispose();
  return pixels;
}
