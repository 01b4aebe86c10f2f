// SPDX-License-Identifier: MIT
// The method itself, drawn near the tool: the rays of one dexel field, the dexels on them with
// their ends, the lattice points that vanish, and the resistance of each of them (eq. (4) of the
// paper sums these). The page asks the studio for the rays around the tool and asks again once it
// has the answer; while nothing is shown, nothing is asked.
import * as THREE from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { element, put, read } from "./dom";
import { write, type Method } from "./messages";
import type { View } from "./view";
import { Reader, type Vec3 } from "./wire";

/** The dexel field whose rays are shown: 0 x, 1 y, 2 z; null: the method is not shown. */
export type Field = 0 | 1 | 2 | null;

/** Rays shown along each side of the box around the tool. */
const RAYS = 24;
/** Rays closer together than this on the screen are left out, every other one at a time [px]. */
const RAY_PX = 8;
const MAX_EVERY = 64;
/** How long a vanished point is seen [ms]. */
const FLASH_MS = 700;
const MAX_FLASHES = 6000;
/** Resistances drawn at once: more of them hide each other. */
const MAX_ARROWS = 120;
/** Between two questions while nothing moves [ms]. */
const REST_MS = 200;
/** A tick that took points counts as this one for so long [ms]; the eye can read it then. */
const NOW_MS = 400;

const RAY = 0x7d8794,
  DEXEL = 0x0072b2,
  END = 0x00314f,
  POINT = 0xd55e00;

const DOTS_VERTEX = /* glsl */ `
#include <clipping_planes_pars_vertex>
attribute float born;
uniform float now, lasts, size;
varying float vLeft;
void main() {
  vLeft = lasts > 0.0 ? 1.0 - (now - born) / lasts : 1.0;
  vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * mvPosition;
  #include <clipping_planes_vertex>
  gl_PointSize = size * (0.5 + 0.5 * clamp(vLeft, 0.0, 1.0));
}`;
const DOTS_FRAGMENT = /* glsl */ `
#include <clipping_planes_pars_fragment>
uniform vec3 color;
varying float vLeft;
void main() {
  #include <clipping_planes_fragment>
  float far = length(gl_PointCoord - 0.5);
  if (vLeft <= 0.0 || far > 0.5) discard;
  gl_FragColor = vec4(color, min(1.0, 1.6 * vLeft) * smoothstep(0.5, 0.38, far));
  #include <colorspace_fragment>
}`;

/** Round dots of one size [px] that fade, or stay where `lastsMs` is 0. */
class Dots {
  readonly points: THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial>;
  constructor(color: number, size: number, lastsMs: number, order: number) {
    const material = new THREE.ShaderMaterial({
      vertexShader: DOTS_VERTEX,
      fragmentShader: DOTS_FRAGMENT,
      uniforms: {
        color: { value: new THREE.Color(color) },
        size: { value: size * Math.min(2, devicePixelRatio) },
        now: { value: 0 },
        lasts: { value: lastsMs },
      },
      clipping: true,
      transparent: true,
      depthWrite: false,
    });
    this.points = new THREE.Points(new THREE.BufferGeometry(), material);
    this.points.frustumCulled = false;
    this.points.renderOrder = order;
    this.set([], []);
  }
  /** Places [mm], and when each came [ms]; none: they stay. */
  set(places: number[], born: number[]): void {
    const { geometry } = this.points;
    geometry.dispose();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(places, 3));
    const times = born.length > 0 ? born : new Array<number>(places.length / 3).fill(0);
    geometry.setAttribute("born", new THREE.Float32BufferAttribute(times, 1));
  }
  set now(ms: number) {
    this.points.material.uniforms.now.value = ms;
  }
}

/** Lines of one width [px]. */
class Lines {
  readonly lines: LineSegments2;
  constructor(color: number, width: number, opacity: number, order: number) {
    const material = new LineMaterial({
      color,
      linewidth: width,
      transparent: true,
      opacity,
      depthWrite: opacity === 1,
    });
    this.lines = new LineSegments2(new LineSegmentsGeometry(), material);
    this.lines.frustumCulled = false;
    this.lines.renderOrder = order;
    this.set([]);
  }
  /** Six numbers a line [mm]. */
  set(ends: number[]): void {
    this.lines.visible = ends.length > 0;
    if (ends.length === 0) return;
    this.lines.geometry.dispose();
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(ends);
    this.lines.geometry = geometry;
  }
}

export class MethodView {
  private group = new THREE.Group();
  private rays = new Lines(RAY, 1, 0.55, 1);
  private dexels = new Lines(DEXEL, 3, 1, 2);
  private ends = new Dots(END, 6, 0, 3);
  private flashes = new Dots(POINT, 9, FLASH_MS, 5);
  private shafts = new Lines(POINT, 1.5, 0.9, 4);
  private heads = new THREE.InstancedMesh(
    new THREE.ConeGeometry(0.5, 1, 10).translate(0, -0.5, 0),
    new THREE.MeshBasicMaterial({ color: POINT }),
    MAX_ARROWS,
  );
  private lit: { place: Vec3; born: number }[] = [];
  private chosen: Field = null;
  private origin: Vec3 = [0, 0, 0];
  private pitch = 1;
  private tip: Vec3 | null = null;
  private waiting = false; // for an answer
  private timer = 0;
  private last = ""; // the spans that are drawn
  private tookAt = -Infinity; // a tick took points then [ms]
  private arrowsAt = -Infinity;
  private flashing = false;

  constructor(
    private view: View,
    private send: (message: Uint8Array) => void,
  ) {
    this.heads.frustumCulled = false;
    this.heads.count = 0;
    this.heads.renderOrder = 4;
    this.group.add(
      this.rays.lines,
      this.dexels.lines,
      this.ends.points,
      this.flashes.points,
      this.shafts.lines,
      this.heads,
    );
    this.group.visible = false;
    view.showAid(this.group);
  }

  /** Another document. */
  begin(origin: Vec3, pitch: number): void {
    this.origin = origin;
    this.pitch = pitch;
    this.tip = null;
    this.waiting = false;
    this.clear();
    this.askSoon(0);
  }

  get field(): Field {
    return this.chosen;
  }
  set field(field: Field) {
    this.chosen = field;
    this.clear();
    this.group.visible = this.view.ghost = field !== null;
    element("method").hidden = field === null;
    put("method-field", field === null ? "" : "xyz"[field]);
    this.view.redraw();
    this.askSoon(0);
  }

  /** Where the tool's tip is; null: nowhere yet. */
  follow(tip: Vec3 | null): void {
    const moved = tip?.join() !== this.tip?.join();
    this.tip = tip;
    if (moved && this.chosen !== null) this.askSoon(0);
  }

  private clear(): void {
    this.last = "";
    this.lit = [];
    this.arrowsAt = -Infinity;
    for (const lines of [this.rays, this.dexels, this.shafts]) lines.set([]);
    for (const dots of [this.ends, this.flashes]) dots.set([], []);
    this.heads.count = 0;
    for (const id of ["method-points", "method-volume", "method-force", "method-ticks"])
      read(id, "–");
  }

  private askSoon(ms: number): void {
    if (this.chosen === null || this.waiting) return;
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.ask(), ms);
  }
  private ask(): void {
    if (this.chosen === null || this.waiting) return;
    if (!this.tip || document.hidden) return this.askSoon(REST_MS);
    const apart = (RAY_PX * this.view.perPixel(new THREE.Vector3(...this.tip))) / this.pitch;
    const every = Math.min(MAX_EVERY, 2 ** Math.max(0, Math.ceil(Math.log2(apart))));
    this.waiting = true;
    this.send(
      write.AskMethod({
        axis: this.chosen,
        centre: this.tip,
        radius: (RAYS / 2) * every * this.pitch,
        every,
      }),
    );
  }

  /** What the studio answers. */
  take(said: Method): void {
    this.waiting = false;
    if (said.axis !== this.chosen) return this.askSoon(0);
    const shape = [said.every, said.u, said.v, said.columns, said.rows, said.low, said.high].join();
    const told = `${shape} ${new TextDecoder("latin1").decode(said.spans)}`;
    const changed = told !== this.last;
    if (changed) this.draw(said);
    this.last = told;
    if (said.taken !== 0) this.flash(said);
    this.say(said);
    if (changed || said.taken !== 0) this.view.redraw();
    this.askSoon(changed || said.taken !== 0 ? 0 : REST_MS);
  }

  /** A place on a ray [mm]. */
  private at(axis: number, u: number, v: number, depth: number): Vec3 {
    const place: Vec3 = [0, 0, 0];
    place[axis] = this.origin[axis] + this.pitch * depth;
    place[(axis + 1) % 3] = this.origin[(axis + 1) % 3] + this.pitch * (u + 0.5);
    place[(axis + 2) % 3] = this.origin[(axis + 2) % 3] + this.pitch * (v + 0.5);
    return place;
  }

  private draw(said: Method): void {
    const { axis, every, low, high } = said,
      spans = new Reader(said.spans.slice().buffer);
    const rays: number[] = [],
      dexels: number[] = [],
      ends: number[] = [];
    for (let row = 0; row < said.rows; row++)
      for (let column = 0; column < said.columns; column++) {
        const u = said.u + column * every,
          v = said.v + row * every;
        rays.push(...this.at(axis, u, v, low), ...this.at(axis, u, v, high));
        for (let left = spans.u8(); left > 0; left--) {
          const from = spans.f32(),
            to = spans.f32();
          dexels.push(
            ...this.at(axis, u, v, Math.max(low, from)),
            ...this.at(axis, u, v, Math.min(high, to)),
          );
          if (from >= low) ends.push(...this.at(axis, u, v, from));
          if (to <= high) ends.push(...this.at(axis, u, v, to));
        }
      }
    this.rays.set(rays);
    this.dexels.set(dexels);
    this.ends.set(ends, []);
    Object.assign(element("method").dataset, {
      rays: String(rays.length / 6),
      dexels: String(dexels.length / 6),
      every: String(every),
    });
  }

  /** Points that vanished since the last answer, and their resistances against the motion. */
  private flash(said: Method): void {
    const now = performance.now(),
      nodes = new Reader(said.vanished.slice().buffer);
    const places: Vec3[] = [];
    while (nodes.more) {
      const place = [nodes.u16(), nodes.u16(), nodes.u16()].map(
        (index, i) => this.origin[i] + this.pitch * (index + 0.5),
      ) as Vec3;
      places.push(place);
      this.lit.push({ place, born: now });
    }
    if (this.lit.length > MAX_FLASHES) this.lit.splice(0, this.lit.length - MAX_FLASHES);
    this.lit = this.lit.filter(({ born }) => now - born < FLASH_MS);
    this.flashes.set(
      this.lit.flatMap(({ place }) => place),
      this.lit.map(({ born }) => born),
    );
    const way = new THREE.Vector3(...said.motion);
    if (places.length > 0 && way.lengthSq() > 0) {
      const step = Math.ceil(places.length / MAX_ARROWS),
        long = 1.6 * said.every * this.pitch,
        head = 0.4 * long;
      const against = way.normalize().negate(),
        turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), against);
      const shafts: number[] = [],
        size = new THREE.Vector3(0.6 * head, head, 0.6 * head);
      let count = 0;
      for (let i = 0; i < places.length; i += step) {
        const from = new THREE.Vector3(...places[i]),
          to = from.clone().addScaledVector(against, long);
        shafts.push(...from.toArray(), ...to.clone().addScaledVector(against, -head).toArray());
        this.heads.setMatrixAt(count++, new THREE.Matrix4().compose(to, turn, size));
      }
      this.shafts.set(shafts);
      this.heads.count = count;
      this.heads.instanceMatrix.needsUpdate = true;
      this.arrowsAt = now;
    }
    const { dataset } = element("method");
    dataset.vanished = String(Number(dataset.vanished ?? 0) + said.gone);
    if (!this.flashing) this.fade();
  }
  /** Draws on while points are seen to vanish. */
  private fade(): void {
    const now = performance.now(),
      newest = this.lit.at(-1)?.born ?? -Infinity;
    this.flashing = now - Math.max(newest, this.arrowsAt) < FLASH_MS && this.chosen !== null;
    this.flashes.now = now;
    if (now - this.arrowsAt >= FLASH_MS) {
      this.shafts.set([]);
      this.heads.count = 0;
    }
    this.view.redraw();
    if (this.flashing) requestAnimationFrame(() => this.fade());
  }

  private say(said: Method): void {
    const now = performance.now();
    if (said.taken !== 0) this.tookAt = now;
    const { pitch } = this,
      cell = pitch ** 3,
      compact = (value: number): string => String(Number(value.toPrecision(3)));
    const nth = said.every === 1 ? "every ray" : `every ${said.every}${said.every === 2 ? "nd" : "th"} ray`;
    read("method-pitch", `${compact(pitch)} mm, ${nth}`);
    if (this.tookAt === -Infinity) return;
    element("method").classList.toggle("past", now - this.tookAt > NOW_MS);
    read("method-points", `${said.points}`);
    read(
      "method-volume",
      `${compact(Math.abs(said.volume))} mm³, K h³ ${compact(said.points * cell)} mm³`,
    );
    read("method-force", `${compact(Math.hypot(...said.force))} N`);
    if (said.taken !== 0) read("method-ticks", `${said.taken} in ${said.ticks} ticks`);
  }
}
