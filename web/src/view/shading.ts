// SPDX-License-Identifier: MIT
// Draws the solid as an image. Chunks are drawn into buffers for light, normals and depth. Then
// each pixel is shaded by its surroundings: ambient occlusion and cavity. The image is kept. While
// solid and camera rest, a new frame consists of this image and the moving parts over it.
//
//     draw: chunks ─► light, normals, depth ─► hollows ─► image, depth        show: image, depth ─► the canvas
//
// If only some chunks have changed, draw() draws only the rectangle of the screen that they cover.
import * as THREE from "three";
import { FullScreenQuad } from "three/examples/jsm/postprocessing/Pass.js";
import { FXAAShader } from "three/examples/jsm/shaders/FXAAShader.js";

const VERTEX = /* glsl */ `
varying vec2 vUv;
void main() { vUv = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`;

// Positions in the camera's frame. The fourth component of the normals says what a pixel shows: 0
// nothing, 0.5 the surface, 1 the inside of the solid, which is visible through the section. The
// inside counts as if it were on the section's plane.
const PLACES = /* glsl */ `
varying vec2 vUv;
uniform sampler2D tDepth, tNormal;
uniform mat4 unproject;
uniform bool perspective, cut;
uniform vec4 section;
// The z coordinate of the surface with this depth. It ignores the section.
float farAt(float depth) {
  float z = 2.0 * depth - 1.0;
  return (unproject[2].z * z + unproject[3].z) / (unproject[2].w * z + unproject[3].w);
}
vec3 placeAt(vec2 uv) {
  vec4 p = unproject * vec4(2.0 * vec3(uv, texture2D(tDepth, uv).r) - 1.0, 1.0);
  vec3 at = p.xyz / p.w;
  if (!cut || texture2D(tNormal, uv).a < 0.75) return at;
  vec3 way = perspective ? at : vec3(0.0, 0.0, -1.0);
  return at - way * (dot(section.xyz, at) + section.w) / dot(section.xyz, way);
}`;

const SAMPLES = 14;
// The share of the sky that nearby parts hide from a point. It is a mean over points on a spiral
// within the reach.
const HOLLOWS = /* glsl */ `
${PLACES}
uniform vec2 size;
uniform float reach, scale; // scale: pixels per mm at distance 1
void main() {
  vec4 said = texture2D(tNormal, vUv);
  if (said.a == 0.0) { gl_FragColor = vec4(1.0); return; }
  vec3 at = placeAt(vUv), normal = normalize(said.xyz);
  float wide = min(reach * scale / (perspective ? -at.z : 1.0), 0.1 * size.y);
  // The spiral has 16 rotations, one for each pixel of a square of 4 x 4. COMPOSE takes their
  // mean.
  ivec2 pixel = ivec2(gl_FragCoord.xy) & 3;
  float turn = float((pixel.x * 5 + pixel.y * 7 + (pixel.x ^ pixel.y) * 4) & 15) / 16.0;
  float hidden = 0.0;
  for (int i = 0; i < ${SAMPLES}; i++) {
    float share = (float(i) + 0.25 + 0.5 * turn) / float(${SAMPLES}), angle = 6.2832 * (5.0 * share + turn);
    vec3 way = placeAt(vUv + share * wide * vec2(cos(angle), sin(angle)) / size) - at;
    float far = dot(way, way), near = max(0.0, 1.0 - far / (reach * reach));
    // Parts that rise by less than a few degrees do not count. Otherwise each edge between
    // triangles would be a hollow.
    hidden += near * near * max(0.0, dot(way, normal) * inversesqrt(far + 1e-12) - 0.08);
  }
  gl_FragColor = vec4(1.0 - min(1.0, 2.2 * hidden / float(${SAMPLES})));
}`;

const COMPOSE = /* glsl */ `
${PLACES}
uniform sampler2D tLight, tHollows;
uniform mat4 project;
uniform vec2 size;
uniform bool hollows, toned;
uniform float cavity, reach;
#include <tonemapping_pars_fragment>
vec4 normalAt(vec2 offset) { return texture2D(tNormal, vUv + offset / size); }
void main() {
  vec4 light = texture2D(tLight, vUv), said = texture2D(tNormal, vUv);
  gl_FragDepth = texture2D(tDepth, vUv).r;
  if (light.a == 0.0) { gl_FragColor = vec4(0.0); return; }
  vec3 color = light.rgb / light.a;
  vec3 at = placeAt(vUv);
  bool inside = cut && said.a > 0.75;
  if (inside) {
    vec4 p = project * vec4(at, 1.0);
    gl_FragDepth = 0.5 * p.z / p.w + 0.5;
  }
  if (hollows && !inside) {
    ivec2 last = textureSize(tHollows, 0) - 1, corner = ivec2(floor(vUv * vec2(last + 1) - 1.5));
    float sum = 0.0, weights = 0.0;
    for (int i = 0; i < 16; i++) {
      ivec2 texel = clamp(corner + ivec2(i & 3, i >> 2), ivec2(0), last);
      float there = farAt(texture2D(tDepth, (vec2(texel) + 0.5) / vec2(last + 1)).r);
      float weight = 1e-4 + max(0.0, 1.0 - abs(there - at.z) / (0.5 * reach));
      sum += weight * texelFetch(tHollows, texel, 0).r;
      weights += weight;
    }
    float open = sum / weights;
    // Walls reflect light to each other. The lighter they are, the less a hollow is darkened.
    float bright = min(0.9, dot(color, vec3(0.3, 0.5, 0.2)));
    color *= mix(open, 1.0, 0.35 * bright) / mix(1.0, open, 0.35 * bright);
  }
  if (cavity > 0.0 && !inside) {
    float wide = max(1.0, size.y / 600.0);
    vec4 left = normalAt(vec2(-wide, 0)), right = normalAt(vec2(wide, 0)), down = normalAt(vec2(0, -wide)), up = normalAt(vec2(0, wide));
    float bend = 0.5 * (right.x - left.x + up.y - down.y), sure = min(min(left.a, right.a), min(down.a, up.a));
    vec2 aside = vec2(wide, 0) / size, above = vec2(0, wide) / size;
    float across = farAt(texture2D(tDepth, vUv + aside).r) - farAt(texture2D(tDepth, vUv - aside).r);
    float along = farAt(texture2D(tDepth, vUv + above).r) - farAt(texture2D(tDepth, vUv - above).r);
    float jump = max(abs(across), abs(along));
    // Normals have steps of 1/127. A bend of that size is rounding error.
    bend = sign(bend) * max(0.0, abs(bend) - 0.012) * step(0.4, sure) * (1.0 - smoothstep(0.3, 0.8, jump / reach));
    color *= 1.0 + cavity * (bend > 0.0 ? 0.7 * bend / (0.35 + bend) : 0.95 * bend / (0.25 - bend));
  }
  if (toned) color = NeutralToneMapping(color);
  gl_FragColor = vec4(sRGBTransferOETF(vec4(max(color, 0.0), 1.0)).rgb * light.a, light.a);
}`;

const SHOW = /* glsl */ `
varying vec2 vUv;
uniform sampler2D tImage, tDepth;
uniform float opacity; // below 1 the solid hides nothing
void main() {
  gl_FragColor = opacity * texture2D(tImage, vUv);
  gl_FragDepth = opacity < 1.0 ? 1.0 : texture2D(tDepth, vUv).r;
}`;

type Uniforms = Record<string, THREE.IUniform>;

/** How the solid is shaded in addition to its material. All images of a view share it. */
export interface Shades {
  hollows: boolean;
  /** 0: none. */
  cavity: number;
  /** True if light is compressed to the screen's range. A matcap already has final colours. */
  toned: boolean;
  /** Max distance of parts that hide the sky [mm]. */
  reach: number;
  /** The section. The solid is shown on the side its normal points to. */
  section: THREE.Plane | null;
}

function depthTexture(): THREE.DepthTexture {
  return new THREE.DepthTexture(1, 1, THREE.UnsignedIntType);
}
function pass(fragmentShader: string, uniforms: Uniforms, depth: boolean): FullScreenQuad {
  return new FullScreenQuad(
    new THREE.ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader,
      uniforms,
      depthTest: depth,
      depthWrite: depth,
      depthFunc: THREE.AlwaysDepth,
      blending: THREE.NoBlending,
      toneMapped: false,
    }),
  );
}

export class SolidImage {
  private solid: THREE.WebGLRenderTarget;
  private hollows = new THREE.WebGLRenderTarget(1, 1, {
    depthBuffer: false,
    minFilter: THREE.NearestFilter,
    magFilter: THREE.NearestFilter,
  });
  private image = new THREE.WebGLRenderTarget(1, 1, { depthTexture: depthTexture() });
  private every: number;
  private shared: Uniforms;
  private hollowsPass: FullScreenQuad;
  private composePass: FullScreenQuad;
  private showPass: FullScreenQuad;
  private smoothed: THREE.WebGLRenderTarget | null = null;
  private smoothPass: FullScreenQuad | null = null;

  /**
   * Smooths jagged edges with `samples` per pixel. `smoothed` smooths them in the image instead,
   * which is cheaper without a graphics card. Hollows are computed for every `every`-th pixel of a
   * row and column.
   */
  constructor(
    private renderer: THREE.WebGLRenderer,
    { samples, smoothed, every }: { samples: number; smoothed: boolean; every: number },
  ) {
    this.every = every;
    this.solid = new THREE.WebGLRenderTarget(1, 1, {
      count: 2,
      type: THREE.HalfFloatType,
      minFilter: THREE.NearestFilter,
      magFilter: THREE.NearestFilter,
      samples,
      depthTexture: depthTexture(),
    });
    const [light, normals] = this.solid.textures;
    this.shared = {
      tDepth: { value: this.solid.depthTexture },
      tNormal: { value: normals },
      unproject: { value: new THREE.Matrix4() },
      project: { value: new THREE.Matrix4() },
      perspective: { value: true },
      cut: { value: false },
      section: { value: new THREE.Vector4() },
      reach: { value: 1 },
    };
    this.hollowsPass = pass(
      HOLLOWS,
      { ...this.shared, size: { value: new THREE.Vector2() }, scale: { value: 1 } },
      false,
    );
    this.composePass = pass(
      COMPOSE,
      {
        ...this.shared,
        tLight: { value: light },
        tHollows: { value: this.hollows.texture },
        size: { value: new THREE.Vector2() },
        hollows: { value: false },
        toned: { value: true },
        cavity: { value: 0 },
        toneMappingExposure: { value: 1 },
      },
      true,
    );
    if (smoothed) {
      this.smoothed = new THREE.WebGLRenderTarget(1, 1, { depthBuffer: false });
      this.smoothPass = pass(
        FXAAShader.fragmentShader,
        { tDiffuse: { value: this.image.texture }, resolution: { value: new THREE.Vector2() } },
        false,
      );
    }
    this.showPass = pass(
      SHOW,
      {
        tImage: { value: (this.smoothed ?? this.image).texture },
        tDepth: { value: this.image.depthTexture },
        opacity: { value: 1 },
      },
      true,
    );
  }

  /** Sets the size in pixels. */
  setSize(width: number, height: number): void {
    if (this.solid.width === width && this.solid.height === height) return;
    this.solid.setSize(width, height);
    this.image.setSize(width, height);
    this.smoothed?.setSize(width, height);
    this.hollows.setSize(Math.ceil(width / this.every), Math.ceil(height / this.every));
  }

  /** Draws the whole scene, or a part of the image [pixels, from the lower left]. */
  draw(scene: THREE.Scene, camera: THREE.Camera, shades: Shades, part: THREE.Box2 | null): void {
    const { width, height } = this.solid,
      around = new THREE.Box2();
    const restrict = (target: THREE.WebGLRenderTarget, share: number, by: number): void => {
      target.scissorTest = part !== null;
      if (!part) return;
      around.copy(part).expandByScalar(by);
      around.min.multiplyScalar(share).floor().clampScalar(0, Infinity);
      around.max.multiplyScalar(share).ceil().min(new THREE.Vector2(target.width, target.height));
      target.scissor.set(
        around.min.x,
        around.min.y,
        Math.max(0, around.max.x - around.min.x),
        Math.max(0, around.max.y - around.min.y),
      );
    };
    const shared = this.shared;
    shared.unproject.value.copy(camera.projectionMatrixInverse);
    shared.project.value.copy(camera.projectionMatrix);
    shared.perspective.value = (camera as THREE.PerspectiveCamera).isPerspectiveCamera === true;
    shared.reach.value = shades.reach;
    shared.cut.value = shades.section !== null;
    if (shades.section) {
      const plane = shades.section.clone().applyMatrix4(camera.matrixWorldInverse);
      shared.section.value.set(...plane.normal.toArray(), plane.constant);
    }
    restrict(this.solid, 1, 0);
    this.renderer.setClearColor(0, 0);
    this.renderer.setRenderTarget(this.solid);
    this.renderer.clear();
    this.renderer.render(scene, camera);

    const reached = 0.1 * height;
    const scale = 0.5 * height * camera.projectionMatrix.elements[5];
    if (shades.hollows) {
      const about = (this.hollowsPass.material as THREE.ShaderMaterial).uniforms;
      about.size.value.set(this.hollows.width, this.hollows.height);
      about.scale.value = scale / this.every;
      restrict(this.hollows, 1 / this.every, reached);
      this.renderer.setRenderTarget(this.hollows);
      this.hollowsPass.render(this.renderer);
    }
    const about = (this.composePass.material as THREE.ShaderMaterial).uniforms;
    about.size.value.set(width, height);
    about.hollows.value = shades.hollows;
    about.toned.value = shades.toned;
    about.cavity.value = shades.cavity;
    const margin = shades.hollows ? reached + 4 * this.every : 4;
    restrict(this.image, 1, margin);
    this.renderer.setRenderTarget(this.image);
    this.composePass.render(this.renderer);
    if (this.smoothed && this.smoothPass) {
      (this.smoothPass.material as THREE.ShaderMaterial).uniforms.resolution.value.set(
        1 / width,
        1 / height,
      );
      restrict(this.smoothed, 1, margin + 8);
      this.renderer.setRenderTarget(this.smoothed);
      this.smoothPass.render(this.renderer);
    }
    this.renderer.setRenderTarget(null);
  }

  /**
   * Draws the image with its depth on the canvas. So the solid hides what is later drawn behind it.
   * With an opacity below 1 the solid is transparent and hides nothing.
   */
  show(opacity = 1): void {
    (this.showPass.material as THREE.ShaderMaterial).uniforms.opacity.value = opacity;
    this.renderer.setRenderTarget(null);
    this.showPass.render(this.renderer);
  }
}
