// SPDX-License-Identifier: MIT
// The user's choices of how strokes behave. Guides constrain them to a line, a circle or the path
// of another stroke. A string steadies the hand. Some tools turn their edge to the path by
// themselves. This file sends and draws the choices. The studio applies them
// (kibori/motion/stroke_guide.h).
import * as THREE from "three";
import { element, input, put, select } from "../base/dom";
import { write } from "../connection/messages";
import type { Hit } from "../view/pick";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";

/** In the order of the studio's numbers. */
const GUIDES = ["none", "line", "circle", "curve"];
/**
 * Minimum distance between kept points of a stroke, as a share of the piece's size, and their max
 * count.
 */
const APART = 1 / 400,
  MAX_PLACES = 5000;
/**
 * A self-leading tool enters over this path length [depths] and from this height above the wood
 * [mm].
 */
const ENTRY = 2.5,
  ABOVE = 0.5;

export class StrokeGuide {
  /** The path of the last stroke on the wood, and of the current one. */
  private last: THREE.Vector3[] = [];
  private making: THREE.Vector3[] = [];
  private curve: THREE.Vector3[] = [];
  private centre: Hit | null = null;
  private drawn = new THREE.Group();
  private held: { leads: boolean; depth: number; brush: boolean; every: number | null } = {
    leads: false,
    depth: 0,
    brush: false,
    every: null,
  };

  constructor(
    private view: View,
    private send: (message: Uint8Array) => void,
  ) {
    for (const id of ["guide", "snap"]) select(id).addEventListener("change", () => this.choose());
    for (const id of ["steady", "leads"]) input(id).addEventListener("input", () => this.choose());
    view.showAid(this.drawn);
  }

  /** Starts with another document. */
  begin(): void {
    this.last = [];
    this.curve = [];
    this.making = [];
    this.centre = null;
    this.choose();
  }

  /**
   * Sets the held tool and its depth [mm]. `every` is a stamp's spacing [mm]; null for other tools.
   */
  hold(leads: boolean, depth: number, brush: boolean, every: number | null): void {
    const { held } = this;
    if (
      held.leads === leads &&
      held.depth === depth &&
      held.brush === brush &&
      held.every === every
    )
      return;
    this.held = { leads, depth, brush, every };
    this.choose();
  }

  /** Max distance between hand and tool while nothing holds the tool back [mm]. */
  get slack(): number {
    if (this.kind > 0 || this.stamps) return Infinity;
    const { lead, entry, lift } = this.leading(this.leads, this.held.depth);
    return this.steady + (lead ? entry + lift : 0);
  }
  /**
   * How a self-leading tool enters. `lead`: 1 if it leads itself. `entry`: the length of path that
   * the entry takes. `lift`: the height above the path at its beginning. Both in mm.
   */
  leading(leads: boolean, depth: number): { lead: number; entry: number; lift: number } {
    const deep = Math.max(0.2, depth);
    return {
      lead: leads && input("leads").checked ? 1 : 0,
      entry: ENTRY * deep,
      lift: deep + ABOVE,
    };
  }
  /** True if the guide is a line or a circle, which are in a plane. */
  get plane(): boolean {
    return !this.held.brush && ["line", "circle"].includes(select("guide").value);
  }
  private get kind(): number {
    return GUIDES.indexOf(select("guide").value);
  }
  private get steady(): number {
    return Number(input("steady").value);
  }
  private get leads(): boolean {
    return this.held.leads && !this.held.brush;
  }

  private get stamps(): boolean {
    return this.held.every !== null && !this.held.brush;
  }

  /** A stroke begins on the wood at this point. follow() extends it and lift() ends it. */
  press(at: Hit): void {
    this.making = [at.point.clone()];
    if (select("guide").value !== "circle") return;
    this.centre ??= { point: this.view.middle, normal: at.normal.clone() };
    this.centre.normal = at.normal.clone();
    this.draw(at.point);
  }
  follow(at: Hit): void {
    const last = this.making[this.making.length - 1];
    if (!last || this.making.length >= MAX_PLACES) return;
    if (last.distanceTo(at.point) > APART * this.view.pieceSize) this.making.push(at.point.clone());
  }
  lift(): void {
    if (this.making.length > 1 && select("guide").value !== "curve") this.last = this.making;
    this.making = [];
  }

  /** Sets the circle's centre. */
  setCentre(at: Hit): void {
    this.centre = { point: at.point.clone(), normal: at.normal.clone() };
    select("guide").value = "circle";
    this.choose();
  }

  /** Sends the choices to the studio. */
  choose(): void {
    const guide = select("guide").value;
    element("snaps").hidden = guide !== "line";
    element("circle-help").hidden = guide !== "circle" || this.centre !== null;
    if (guide === "curve" && this.curve.length === 0) this.curve = this.last;
    if (guide !== "curve") this.curve = [];
    const missing = guide === "curve" && this.curve.length < 2;
    element("curve-help").hidden = !missing;
    element("leading").hidden = !this.held.leads;
    put("steady-out", `${this.steady.toFixed(1)} mm`);
    this.send(
      write.ChooseGuide({
        guide: missing ? 0 : this.kind,
        snap: Number(select("snap").value),
        centre: (this.centre?.point ?? this.view.middle).toArray() as Vec3,
        closed: 0,
        steady: this.steady,
        ...this.leading(this.leads, this.held.depth),
        stamp: this.stamps ? 1 : 0,
        every: this.held.every ?? 0,
        curve: new Uint8Array(
          new Float64Array(missing ? [] : this.curve.flatMap((p) => p.toArray())).buffer,
        ),
      }),
    );
    this.draw(null);
  }

  /** Draws the curve, or the circle through a point, slightly in front of the wood. */
  private draw(through: THREE.Vector3 | null): void {
    for (const line of this.drawn.children) (line as THREE.Line).geometry.dispose();
    this.drawn.clear();
    const guide = select("guide").value;
    let points: THREE.Vector3[] = [];
    if (guide === "curve") points = this.curve;
    if (guide === "circle" && this.centre && through) {
      const { point, normal } = this.centre;
      const height = through.clone().sub(point).dot(normal);
      const side = through.clone().sub(point).addScaledVector(normal, -height),
        other = normal.clone().cross(side);
      points = Array.from({ length: 97 }, (_, i) => {
        const a = (2 * Math.PI * i) / 96;
        return point
          .clone()
          .addScaledVector(normal, height)
          .addScaledVector(side, Math.cos(a))
          .addScaledVector(other, Math.sin(a));
      });
    }
    if (points.length > 1)
      this.drawn.add(
        new THREE.Line(
          new THREE.BufferGeometry().setFromPoints(points),
          new THREE.LineBasicMaterial({ color: 0x2c6fbb, depthTest: false, transparent: true }),
        ),
      );
    this.view.redraw();
  }
}
