// SPDX-License-Identifier: MIT
// Wood through and through: rings about an axis under the block and fibres along it, so that a cut shows what was inside.
import * as THREE from "three";

const SHADER = /* glsl */ `
float hash3(vec3 p) { p = fract(p * 0.3183099 + 0.1); p *= 17.0; return fract(p.x * p.y * p.z * (p.x + p.y + p.z)); }
float noise3(vec3 x) {
  vec3 i = floor(x), f = fract(x);
  f = f * f * (3.0 - 2.0 * f);
  return mix(mix(mix(hash3(i), hash3(i + vec3(1, 0, 0)), f.x), mix(hash3(i + vec3(0, 1, 0)), hash3(i + vec3(1, 1, 0)), f.x), f.y),
             mix(mix(hash3(i + vec3(0, 0, 1)), hash3(i + vec3(1, 0, 1)), f.x), mix(hash3(i + vec3(0, 1, 1)), hash3(i + vec3(1, 1, 1)), f.x), f.y), f.z);
}
vec3 wood(vec3 p) {
  vec3 q = p - woodAxis;
  float wobble = noise3(q * vec3(0.02, 0.08, 0.08)) * 3.0;
  float r = (length(q.yz) + wobble) / 2.6;
  float ring = smoothstep(0.25, 0.95, fract(r)) * (1.0 - smoothstep(0.95, 1.0, fract(r)));
  float fibre = noise3(q * vec3(0.35, 6.0, 6.0)) - 0.5;
  vec3 early = vec3(0.72, 0.52, 0.32), late = vec3(0.50, 0.31, 0.16);
  return mix(early, late, 0.75 * ring) * (1.0 + 0.16 * fibre);
}
`;

export function woodMaterial(axis: THREE.Vector3): THREE.MeshStandardMaterial {
  const material = new THREE.MeshStandardMaterial({ roughness: 0.72, metalness: 0 });
  material.onBeforeCompile = (shader) => {
    shader.uniforms.woodAxis = { value: axis };
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", "#include <common>\nvarying vec3 vWood;")
      .replace("#include <begin_vertex>", "#include <begin_vertex>\nvWood = position;");
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying vec3 vWood;\nuniform vec3 woodAxis;\n" + SHADER)
      .replace("#include <color_fragment>", "diffuseColor.rgb *= wood(vWood);");
  };
  return material;
}
