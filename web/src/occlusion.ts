// SPDX-License-Identifier: MIT
// Ambient occlusion: what lies in a hollow sees less of the sky. Laid over a picture that has been drawn.
import * as THREE from "three";
import { GTAOPass } from "three/examples/jsm/postprocessing/GTAOPass.js";

export class Occlusion {
  private pass: GTAOPass;

  /** Of meshes of the scene that have `layer`; lights and other things may have it, too. */
  constructor(
    scene: THREE.Scene,
    private camera: THREE.PerspectiveCamera,
    private layer: number,
  ) {
    this.pass = new GTAOPass(scene, camera, 1, 1);
    this.pass.output = GTAOPass.OUTPUT.Off;
    // Light that reaches a hollow has come off its walls: it is warmer there, as wood is.
    this.pass.blendMaterial.fragmentShader = /* glsl */ `
      uniform sampler2D tDiffuse;
      varying vec2 vUv;
      void main() { gl_FragColor = vec4(pow(texture2D(tDiffuse, vUv).rgb, vec3(0.7, 0.9, 1.15)), 1.0); }`;
    this.pass.updatePdMaterial({ lumaPhi: 10, depthPhi: 2, normalPhi: 3, radius: 6, rings: 2, samples: 16 });
  }

  /** How far what hides the sky may be [mm]. */
  set reach(mm: number) {
    this.pass.updateGtaoMaterial({ radius: mm, distanceExponent: 1, distanceFallOff: 0.4, thickness: mm, scale: 2.5, samples: 16 });
  }

  /** Over what the renderer drew on its canvas; found for every so-manyth pixel of a row and column. */
  draw(renderer: THREE.WebGLRenderer, every: number): void {
    const size = renderer.getDrawingBufferSize(new THREE.Vector2()).divideScalar(every).ceil();
    if (this.pass.width !== size.x || this.pass.height !== size.y) this.pass.setSize(size.x, size.y);
    const layers = this.camera.layers.mask;
    this.camera.layers.set(this.layer);
    // Neither buffer is one that is kept: what comes of it stays in the pass, and is blended here.
    const none = null as unknown as THREE.WebGLRenderTarget;
    this.pass.render(renderer, none, none, 0, false);
    this.camera.layers.mask = layers;
    this.pass.blendMaterial.uniforms.tDiffuse.value = this.pass.gtaoMap;
    this.pass.renderPass(renderer, this.pass.blendMaterial, null);
  }
}
