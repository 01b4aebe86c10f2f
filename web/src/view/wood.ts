// SPDX-License-Identifier: MIT
// The material of the solid: clay, or wood with rings around the pith and fibres along it. The wood
// is a function of the position, so a cut shows the rings inside. kibori/picture/wood.cpp has the
// same function. Change both together.
import * as THREE from "three";
import type { Vec3 } from "../base/vec3";
import { MAX_MATERIALS } from "../connection/kinds";

const SHADER = /* glsl */ `
uniform vec3 pith, along;
uniform float ring;
uniform vec3 woodColors[${MAX_MATERIALS}];
uniform float contrasts[${MAX_MATERIALS}];
float cornerValue(ivec3 p) {
  uint h = uint(p.x) * 0x8da6b343u ^ uint(p.y) * 0xd8163841u ^ uint(p.z) * 0xcb1ab31fu;
  h ^= h >> 15; h *= 0x2c1b3c6du; h ^= h >> 12; h *= 0x297a2d39u; h ^= h >> 15;
  return float(h) / 4294967296.0;
}
float noise(vec3 p) {
  vec3 f = fract(p), s = f * f * (3.0 - 2.0 * f);
  ivec3 i = ivec3(floor(p));
  vec4 low = vec4(cornerValue(i), cornerValue(i + ivec3(1, 0, 0)), cornerValue(i + ivec3(0, 1, 0)), cornerValue(i + ivec3(1, 1, 0)));
  vec4 high = vec4(cornerValue(i + ivec3(0, 0, 1)), cornerValue(i + ivec3(1, 0, 1)), cornerValue(i + ivec3(0, 1, 1)), cornerValue(i + ivec3(1, 1, 1)));
  vec4 z = mix(low, high, s.z);
  vec2 y = mix(z.xy, z.zw, s.y);
  return 2.0 * mix(y.x, y.y, s.x) - 1.0;
}
vec3 woodAt(vec3 place, int kind) {
  vec3 color = woodColors[kind];
  float contrast = contrasts[kind];
  if (contrast == 0.0) return color;
  vec3 from = (place - pith) / ring;
  float length = dot(from, along);
  vec3 across = from - length * along;
  float bent = noise(vec3(length, sqrt(dot(across, across)), 0.0) / 40.0);
  float rings = sqrt(dot(across, across)) + 1.1 * noise(from / 14.0) + 0.12 * noise(from / 5.0) + 1.5 * bent;
  float year = floor(rings), part = rings - year;
  // A pixel's breadth, in rings: finer detail is not resolved.
  float fine = max(fwidth(from.x), max(fwidth(from.y), fwidth(from.z)));
  float width = 0.55 + 0.3 * cornerValue(ivec3(int(year), 7, 3));
  float late = clamp((part - width) / (1.0 - width), 0.0, 1.0), edge = clamp((1.0 - part) / max(0.06, fine), 0.0, 1.0);
  float rim = late * late * (3.0 - 2.0 * late) * edge;
  float fibre = noise(across / 0.11 + along * (length / 3.5)) * clamp(1.0 - 6.0 * fine, 0.0, 1.0);
  float patches = noise(from / 9.0 + vec3(31, 17, 5));
  float strength = 0.65 + 0.25 * cornerValue(ivec3(int(year), 1, 9));
  float dark = clamp(mix(strength * rim, 0.15, smoothstep(0.4, 1.2, fine)) + 0.13 * fibre + 0.1 * patches + 0.12, 0.0, 1.0);
  vec3 light = min(color * 1.28 + 0.03, 0.95), lateWood = color * vec3(0.42, 0.34, 0.28);
  return mix(color, mix(light, lateWood, dark), contrast);
}
`;

// Passes positions in the solid's own frame. Writes normals into the second buffer; shading.ts
// explains their fourth component.
const VERTEX = (shader: string): string =>
  shader
    .replace(
      "#include <common>",
      "#include <common>\nattribute float kind, hidden;\nattribute vec4 paint;\nvarying vec3 vPlace;\nvarying float vHidden;\nvarying vec4 vPaint;\nvarying float vMask;\nflat varying int vKind;",
    )
    .replace(
      "#include <begin_vertex>",
      // The fourth byte says whether the vertex is painted, and its mask (0 to 127).
      `#include <begin_vertex>
      vPlace = position;
      int high = int(255.0 * paint.a + 0.5);
      vPaint = high > 127 ? vec4(paint.rgb, 1.0) : vec4(0.0);
      vMask = float(high > 127 ? 255 - high : high) / 127.0;
      vHidden = hidden;
      vKind = min(int(kind + 0.5), ${MAX_MATERIALS - 1});`,
    );
const FRAGMENT = (shader: string): string =>
  shader
    .replace(
      "#include <common>",
      `#include <common>
      varying vec3 vPlace;
      varying vec4 vPaint;
      varying float vMask, vHidden;
      flat varying int vKind;
      uniform float maskShown;
      layout(location = 1) out highp vec4 outNormal;
      uniform vec4 sectionPlane;
      #ifdef SECTION
      // Who looks through the section at an inner side sees what is cut.
      vec3 cutPlace() {
        vec3 way = isOrthographic ? -vec3(viewMatrix[0][2], viewMatrix[1][2], viewMatrix[2][2]) : vPlace - cameraPosition;
        return vPlace - way * (dot(sectionPlane.xyz, vPlace) + sectionPlane.w) / dot(sectionPlane.xyz, way);
      }
      #endif
      ${SHADER}`,
    )
    .replace(
      "#include <clipping_planes_fragment>",
      // A discard anywhere in a shader makes software renderers slower, so it is compiled only if
      // something is hidden.
      "#ifdef HIDES_MASKED\nif (vMask > 0.5) discard;\n#endif\n#ifdef HIDES_PARTS\nif (vHidden > 0.0) discard;\n#endif\n#include <clipping_planes_fragment>",
    )
    .replace(
      "#include <normal_fragment_maps>",
      "#include <normal_fragment_maps>\noutNormal = vec4(normal, 0.5);",
    )
    // Masked parts are darker.
    .replace(
      "#include <opaque_fragment>",
      "outgoingLight *= mix(vec3(1.0), vec3(0.3, 0.33, 0.4), maskShown * vMask);\n#include <opaque_fragment>",
    );

/** A material, as the studio reports it. */
export interface Material {
  name: string;
  color: Vec3;
  /** The contrast of its rings, 0 to 1. */
  rings: number;
  /** How it was cut from its log [mm]; zeros: the shape of the stock decides. */
  log: { ring: number; axis: Vec3; pith: Vec3 };
  /** True if the direction of a cut matters. The first such material defines the model's log. */
  grain: boolean;
  /** The law of its forces in one line. */
  law: string;
}
export type Shading = "wood" | "plain" | "clay";
/** The looks of the shading "clay". */
export const MATCAPS = ["clay", "grey", "wax", "bronze"] as const;
export type Matcap = (typeof MATCAPS)[number];

interface Look {
  /** Colour in linear light. */
  own: Vec3;
  /** Strength and sharpness of the highlight. */
  shine: number;
  sharp: number;
  /**
   * How far the light reaches around the shape, onto faces that point away from it. 0: not at all.
   */
  wrap: number;
}
const LOOKS: Record<Matcap, Look> = {
  clay: { own: [0.56, 0.235, 0.145], shine: 0.07, sharp: 28, wrap: 0.25 },
  grey: { own: [0.4, 0.4, 0.39], shine: 0.04, sharp: 18, wrap: 0.2 },
  wax: { own: [0.78, 0.66, 0.48], shine: 0.16, sharp: 60, wrap: 0.5 },
  bronze: { own: [0.33, 0.21, 0.1], shine: 0.65, sharp: 22, wrap: 0.05 },
};

/** The studio's materials. All chunks use one of them. */
export class Wood {
  private woodMaterial = new THREE.MeshStandardMaterial({ roughness: 0.66, metalness: 0 });
  private clayMaterial = new THREE.MeshMatcapMaterial();
  /** Wood, independent of the chosen material and without the section. */
  readonly pictured = this.woodMaterial.clone();
  private chosen: Shading = "wood";
  private clayFrom = new THREE.Vector3();
  private clayColor = new THREE.Vector3(...LOOKS.clay.own);
  private look: Matcap = "clay";
  private pith = new THREE.Vector3();
  private along = new THREE.Vector3(1, 0, 0);
  private ring = { value: 1 };
  private log: Material["log"] = { ring: 0, axis: [0, 0, 0], pith: [0, 0, 0] };
  private colors = Array.from({ length: MAX_MATERIALS }, () => new THREE.Color(0.72, 0.52, 0.32));
  private own = new Float32Array(MAX_MATERIALS); // contrasts of the materials
  private contrasts = new Float32Array(MAX_MATERIALS); // the drawn contrasts
  private plane = new THREE.Vector4();
  private hides = { HIDES_MASKED: false, HIDES_PARTS: false };

  constructor() {
    // If a render target has only a buffer for light, the normals that a shader writes are dropped.
    const uniforms = {
      pith: { value: this.pith },
      along: { value: this.along },
      ring: this.ring,
      woodColors: { value: this.colors },
      sectionPlane: { value: this.plane },
      maskShown: { value: 1 },
    };
    const inside = (color: string): string => `#include <opaque_fragment>
      #ifdef SECTION
      if (!gl_FrontFacing) { gl_FragColor.rgb = ${color}; outNormal.a = 1.0; }
      #endif`;
    for (const material of [this.woodMaterial, this.pictured, this.clayMaterial]) {
      material.clipShadows = true;
      material.shadowSide = THREE.BackSide;
    }
    // Both materials have the same shader text, so that they share one program.
    const wooden =
      (contrasts: Float32Array, more: Record<string, THREE.IUniform> = {}) =>
      (shader: {
        uniforms: Record<string, THREE.IUniform>;
        vertexShader: string;
        fragmentShader: string;
      }): void => {
        Object.assign(shader.uniforms, uniforms, { contrasts: { value: contrasts }, ...more });
        shader.vertexShader = VERTEX(shader.vertexShader);
        shader.fragmentShader = FRAGMENT(shader.fragmentShader)
          .replace(
            "#include <color_fragment>",
            `vec3 place = vPlace;
          #ifdef SECTION
          if (!gl_FrontFacing) place = cutPlace();
          #endif
          vec3 unpainted = woodAt(place, vKind);
          // Beside what is unpainted its colour counts for nothing; it is as screens have it (sRGB).
          vec3 painted = pow(vPaint.rgb / max(vPaint.a, 0.01), vec3(2.2));
          #ifdef SECTION
          if (!gl_FrontFacing) painted = unpainted;
          #endif
          diffuseColor.rgb *= mix(unpainted, painted, vPaint.a);`,
          )
          // The cut is shaded flat. A little more red distinguishes it from a face.
          .replace(
            "#include <opaque_fragment>",
            inside("0.82 * diffuseColor.rgb * vec3(1.06, 0.97, 0.92)"),
          );
      };
    this.woodMaterial.onBeforeCompile = wooden(this.contrasts);
    this.pictured.onBeforeCompile = wooden(this.own, {
      maskShown: { value: 0 },
    });
    this.clayMaterial.onBeforeCompile = (shader) => {
      Object.assign(shader.uniforms, uniforms, { clayColor: { value: this.clayColor } });
      shader.vertexShader = VERTEX(shader.vertexShader);
      shader.fragmentShader = FRAGMENT(shader.fragmentShader)
        .replace("#include <common>", "#include <common>\nuniform vec3 clayColor;")
        .replace(
          "#include <opaque_fragment>",
          // Paint keeps its colour. The light on it is that of the clay.
          `vec3 painted = pow(vPaint.rgb / max(vPaint.a, 0.01), vec3(2.2));
          const vec3 eye = vec3(0.2126, 0.7152, 0.0722);
          outgoingLight = mix(outgoingLight, painted * dot(outgoingLight, eye) / dot(clayColor, eye), vPaint.a);
          ${inside("0.6 * clayColor")}`,
        );
    };
  }

  /** Whether what is masked is not drawn. */
  get hidesMasked(): boolean {
    return this.hides.HIDES_MASKED;
  }
  set hidesMasked(hides: boolean) {
    this.setHides("HIDES_MASKED", hides);
  }
  /** Whether parts that the user has hidden are not drawn: see hidden_parts.ts. */
  set hidesParts(hides: boolean) {
    this.setHides("HIDES_PARTS", hides);
  }
  private setHides(what: keyof Wood["hides"], hides: boolean): void {
    if (hides === this.hides[what]) return;
    this.hides[what] = hides;
    for (const material of [this.woodMaterial, this.clayMaterial]) {
      if (hides) material.defines![what] = "";
      else delete material.defines![what];
      material.needsUpdate = true;
    }
    this.chooseSides();
  }
  get material(): THREE.Material {
    return this.chosen === "clay" ? this.clayMaterial : this.woodMaterial;
  }
  set shading(shading: Shading) {
    this.chosen = shading;
    this.contrasts.set(shading === "wood" ? this.own : new Float32Array(MAX_MATERIALS));
  }

  /** The look of clay by its normal, with the light from this direction in the camera's frame. */
  set clayLight(from: THREE.Vector3) {
    if (from.equals(this.clayFrom)) return;
    this.clayFrom.copy(from);
    this.makeClay();
  }
  set matcap(look: Matcap) {
    if (look === this.look) return;
    this.look = look;
    this.clayColor.set(...LOOKS[look].own);
    this.makeClay();
  }
  private makeClay(): void {
    this.clayMaterial.matcap?.dispose();
    this.clayMaterial.matcap = clay(this.clayFrom, LOOKS[this.look]);
  }

  /** Hides everything behind the plane. The inside that becomes visible is drawn as a flat face. */
  set section(plane: THREE.Plane | null) {
    if (plane) this.plane.set(...plane.normal.toArray(), plane.constant);
    for (const material of [this.woodMaterial, this.clayMaterial]) {
      material.clippingPlanes = plane ? [plane] : null;
      const cut = material.defines!.SECTION !== undefined;
      if (cut === (plane !== null)) continue;
      if (plane) material.defines!.SECTION = "";
      else delete material.defines!.SECTION;
      material.needsUpdate = true;
    }
    this.chooseSides();
  }
  /** Inner faces are drawn only where a section or what is hidden makes them visible. */
  private chooseSides(): void {
    for (const material of [this.woodMaterial, this.clayMaterial]) {
      const hides = Object.values(this.hides).includes(true);
      const side = material.clippingPlanes?.length || hides ? THREE.DoubleSide : THREE.FrontSide;
      if (material.side === side) continue;
      material.side = side;
      material.needsUpdate = true;
    }
  }

  /**
   * Sets the piece's box. The grain runs along its longest side. If the other two sides are equal,
   * the piece is a log.
   */
  place(low: THREE.Vector3, size: THREE.Vector3): void {
    const sides = size.toArray(),
      longest = sides.indexOf(Math.max(...sides));
    const [u, v] = [sides[(longest + 1) % 3], sides[(longest + 2) % 3]];
    this.along
      .copy(new THREE.Vector3(0.05, 0.09, 0.06))
      .setComponent(longest, this.along.getComponent(longest) + 1)
      .normalize();
    const aside = new THREE.Vector3(0.31, 0.55, -0.77);
    aside.addScaledVector(this.along, -aside.dot(this.along)).normalize();
    const log = Math.abs(u - v) < 0.02 * u;
    this.pith.copy(low).addScaledVector(size, 0.5);
    this.pith.addScaledVector(
      aside,
      log ? 0.06 * u : 0.45 * Math.min(...sides) + 0.12 * size.length(),
    );
    this.ring.value = sides[longest] / 26;
    if (this.log.axis.some((x) => x !== 0)) {
      this.along.fromArray(this.log.axis).normalize();
      this.pith.fromArray(this.log.pith);
    }
    if (this.log.ring > 0) this.ring.value = this.log.ring;
  }

  /** Sets for each material number the colour (0..255) and the contrast of the rings (0..1). */
  setKinds(kinds: Material[]): void {
    this.log = (kinds.find((kind) => kind.grain) ?? kinds[0])?.log ?? this.log;
    for (let i = 0; i < MAX_MATERIALS && kinds.length > 0; i++) {
      const kind = kinds[Math.min(i, kinds.length - 1)];
      this.colors[i].setRGB(
        kind.color[0] / 255,
        kind.color[1] / 255,
        kind.color[2] / 255,
        THREE.SRGBColorSpace,
      );
      this.own[i] = kind.rings;
    }
    this.shading = this.chosen;
  }
}

const SIDE = 256; // pixels per side of a matcap

/** A look under a soft key light, a cool fill from the other side, and a rim. */
function clay(key: THREE.Vector3, look: Look): THREE.DataTexture {
  const pixels = new Uint8Array(4 * SIDE * SIDE),
    n = new THREE.Vector3();
  const fill = new THREE.Vector3(-key.x, 0.3 - 0.5 * key.y, 0.6).normalize(),
    half = key
      .clone()
      .add(new THREE.Vector3(0, 0, 1))
      .normalize();
  const encode = (light: number): number =>
    Math.round(
      255 * Math.min(1, light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055),
    );
  for (let y = 0; y < SIDE; y++)
    for (let x = 0; x < SIDE; x++) {
      n.set((2 * x + 1) / SIDE - 1, (2 * y + 1) / SIDE - 1, 0).divideScalar(0.99);
      const flat = Math.min(1, n.x * n.x + n.y * n.y);
      n.z = Math.sqrt(1 - flat);
      n.normalize();
      // The key light reaches around the shape a little, like light that enters the clay.
      const lit = Math.max(0, (n.dot(key) + look.wrap) / (1 + look.wrap)) ** 1.3,
        filled = Math.max(0, n.dot(fill)),
        shine = Math.max(0, n.dot(half)) ** look.sharp;
      const rim = (1 - n.z) ** 3 * Math.max(0, 0.4 + 0.6 * n.y),
        sky = 0.5 + 0.5 * n.y;
      const at = 4 * (y * SIDE + x);
      look.own.forEach((own, k) => {
        const light =
          own * (1.12 * lit + [0.1, 0.13, 0.17][k] * filled + [0.1, 0.12, 0.15][k] * sky + 0.06) +
          look.shine * shine +
          0.1 * rim;
        pixels[at + k] = encode(light);
      });
      pixels[at + 3] = 255;
    }
  const texture = new THREE.DataTexture(pixels, SIDE, SIDE);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}
