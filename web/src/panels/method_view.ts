// SPDX-License-Identifier: MIT
// Draws the method near the tool: the rays of one dexel field and their dexels with ends. Also the
// lattice points that vanish, each with its resistance; eq. (4) of the paper sums these. The page
// asks the studio for the rays around the tool, and asks again once it has the answer. It asks only
// while the method is shown.
import * as THREE from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { element, put, read } from "../base/dom";
import { write, type Method } from "../connection/messages";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";
import { Reader } from "../connection/wire";

/** The dexel field whose rays are shown: 0 x, 1 y, 2 z; null: the method is not shown. */
export type Field = 0 | 1 | 2 | null;

/** Rays shown along each side of the box around the tool. */
const RAYS = 24;
/** If rays were closer together than this on the screen [px], only every n-th is shown. */
const RAY_PX = 7;
/** The allowed values of that n. */
const EVERY = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];
/**
 * The box around the tool. AROUND: half its side, in half widths of the tool. ABOVE: height of its
 * centre above the tip, in half sides.
 */
const AROUND = 2,
  ABOVE = 0.3;
/** Time for which a vanished point is visible [ms]. */
const FLASH_MS = 300;
const MAX_FLASHES = 6000;
/** Max number of resistances drawn at once. More would hide each other. */
const MAX_ARROWS = 20;
const ARROW_PX = 30;
/** Size of a point [px], limited by the pitch. */
const POINT_PX = { least: 3, most: 7, ofPitch: 0.7 };
/** Interval of requests while nothing moves [ms]. */
const REST_MS = 200;
/** A tick that removed points stays on display for this time [ms], so that the user can read it. */
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
  // A darker rim, so that the dot is visible on any background.
  gl_FragColor = vec4(color * (1.0 - 0.65 * smoothstep(0.27, 0.36, far)), min(1.0, 1.6 * vLeft) * smoothstep(0.5, 0.42, far));
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
  /** `places` [mm], and the time of each [ms]; no times: the dots stay. */
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
  /** Six numbers per line [mm]. */
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
  // Rays of the plane through the tip that faces the viewer. Rays in front of it are not drawn.
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
  private waiting = false; // waiting for an answer
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
    // Points are close together. A resistance is visible through the points in front of it.
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

  /** Resets for another document. */
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

  /** Follows the tool's tip; null: no position yet. */
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
  take(said: Method): void {
    this.waiting = false;
    if (said.axis !== this.chosen) return this.askSoon(0);
    const front = this.front(said);
    const shape = [
      said.every,
      said.u,
      said.v,
      said.columns,
      said.rows,
      said.low,
      said.high,
      front.across,
      front.row,
      front.behind,
    ].join();
    const told = `${shape} ${new TextDecoder("latin1").decode(said.spans)}`;
    const changed = told !== this.last;
    if (changed) this.draw(said, front);
    this.last = told;
    if (said.taken !== 0) this.flash(said);
    this.say(said);
    if (changed || said.taken !== 0) this.view.redraw();
    this.askSoon(changed || said.taken !== 0 ? 0 : REST_MS);
  }

  /** The position of a depth on a ray [mm]. */
  private at(axis: number, u: number, v: number, depth: number): Vec3 {
    const place: Vec3 = [0, 0, 0];
    place[axis] = this.origin[axis] + this.pitch * depth;
    place[(axis + 1) % 3] = this.origin[(axis + 1) % 3] + this.pitch * (u + 0.5);
    place[(axis + 2) % 3] = this.origin[(axis + 2) % 3] + this.pitch * (v + 0.5);
    return place;
  }

  /**
   * The plane of rays through the tip that faces the viewer most directly. `across`: it is normal
   * to u (0) or v (1). `row`: its row or column of rays. `behind`: sign of the direction away from
   * the viewer.
   */
  private front(said: Method): { across: 0 | 1; row: number; behind: number } {
    const tip = this.tip ?? [0, 0, 0],
      way = this.view.cameras.towardsEye(new THREE.Vector3(...tip)).toArray();
    const u = (said.axis + 1) % 3,
      v = (said.axis + 2) % 3,
      across = Math.abs(way[u]) > Math.abs(way[v]) ? 0 : 1;
    const index = [u, v][across],
      at = (tip[index] - this.origin[index]) / this.pitch - 0.5;
    const row = Math.round((at - [said.u, said.v][across]) / said.every),
      last = [said.columns, said.rows][across] - 1;
    return {
      across,
      row: Math.min(last, Math.max(0, row)),
      behind: way[index] > 0 ? -1 : 1,
    };
  }

  private draw(said: Method, front: { across: 0 | 1; row: number; behind: number }): void {
    const { axis, every, low, high } = said,
      spans = new Reader(said.spans.slice().buffer);
    const near = { rays: [] as number[], dexels: [] as number[], ends: [] as number[] },
      far = { rays: [] as number[], dexels: [] as number[], ends: [] as number[] },
      unseen = { rays: [] as number[], dexels: [] as number[], ends: [] as number[] },
      nodes: number[] = [];
    for (let row = 0; row < said.rows; row++)
      for (let column = 0; column < said.columns; column++) {
        const u = said.u + column * every,
          v = said.v + row * every,
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

  /**
   * Shows the points that vanished since the last answer, and their resistances against the motion.
   */
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
    const way = new THREE.Vector3(...said.motion),
      mmPerPx = this.view.cameras.perPixel(new THREE.Vector3(...(this.tip ?? this.origin)));
    this.flashes.size = Math.min(
      POINT_PX.most,
      Math.max(POINT_PX.least, (POINT_PX.ofPitch * this.pitch) / mmPerPx),
    );
    if (places.length > 0 && way.lengthSq() > 0) {
      const step = Math.ceil(places.length / MAX_ARROWS),
        long = ARROW_PX * mmPerPx,
        head = 0.3 * long;
      const against = way.normalize().negate(),
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
    dataset.vanished = String(Number(dataset.vanished ?? 0) + said.gone);
    if (!this.flashing) this.fade();
  }
  /** Redraws while points fade. */
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
    const nth =
      said.every === 1
        ? "every ray"
        : `every ${said.every}${["th", "st", "nd", "rd"][said.every] ?? "th"} ray`;
    read("method-pitch", `${compact(pitch)} mm, ${nth}`);
    if (this.tookAt === -Infinity) return;
    element("method").classList.toggle("past", now - this.tookAt > NOW_MS);
    read("method-points", `${said.points}`);
    read(
      "method-volume",
      `${compact(Math.abs(said.volume))} mm³ (K h³: ${compact(said.points * cell)})`,
    );
    read("method-force", `${compact(Math.hypot(...said.force))} N`);
    if (said.taken !== 0) read("method-ticks", `${said.taken} in ${said.ticks} ticks`);
  }
}
