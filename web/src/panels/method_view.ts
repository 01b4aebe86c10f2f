// SPDX-License-Identifier: MIT
// Shows how the model works, near the tool: the rays of one dexel field, their dexels and ends, the
// lattice points that vanish, and the resistance of each point. Eq. (4) of the paper sums these
// resistances. The page asks the studio for the rays around the tool. It asks again after each
// answer, and only while the method is shown.
import { t } from "../base/texts";
import * as THREE from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { element, put, read } from "../base/dom";
import { write, type Method } from "../connection/messages";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";
import { Reader } from "../connection/wire";

/** The dexel field whose rays are shown: 0 x, 1 y, 2 z. Null: the method is not shown. */
export type Field = 0 | 1 | 2 | null;

/** Rays along each side of the box around the tool. */
const RAYS = 24;
/** Minimum distance between rays on the screen [px]. Closer rays are thinned out. */
const RAY_PX = 7;
/** Possible steps for thinning: every n-th ray is shown. */
const EVERY = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];
/**
 * The box around the tool: its half width [tool half widths], and its centre's height above the tip
 * [box half sides].
 */
const AROUND = 2,
  ABOVE = 0.3;
/** How long a vanished point stays visible [ms]. */
const FLASH_MS = 300;
const MAX_FLASHES = 6000;
/** Max number of drawn resistances. More of them would hide each other. */
const MAX_ARROWS = 20;
const ARROW_PX = 30;
/** Size of points [px], proportional to the pitch and limited. */
const POINT_PX = { min: 3, max: 7, ofPitch: 0.7 };
/** Interval between requests while nothing moves [ms]. */
const REST_MS = 200;
/** A tick that removed points is shown at least for this time [ms], so that an eye can read it. */
const NOW_MS = 400;

const RAY = 0x7d8794,
  DEXEL = 0x0072b2,
  END = 0x00314f,
  NODE = 0xe8f4ff,
  FAR_END = 0x5d93b5,
  POINT = 0xffc21a,
  RESISTANCE = 0xd55e00;

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
  // A darker rim, so that it is seen before any ground.
  gl_FragColor = vec4(color * (1.0 - 0.65 * smoothstep(0.27, 0.36, far)), min(1.0, 1.6 * vLeft) * smoothstep(0.5, 0.42, far));
  #include <colorspace_fragment>
}`;

/** Round dots of one size [px]. They fade, or stay if `lastsMs` is 0. */
class Dots {
  readonly points: THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial>;
  constructor(color: number, size: number, lastsMs: number, order: number) {
    const material = new THREE.ShaderMaterial({
      vertexShader: DOTS_VERTEX,
      fragmentShader: DOTS_FRAGMENT,
      uniforms: {
        color: { value: new THREE.Color(color) },
        size: { value: 0 },
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
    this.size = size;
    this.set([], []);
  }
  set size(px: number) {
    this.points.material.uniforms.size.value = px * Math.min(2, devicePixelRatio);
  }
  /** Sets positions [mm] and the time when each appeared [ms]. Without times they stay. */
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

/** Line segments of one width [px]. */
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
  /** Sets the segments: six numbers per line [mm]. */
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
  // Rays in a plane through the tip that faces the viewer. Rays in front of this plane are not
  // shown.
  private rays = new Lines(RAY, 1, 0.8, 2);
  private dexels = new Lines(DEXEL, 3, 1, 3);
  private ends = new Dots(END, 7, 0, 4);
  private nodes = new Dots(NODE, 2.5, 0, 4);
  // Rays behind that plane.
  private farRays = new Lines(RAY, 1, 0.25, 1);
  private farDexels = new Lines(DEXEL, 1, 0.35, 1);
  private farEnds = new Dots(FAR_END, 3, 0, 1);
  private flashes = new Dots(POINT, 7, FLASH_MS, 6);
  private shafts = new Lines(RESISTANCE, 2, 1, 7);
  private heads = new THREE.InstancedMesh(
    new THREE.ConeGeometry(0.5, 1, 10).translate(0, -0.5, 0),
    new THREE.MeshBasicMaterial({ color: RESISTANCE }),
    MAX_ARROWS,
  );
  private lit: { place: Vec3; born: number }[] = [];
  private chosen: Field = null;
  private origin: Vec3 = [0, 0, 0];
  private pitch = 1;
  private tip: Vec3 | null = null;
  private axis: Vec3 = [0, 0, 1];
  private waiting = false; // for an answer
  private timer = 0;
  private last = ""; // the spans that are drawn
  private tookAt = -Infinity; // time of the last tick that removed points [ms]
  private arrowsAt = -Infinity;
  private flashing = false;

  constructor(
    private view: View,
    private send: (message: Uint8Array) => void,
  ) {
    this.heads.frustumCulled = false;
    this.heads.count = 0;
    this.heads.renderOrder = 7;
    // Points are close together. So an arrow is also visible through points in front of it.
    (this.heads.material as THREE.Material).depthTest = false;
    this.shafts.lines.material.depthTest = false;
    this.group.add(
      this.farRays.lines,
      this.farDexels.lines,
      this.farEnds.points,
      this.rays.lines,
      this.dexels.lines,
      this.ends.points,
      this.nodes.points,
      this.flashes.points,
      this.shafts.lines,
      this.heads,
    );
    this.group.visible = false;
    view.showAid(this.group);
  }

  /** Starts with another document. */
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

  /** Sets the tip. Null: unknown. */
  follow(tip: Vec3 | null, axis: Vec3): void {
    const moved = tip?.join() !== this.tip?.join();
    this.tip = tip;
    this.axis = axis;
    if (moved && this.chosen !== null) this.askSoon(0);
  }

  private clear(): void {
    this.last = "";
    this.lit = [];
    this.arrowsAt = -Infinity;
    for (const lines of [this.rays, this.dexels, this.farRays, this.farDexels, this.shafts])
      lines.set([]);
    for (const dots of [this.ends, this.nodes, this.farEnds, this.flashes]) dots.set([], []);
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
    const { tip, axis, pitch } = this,
      apart = (RAY_PX * this.view.cameras.perPixel(new THREE.Vector3(...tip))) / pitch;
    const every = EVERY.find((n) => n >= apart) ?? EVERY.at(-1)!;
    const radius = Math.max(
      4 * every * pitch,
      Math.min((RAYS / 2) * every * pitch, AROUND * this.view.tool.width),
    );
    this.waiting = true;
    this.send(
      write.AskMethod({
        axis: this.chosen,
        centre: tip.map((x, i) => x + ABOVE * radius * axis[i]) as Vec3,
        radius,
        every,
      }),
    );
  }

  /** Takes the studio's answer. */
  take(message: Method): void {
    this.waiting = false;
    if (message.axis !== this.chosen) return this.askSoon(0);
    const front = this.front(message);
    const shape = [
      message.every,
      message.u,
      message.v,
      message.columns,
      message.rows,
      message.low,
      message.high,
      front.across,
      front.row,
      front.behind,
    ].join();
    const drawn = `${shape} ${new TextDecoder("latin1").decode(message.spans)}`;
    const changed = drawn !== this.last;
    if (changed) this.draw(message, front);
    this.last = drawn;
    if (message.taken !== 0) this.flash(message);
    this.report(message);
    if (changed || message.taken !== 0) this.view.redraw();
    this.askSoon(changed || message.taken !== 0 ? 0 : REST_MS);
  }

  /** A position on a ray [mm]. */
  private at(axis: number, u: number, v: number, depth: number): Vec3 {
    const place: Vec3 = [0, 0, 0];
    place[axis] = this.origin[axis] + this.pitch * depth;
    place[(axis + 1) % 3] = this.origin[(axis + 1) % 3] + this.pitch * (u + 0.5);
    place[(axis + 2) % 3] = this.origin[(axis + 2) % 3] + this.pitch * (v + 0.5);
    return place;
  }

  /**
   * The plane of rays through the tip that faces the viewer most. It is normal to u (0) or v (1).
   * `row` is its index. `behind` is the sign of the direction away from the viewer.
   */
  private front(message: Method): { across: 0 | 1; row: number; behind: number } {
    const tip = this.tip ?? [0, 0, 0],
      direction = this.view.cameras.towardsEye(new THREE.Vector3(...tip)).toArray();
    const u = (message.axis + 1) % 3,
      v = (message.axis + 2) % 3,
      across = Math.abs(direction[u]) > Math.abs(direction[v]) ? 0 : 1;
    const index = [u, v][across],
      at = (tip[index] - this.origin[index]) / this.pitch - 0.5;
    const row = Math.round((at - [message.u, message.v][across]) / message.every),
      last = [message.columns, message.rows][across] - 1;
    return {
      across,
      row: Math.min(last, Math.max(0, row)),
      behind: direction[index] > 0 ? -1 : 1,
    };
  }

  private draw(message: Method, front: { across: 0 | 1; row: number; behind: number }): void {
    const { axis, every, low, high } = message,
      spans = new Reader(message.spans.slice().buffer);
    const near = { rays: [] as number[], dexels: [] as number[], ends: [] as number[] },
      far = { rays: [] as number[], dexels: [] as number[], ends: [] as number[] },
      unseen = { rays: [] as number[], dexels: [] as number[], ends: [] as number[] },
      nodes: number[] = [];
    for (let row = 0; row < message.rows; row++)
      for (let column = 0; column < message.columns; column++) {
        const u = message.u + column * every,
          v = message.v + row * every,
          deep = front.behind * ([column, row][front.across] - front.row);
        const to = deep === 0 ? near : deep > 0 ? far : unseen;
        to.rays.push(...this.at(axis, u, v, low), ...this.at(axis, u, v, high));
        for (let left = spans.u8(); left > 0; left--) {
          const begin = spans.f32(),
            end = spans.f32();
          const from = Math.max(low, begin),
            until = Math.min(high, end);
          to.dexels.push(...this.at(axis, u, v, from), ...this.at(axis, u, v, until));
          if (begin >= low) to.ends.push(...this.at(axis, u, v, begin));
          if (end <= high) to.ends.push(...this.at(axis, u, v, end));
          if (deep !== 0) continue;
          for (let k = Math.ceil((from - 0.5) / every) * every; k + 0.5 < until; k += every)
            if (k + 0.5 >= from) nodes.push(...this.at(axis, u, v, k + 0.5));
        }
      }
    this.rays.set(near.rays);
    this.dexels.set(near.dexels);
    this.ends.set(near.ends, []);
    this.nodes.set(nodes, []);
    this.farRays.set(far.rays);
    this.farDexels.set(far.dexels);
    this.farEnds.set(far.ends, []);
    Object.assign(element("method").dataset, {
      rays: String((near.rays.length + far.rays.length + unseen.rays.length) / 6),
      dexels: String((near.dexels.length + far.dexels.length + unseen.dexels.length) / 6),
      every: String(every),
    });
  }

  /** Shows the points that vanished since the last answer, and their resistances to the motion. */
  private flash(message: Method): void {
    const now = performance.now(),
      nodes = new Reader(message.vanished.slice().buffer);
    const places: Vec3[] = [];
    while (nodes.more) {
      const place = [nodes.i16(), nodes.i16(), nodes.i16()].map(
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
    const direction = new THREE.Vector3(...message.motion),
      mmPerPx = this.view.cameras.perPixel(new THREE.Vector3(...(this.tip ?? this.origin)));
    this.flashes.size = Math.min(
      POINT_PX.max,
      Math.max(POINT_PX.min, (POINT_PX.ofPitch * this.pitch) / mmPerPx),
    );
    if (places.length > 0 && direction.lengthSq() > 0) {
      const step = Math.ceil(places.length / MAX_ARROWS),
        long = ARROW_PX * mmPerPx,
        head = 0.3 * long;
      const against = direction.normalize().negate(),
        turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), against);
      const shafts: number[] = [],
        size = new THREE.Vector3(0.8 * head, head, 0.8 * head);
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
    dataset.vanished = String(Number(dataset.vanished ?? 0) + message.gone);
    if (!this.flashing) this.fade();
  }
  /** Redraws while vanished points are visible. */
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

  private report(message: Method): void {
    const now = performance.now();
    if (message.taken !== 0) this.tookAt = now;
    const { pitch } = this,
      cell = pitch ** 3,
      compact = (value: number): string => String(Number(value.toPrecision(3)));
    const nth = message.every === 1 ? t("every_ray") : t("one_ray_in", { n: message.every });
    read("method-pitch", `${compact(pitch)} mm, ${nth}`);
    if (this.tookAt === -Infinity) return;
    element("method").classList.toggle("past", now - this.tookAt > NOW_MS);
    read("method-points", `${message.points}`);
    read(
      "method-volume",
      `${compact(Math.abs(message.volume))} mm³ (K h³: ${compact(message.points * cell)})`,
    );
    read("method-force", `${compact(Math.hypot(...message.force))} N`);
    if (message.taken !== 0)
      read("method-ticks", t("points_in_ticks", { points: message.taken, ticks: message.ticks }));
  }
}
