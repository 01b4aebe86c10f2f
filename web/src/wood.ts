// SPDX-License-Identifier: MIT
// Wood through and through: rings about an axis under the block and fibres along it, so that a cut shows what was inside.
import * as THREE from "three";

const MOST = 16; // materials that are told apart

const SHADER = /* glsl */ `
float hash3(vec3 p) { p = fract(p * 0.3183099 + 0.1); p *= 17.0; return fract(p.x * p.y * p.z * (p.x + p.y + p.z)); }
float noise3(vec3 x) {
  vec3 i = floor(x), f = fract(x);
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(mix(hash3(i), hash3(i + vec3(1, 0, 0)), f.x), mix(hash3(i + vec3(0, 1, 0)), hash3(i + vec3(1, 1, 0)), f.x), f.y),
             mix(mix(hash3(i + vec3(0, 0, 1)), hash3(i + vec3(1, 0, 1)), f.x), mix(hash3(i + vec3(0, 1, 1)), hash3(i + vec3(1, 1, 1)), f.x), f.y), f.z);
}
vec3 wood(vec3 p, int kind) {
  vec3 q = (p - woodAxis) * woodScale;
  float wobble = noise3(q * vec3(0.02, 0.08, 0.08)) * 3.0;
  float r = (length(q.yz) + wobble) / 2.6;
  float ring = smoothstep(0.25, 0.95, fract(r)) * (1.0 - smoothstep(0.95, 1.0, fract(r)));
  float fibre = noise3(q * vec3(0.35, 6.0, 6.0)) - 0.5;
  vec3 early = woodColors[kind], late = early * vec3(0.68, 0.6, 0.5);
  float grain = woodGrain[kind];
  return mix(early, late, 0.75 * grain * ring) * (1.0 + 0.16 * grain * fibre);
}
`;

export class Wood {
  readonly material: THREE.MeshStandardMaterial;
  private axis = new THREE.Vector3();
  private scale = { value: 1 };
  private colors = Array.from({ length: MOST }, () => new THREE.Color(0.72, 0.52, 0.32));
  private grain = new Float32Array(MOST).fill(1);

  constructor() {
    this.material = new THREE.MeshStandardMaterial({ roughness: 0.72, metalness: 0 });
    this.material.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, { woodAxis: { value: this.axis }, woodScale: this.scale, woodColors: { value: this.colors }, woodGrain: { value: this.grain } });
      shader.vertexShader = shader.vertexShader
        .replace("#include <common>", "#include <common>\nattribute float kind;\nvarying vec3 vWood;\nflat varying int vKind;")
        .replace("#include <begin_vertex>", "#include <begin_vertex>\nvWood = position;\nvKind = int(kind + 0.5);");
      shader.fragmentShader = shader.fragmentShader
        .replace("#include <common>", `#include <common>\nvarying vec3 vWood;\nflat varying int vKind;\nuniform vec3 woodAxis;\nuniform float woodScale;\nuniform vec3 woodColors[${MOST}];\nuniform float woodGrain[${MOST}];\n${SHADER}`)
        .replace("#include <color_fragment>", `diffuseColor.rgb *= wood(vWood, min(vKind, ${MOST - 1}));`);
    };
  }

  /** The heart of the log, and how fine its rings are: of a piece so long [mm]. */
  place(axis: THREE.Vector3, longest: number): void {
    this.axis.copy(axis);
    this.scale.value = 80 / Math.max(1, longest);
  }

  /** By number: a colour (0..255), and whether it has grain. */
  setKinds(kinds: { color: [number, number, number]; grain: boolean }[]): void {
    for (let i = 0; i < MOST && kinds.length > 0; i++) {
      const kind = kinds[Math.min(i, kinds.length - 1)];
      this.colors[i].setRGB(kind.color[0] / 255, kind.color[1] / 255, kind.color[2] / 255, THREE.SRGBColorSpace);
      this.grain[i] = kind.grain ? 1 : 0;
    }
  }
}
