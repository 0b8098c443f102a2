// Runs in the browser: loads /model.glb as a user's page would, draws it, says what it found.
import * as THREE from 'three';
import {RoomEnvironment} from 'three/examples/jsm/environments/RoomEnvironment.js';
import {DRACOLoader} from 'three/examples/jsm/loaders/DRACOLoader.js';
import {GLTFLoader} from 'three/examples/jsm/loaders/GLTFLoader.js';

const kBackground = 0xe8ebef;

function makeRenderer(width, height) {
  const renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.setPixelRatio(2);
  renderer.setSize(width, height);
  renderer.toneMapping = THREE.NeutralToneMapping;
  renderer.shadowMap.enabled = true;
  document.body.append(renderer.domElement);
  return renderer;
}

// A soft room for reflections and a low sun from the left, which shows every stair on a slope.
function light(scene, renderer, sphere, camera) {
  const rooms = new THREE.PMREMGenerator(renderer);
  scene.environment = rooms.fromScene(new RoomEnvironment(), 0.04).texture;
  scene.environmentIntensity = 0.55;
  const sun = new THREE.DirectionalLight(0xfff4e2, 2.4);
  const sideways = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
  const towards = camera.position.clone().sub(sphere.center).setY(0).normalize();
  sun.position.copy(sphere.center)
      .addScaledVector(sideways, -1.9 * sphere.radius)
      .addScaledVector(towards, 0.35 * sphere.radius);
  sun.position.y += 1.15 * sphere.radius;
  sun.target.position.copy(sphere.center);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.normalBias = sphere.radius * 0.004;
  sun.shadow.bias = -0.0006;
  Object.assign(sun.shadow.camera, {
    left: -sphere.radius, right: sphere.radius, top: sphere.radius, bottom: -sphere.radius,
    near: 0.1 * sphere.radius, far: 4 * sphere.radius,
  });
  scene.add(sun, sun.target);
}

function verticesOf(model) {
  const points = [];
  model.updateMatrixWorld(true);
  model.traverse((object) => {
    if (!object.isMesh) return;
    const {position} = object.geometry.attributes;
    for (let v = 0; v < position.count; ++v)
      points.push(new THREE.Vector3().fromBufferAttribute(position, v)
                      .applyMatrix4(object.matrixWorld));
  });
  return points;
}

// Turned as asked, the model in the middle and as large as fits, then `zoom` times nearer.
function placeCamera(model, sphere, {angle, elevation, zoom, width, height}) {
  const camera = new THREE.PerspectiveCamera(28, width / height, 0.01, 1e5);
  const azimuth = THREE.MathUtils.degToRad(angle);
  const rise = THREE.MathUtils.degToRad(elevation);
  const away = new THREE.Vector3(Math.sin(azimuth) * Math.cos(rise), Math.sin(rise),
                                 Math.cos(azimuth) * Math.cos(rise));
  const points = verticesOf(model);
  const target = sphere.center.clone();
  let distance = 4 * sphere.radius;
  const aim = () => {
    camera.position.copy(target).addScaledVector(away, distance);
    camera.near = distance / 100;
    camera.far = distance + 4 * sphere.radius;
    camera.lookAt(target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  };
  for (let round = 0; round < 6; ++round) {
    aim();
    const frame = new THREE.Box3();
    for (const point of points) frame.expandByPoint(point.clone().project(camera));
    const middle = frame.getCenter(new THREE.Vector3());
    const half = frame.getSize(new THREE.Vector3()).multiplyScalar(0.5);
    const reach = distance * Math.tan(THREE.MathUtils.degToRad(14));
    const axis = (i) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, i);
    target.addScaledVector(axis(0), middle.x * reach * camera.aspect);
    target.addScaledVector(axis(1), middle.y * reach);
    distance *= Math.max(half.x, half.y) / 0.92;
  }
  distance /= zoom;
  aim();
  return camera;
}

function describe(model) {
  const parts = [];
  model.traverse((object) => {
    if (!object.isMesh) return;
    const {attributes, index} = object.geometry;
    parts.push({
      name: object.name,
      vertices: attributes.position.count,
      triangles: index.count / 3,
      colors: attributes.color !== undefined && object.material.vertexColors,
      normals: attributes.normal !== undefined,
      flat: object.material.flatShading === true,
      material: object.material.type,
      transmission: object.material.transmission ?? 0,
      emissive: object.material.emissive.getHex(),
    });
  });
  return parts;
}

function addWires(model) {
  const wires = new THREE.MeshBasicMaterial({color: 0x101418, wireframe: true});
  const meshes = [];
  model.traverse((object) => object.isMesh && meshes.push(object));
  for (const mesh of meshes) mesh.add(new THREE.Mesh(mesh.geometry, wires));
}

// Share of pixels that are not background, and how many colours they have (4 bits a channel).
function measure(canvas) {
  const copy = document.createElement('canvas');
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const context = copy.getContext('2d', {willReadFrequently: true});
  context.drawImage(canvas, 0, 0);
  const {data} = context.getImageData(0, 0, copy.width, copy.height);
  const background = [data[0], data[1], data[2]];
  const colors = new Set();
  let covered = 0;
  for (let i = 0; i < data.length; i += 4) {
    if (background.every((c, k) => Math.abs(data[i + k] - c) < 3)) continue;
    ++covered;
    colors.add(((data[i] >> 4) << 8) | ((data[i + 1] >> 4) << 4) | (data[i + 2] >> 4));
  }
  return {coverage: covered / (data.length / 4), colors: colors.size};
}

window.render = async (options) => {
  const loader = new GLTFLoader();
  loader.setDRACOLoader(new DRACOLoader().setDecoderPath('/draco/'));
  const gltf = await loader.loadAsync('/model.glb');
  const parts = describe(gltf.scene);
  gltf.scene.traverse((object) => {
    if (!object.isMesh) return;
    object.castShadow = object.receiveShadow = true;
  });
  const sphere = new THREE.Box3().setFromObject(gltf.scene).getBoundingSphere(new THREE.Sphere());
  if (options.wire) addWires(gltf.scene);

  const renderer = makeRenderer(options.width, options.height);
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(kBackground);
  scene.add(gltf.scene);
  const camera = placeCamera(gltf.scene, sphere, options);
  light(scene, renderer, sphere, camera);
  renderer.render(scene, camera);
  return {parts, extras: gltf.asset.extras ?? {}, picture: measure(renderer.domElement)};
};
