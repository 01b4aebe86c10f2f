// SPDX-License-Identifier: MIT
// Small pictures of the piece. One camera and one light take all of them, so that two pictures
// differ only where the steps do. They are drawn off-screen.
import * as THREE from "three";
import { OutputPass } from "three/examples/jsm/postprocessing/OutputPass.js";

const FINER = 3; // drawn pixels per picture pixel, along each side
const MARGIN = 1.05; // factor around the piece

export class Thumbnails {
  private camera = new THREE.PerspectiveCamera(35, 1, 1, 5000);
  private sun: THREE.DirectionalLight;
  private light = new THREE.WebGLRenderTarget(1, 1, { type: THREE.HalfFloatType });
  private colours = new THREE.WebGLRenderTarget(1, 1, { depthBuffer: false });
  private output = new OutputPass();
  private box = new THREE.Box3();
  private from = new THREE.Vector3();

  /**
   * Pictures the scene's objects in `layer`. The sky light must be in that layer too. The sun has
   * the properties of `like`.
   */
  constructor(
    private scene: THREE.Scene,
    like: THREE.DirectionalLight,
    layer: number,
  ) {
    // The view's sun and its shadows must not change, so there is a second sun. Each camera sees
    // only one of them. So materials need no second shader program.
    this.sun = new THREE.DirectionalLight(like.color, like.intensity);
    this.sun.layers.set(layer);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.setScalar(1024);
    this.sun.shadow.bias = like.shadow.bias;
    this.sun.shadow.normalBias = like.shadow.normalBias;
    this.camera.up.set(0, 0, 1);
    this.camera.layers.set(layer);
    this.output.renderToScreen = false;
    scene.add(this.sun, this.sun.target);
  }

  /** Sets the pictured box [mm] and the direction to the camera. */
  place(box: THREE.Box3, from: THREE.Vector3): void {
    this.box.copy(box);
    this.from.copy(from).normalize();
    const { center, radius } = box.getBoundingSphere(new THREE.Sphere());
    this.sun.position
      .copy(center)
      .add(new THREE.Vector3(-0.7, -0.45, 1.6).multiplyScalar(3 * radius));
    this.sun.target.position.copy(center);
    const shadow = this.sun.shadow.camera;
    shadow.left = shadow.bottom = -1.2 * radius;
    shadow.right = shadow.top = 1.2 * radius;
    shadow.near = radius;
    shadow.far = 9 * radius;
    shadow.updateProjectionMatrix();
  }

  draw(renderer: THREE.WebGLRenderer, width: number, height: number): Promise<Blob | null> {
    if (this.box.isEmpty()) return Promise.resolve(null);
    const w = FINER * width,
      h = FINER * height;
    this.light.setSize(w, h);
    this.colours.setSize(w, h);
    this.aim(width / height);
    const { needsUpdate } = renderer.shadowMap,
      { toneMapping } = renderer;
    renderer.shadowMap.needsUpdate = true; // for the lights that this camera sees
    renderer.setRenderTarget(this.light);
    renderer.clear();
    renderer.render(this.scene, this.camera);
    renderer.shadowMap.needsUpdate = needsUpdate;
    renderer.toneMapping = THREE.NeutralToneMapping; // as in shading.ts
    this.output.render(renderer, this.colours, this.light, 0, false);
    renderer.toneMapping = toneMapping;
    renderer.setRenderTarget(null);
    const pixels = new Uint8Array(4 * w * h);
    renderer.readRenderTargetPixels(this.colours, 0, 0, w, h, pixels);
    const picture = document.createElement("canvas");
    picture.width = width;
    picture.height = height;
    picture.getContext("2d")!.putImageData(smaller(pixels, width, height), 0, 0);
    return new Promise((done) => picture.toBlob(done, "image/png"));
  }

  /** Moves the camera as near as the box allows. */
  private aim(aspect: number): void {
    const center = this.box.getCenter(new THREE.Vector3());
    this.camera.aspect = aspect;
    this.camera.position.copy(center).add(this.from);
    this.camera.lookAt(center);
    this.camera.updateMatrixWorld();
    const up = Math.tan((this.camera.fov * Math.PI) / 360) / MARGIN,
      right = up * aspect;
    let far = 0;
    for (let i = 0; i < 8; i++) {
      const corner = new THREE.Vector3(
        ...([0, 1, 2].map((k) => (i & (1 << k) ? this.box.max : this.box.min).getComponent(k)) as [
          number,
          number,
          number,
        ]),
      );
      const seen = corner.sub(center).applyQuaternion(this.camera.quaternion.clone().invert());
      far = Math.max(far, Math.abs(seen.x) / right + seen.z, Math.abs(seen.y) / up + seen.z);
    }
    this.camera.position.copy(center).addScaledVector(this.from, far);
    this.camera.near = far / 50;
    this.camera.far = far * 4;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }
}

/** Averages FINER x FINER pixels. Input rows start at the bottom, output rows at the top. */
function smaller(pixels: Uint8Array, width: number, height: number): ImageData {
  const small = new ImageData(width, height);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const sum = [0, 0, 0, 0];
      for (let v = 0; v < FINER; v++)
        for (let u = 0; u < FINER; u++) {
          const at = 4 * ((FINER * (height - 1 - y) + v) * FINER * width + FINER * x + u),
            alpha = pixels[at + 3];
          for (let k = 0; k < 3; k++) sum[k] += alpha * pixels[at + k];
          sum[3] += alpha;
        }
      const to = 4 * (y * width + x);
      for (let k = 0; k < 3; k++) small.data[to + k] = sum[3] > 0 ? sum[k] / sum[3] : 0;
      small.data[to + 3] = sum[3] / (FINER * FINER);
    }
  return small;
}
