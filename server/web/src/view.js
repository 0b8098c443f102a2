// The 3D view: one camera, the regularized model, and the voxels it came from beside it.
import * as THREE from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {RoomEnvironment} from 'three/examples/jsm/environments/RoomEnvironment.js';
import {DRACOLoader} from 'three/examples/jsm/loaders/DRACOLoader.js';
import {GLTFLoader} from 'three/examples/jsm/loaders/GLTFLoader.js';

const draco = new DRACOLoader();
draco.setDecoderPath({js: '/draco/draco_wasm_wrapper.js', wasm: '/draco/draco_decoder.wasm'});
const loader = new GLTFLoader().setDRACOLoader(draco);

// Frees what a model holds on the graphics card.
function dispose(model) {
    model.traverse((node) => {
        node.geometry?.dispose();
        for (const material of [node.material].flat()) {
            if (!material) continue;
            for (const value of Object.values(material)) if (value?.isTexture) value.dispose();
            material.dispose();
        }
    });
}

export class View {
    // Throws if the browser has no WebGL 2.
    constructor(canvas) {
        this.canvas = canvas;
        this.renderer = new THREE.WebGLRenderer({canvas, antialias: true, alpha: true});
        this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        this.renderer.toneMapping = THREE.NeutralToneMapping;
        this.camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
        this.controls = new OrbitControls(this.camera, canvas);
        this.controls.enableDamping = true;
        this.controls.addEventListener('change', () => this.invalidate());
        const generator = new THREE.PMREMGenerator(this.renderer);
        this.room = generator.fromScene(new RoomEnvironment(), 0.04).texture;
        generator.dispose();
        this.surface = this.makeScene();
        this.voxels = this.makeScene();
        this.looks = {wireframe: false, flatShading: false};
        this.split = null;
        this.radius = 1;
        new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
        this.resize();
    }

    makeScene() {
        const scene = new THREE.Scene();
        scene.environment = this.room;
        scene.environmentIntensity = 0.55;
        const sun = new THREE.DirectionalLight(0xffffff, 2.1);
        sun.position.set(0.6, 1, 0.8);
        scene.add(sun, sun.target);
        return scene;
    }

    // Decodes a GLB; gives what GLTFLoader gives.
    async decode(bytes) {
        return loader.parseAsync(bytes, '');
    }

    // Puts a model into `surface` or `voxels` in place of the one there.
    place(scene, model, zUp) {
        if (scene.userData.model) {
            scene.remove(scene.userData.model);
            dispose(scene.userData.model);
        }
        scene.userData.model = model;
        if (!model) return this.invalidate();
        model.rotation.x = zUp ? -Math.PI / 2 : 0;
        scene.add(model);
        this.applyLooks();
    }

    // Looks at the whole model from a corner.
    frame() {
        const model = this.surface.userData.model;
        if (!model) return;
        model.updateMatrixWorld(true);
        const sphere = new THREE.Box3().setFromObject(model).getBoundingSphere(new THREE.Sphere());
        this.radius = sphere.radius || 1;
        const half = THREE.MathUtils.degToRad(this.camera.fov / 2);
        const narrow = Math.min(1, this.camera.aspect);
        const distance = this.radius / Math.sin(Math.atan(Math.tan(half) * narrow)) * 1.12;
        const direction = new THREE.Vector3(0.75, 0.62, 1).normalize();
        this.controls.target.copy(sphere.center);
        this.camera.position.copy(sphere.center).addScaledVector(direction, distance);
        this.camera.near = distance / 200;
        this.camera.far = distance * 20;
        this.camera.updateProjectionMatrix();
        this.controls.minDistance = this.radius / 20;
        this.controls.maxDistance = distance * 6;
        this.controls.update();
        this.invalidate();
    }

    setLook(name, value) {
        this.looks[name] = value;
        this.applyLooks();
    }

    applyLooks() {
        for (const scene of [this.surface, this.voxels]) {
            scene.userData.model?.traverse((node) => {
                for (const material of [node.material].flat()) {
                    if (!material) continue;
                    const flat = scene === this.surface && this.looks.flatShading;
                    material.userData.ownFlat ??= material.flatShading;
                    material.flatShading = flat || material.userData.ownFlat;
                    material.wireframe = this.looks.wireframe;
                    material.needsUpdate = true;
                }
            });
        }
        this.invalidate();
    }

    // From 0 to 1: voxels are drawn left of it. Null draws the surface alone.
    setSplit(fraction) {
        this.split = fraction;
        this.invalidate();
    }

    resize() {
        const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
        if (!width || !height) return;
        this.renderer.setSize(width, height, false);
        this.camera.aspect = width / height;
        this.camera.updateProjectionMatrix();
        this.invalidate();
    }

    // Draws once in the next frame; the page is idle while nothing moves.
    invalidate() {
        if (this.pending) return;
        this.pending = requestAnimationFrame(() => {
            this.pending = 0;
            this.controls.update();
            this.draw();
        });
    }

    draw() {
        const size = this.renderer.getSize(new THREE.Vector2());
        const compare = this.split !== null && this.voxels.userData.model;
        this.renderer.setScissorTest(Boolean(compare));
        if (!compare) return this.renderer.render(this.surface, this.camera);
        const left = Math.round(size.x * this.split);
        this.renderer.setScissor(0, 0, left, size.y);
        this.renderer.render(this.voxels, this.camera);
        this.renderer.setScissor(left, 0, size.x - left, size.y);
        this.renderer.render(this.surface, this.camera);
    }
}
