import {
  AmbientLight, BufferAttribute, BufferGeometry, DataTexture, DirectionalLight, DoubleSide, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

const canvas = document.querySelector("canvas"), renderer = new WebGLRenderer({ canvas, antialias: false });
renderer.setSize(1066, 532, false);
renderer.setClearColor(0xffffff);
const scene = new Scene(), camera = new PerspectiveCamera(32, 1066 / 532, 0.1, 10);
camera.up.set(0, 0, 1);
camera.position.set(1, -1.7, 1);
new OrbitControls(camera, canvas);
camera.lookAt(0, 0, 0);
const geometry = new BufferGeometry(), triangles = [];
const positions = new BufferAttribute(ref.slice(), 3), places = new BufferAttribute(new Float32Array(2 * P), 2);
geometry.setAttribute("position", positions);
geometry.setAttribute("uv", places);
for (let q = 0; q < quads.length; q += 4) triangles.push(quads[q], quads[q + 1], quads[q + 2], quads[q], quads[q + 2], quads[q + 3]);
geometry.setIndex(triangles);
const colours = new Uint8Array(4 * 256);
for (let i = 0; i < 256; i++) colours.set([i, 128, 255 - i, 255], 4 * i);
const map = new DataTexture(colours, 256, 1);
map.needsUpdate = true;
scene.add(new Mesh(geometry, new MeshLambertMaterial({ map, side: DoubleSide, flatShading: true })), new AmbientLight(0xffffff, 1), camera);
camera.add(new DirectionalLight(0xffffff, 2));
loop((t) => {
  for (let p = 0; p < P; p++) {
    positions.array[3 * p + 2] = zs[t][p];
    places.array[2 * p] = zs[t][p] * 2.5 + 0.5;
  }
  positions.needsUpdate = places.needsUpdate = true;
  renderer.render(scene, camera);
});
