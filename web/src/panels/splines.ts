// SPDX-License-Identifier: MIT
// Splines by hand. The user puts control points on the piece and moves them with a pointer, several
// fingers or a pen. A preview follows. Applying it makes a step. The last spline can be edited
// again, and later steps are kept.
import { t } from "../base/texts";
import * as THREE from "three";
import { request } from "../connection/access";
import { element, input, put, select } from "../base/dom";
import { notify } from "../base/notice";
import { write, type Previewed } from "../connection/messages";
import type { View } from "../view/view";

type Kind = "sweep" | "extrude" | "revolve";
type Operation = "deposit" | "cut" | "intersect";

/** A spline as documents store it. See kibori/document/body_codec.cpp. */
interface Spline {
  kind: Kind;
  operation: Operation;
  closed: boolean;
  interpolate: boolean;
  points_mm: number[][];
  direction?: number[];
  length_mm?: number;
  axis_point_mm?: number[];
  axis?: number[];
  radius_mm?: number;
}
interface Action {
  verb: "spline";
  bodies: number[];
  material: number;
  spline: Spline;
}

const HELP = t("help_spline");
/** A press this near to a point grabs it [pixels]. */
const NEAR_PX = 16;
const MAX_POINTS = 64;
const HANDLE_PX = 14;
/** Length of an arrow per force [mm / N], and its max length [mm]. */
const MM_PER_NEWTON = 0.5,
  LONGEST_MM = 25;
const COLOR = 0x0072b2,
  HELD = 0xd55e00;

/** A disc with a light edge. */
function disc(): THREE.Texture {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const draw = canvas.getContext("2d")!;
  draw.arc(32, 32, 26, 0, 2 * Math.PI);
  draw.fillStyle = "#fff";
  draw.fill();
  draw.lineWidth = 8;
  draw.strokeStyle = "#0008";
  draw.stroke();
  return new THREE.CanvasTexture(canvas);
}

export class Splines {
  private active = false;
  private points: THREE.Vector3[] = [];
  private touched = -1;
  /** For each pointer: the point that it holds and the plane in which the point moves. */
  private held = new Map<number, { point: number; plane: THREE.Plane }>();
  /** The plane of a profile that is extruded. It contains all points. */
  private profile: THREE.Plane | null = null;
  /** The applied spline that is being edited: its step, and the head at that time. */
  private old: { step: number; parent: number; head: number; body: number } | null = null;
  private axisPoint: THREE.Vector3 | null = null;
  private waits = false; // for the state before the edited step
  private requested = false; // a preview is being computed
  private again = false; // and that preview is already outdated
  private forces: THREE.Vector3[] = [];
  private shown = new THREE.Group();
  private disc = disc();

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
    private send: (message: Uint8Array) => void,
    private holds: () => boolean,
    private body: () => number,
  ) {
    element("spline-draw").onclick = () => (this.active ? this.leaveOff() : this.begin());
    element("spline-edit").onclick = () => void this.edit();
    element("spline-apply").onclick = () => this.apply();
    element("spline-leave").onclick = () => this.leaveOff();
    for (const id of ["spline-kind", "spline-operation"])
      select(id).onchange = () => {
        this.flatten();
        this.changed();
      };
    input("spline-size").oninput = () => this.changed();
    input("spline-closed").onchange = () => this.changed();
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event), { capture: true });
    document.addEventListener("keydown", (event) => this.press(event), { capture: true });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(end, (event) => this.up(event), { capture: true });
  }

  private press(event: KeyboardEvent): void {
    const elsewhere =
      event.target instanceof HTMLInputElement ||
      event.target instanceof HTMLSelectElement ||
      event.target instanceof HTMLButtonElement;
    if (!this.active || elsewhere || document.querySelector("dialog[open]")) return;
    if (event.key === "Enter") this.apply();
    else if (event.key === "Delete" || event.key === "Backspace") this.remove();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Starts with another document or none. */
  reset(): void {
    this.old = null;
    if (this.active) this.end();
  }

  /** Ends the work on Escape. Returns whether there was any. */
  leaveOff(): boolean {
    if (!this.active) return false;
    this.send(write.PreviewAction({ action: "" }));
    if (this.old) this.send(write.Go({ step: this.old.head }));
    this.end();
    return true;
  }
  private apply(): void {
    const action = this.action();
    if (!action) return notify(t("spline_points"));
    const text = JSON.stringify(action);
    if (this.old)
      this.send(write.ReviseStep({ step: this.old.step, head: this.old.head, action: text }));
    else this.send(write.ActOnBodies({ action: text }));
    this.end();
  }
  private remove(): void {
    this.points.splice(this.touched < 0 ? this.points.length - 1 : this.touched, 1);
    this.touched = -1;
    this.forces = [];
    if (this.points.length === 0) this.profile = null;
    this.changed();
  }

  /** Takes the studio's answer to a preview. */
  previewed({ error, forces }: Previewed): void {
    this.requested = false;
    if (!this.active) return;
    put("spline-says", error);
    const all = forces ? (JSON.parse(forces) as number[][]) : [];
    this.forces = this.held.size > 0 ? all.map((f) => new THREE.Vector3(...f)) : [];
    const largest = Math.max(0, ...this.forces.map((f) => f.length()));
    if (!error && largest > 0.05)
      put("spline-says", t("spline_force", { force: largest.toFixed(1) }));
    this.draw();
    if (this.again) this.preview();
  }
  /** Takes the current step. */
  step(now: number): void {
    if (!this.waits || now !== this.old?.parent) return;
    this.waits = false;
    this.view.solid.endStroke();
    this.view.solid.beginStroke();
    this.preview();
  }

  // ---- The spline

  private begin(): void {
    if (!this.holds()) return;
    this.active = true;
    this.points = [];
    this.forces = [];
    this.touched = -1;
    this.profile = null;
    this.axisPoint = null;
    this.old = null;
    element("spline-draw").setAttribute("aria-pressed", "true");
    element("spline-choices").hidden = false;
    put("spline-says", "");
    notify(HELP);
    this.view.showExtra(this.shown);
    // Points are put on the piece, not on the previewed result.
    this.view.solid.beginStroke();
    this.draw();
  }
  private end(): void {
    this.active = this.waits = this.again = false;
    this.old = null;
    this.held.clear();
    element("spline-draw").setAttribute("aria-pressed", "false");
    element("spline-choices").hidden = true;
    if (element("notice").textContent === HELP) notify("");
    this.clear();
    this.view.hideExtra(this.shown);
    this.view.solid.endStroke();
    this.view.cameras.controls.enabled = true;
  }

  /** Edits the last applied spline. Meanwhile the piece is shown as it was before that step. */
  private async edit(): Promise<void> {
    if (!this.holds()) return;
    const answer = await request("/spline").catch(() => null);
    if (!answer?.ok) return notify(answer ? await answer.text() : t("no_answer"));
    const { step, parent, head, action } = (await answer.json()) as {
      step: number;
      parent: number;
      head: number;
      action: Action;
    };
    this.leaveOff();
    this.begin();
    this.old = { step, parent, head, body: action.bodies[0] };
    const { spline } = action;
    select("spline-kind").value = spline.kind;
    select("spline-operation").value = spline.operation;
    input("spline-closed").checked = spline.closed;
    input("spline-size").value = String(spline.radius_mm ?? spline.length_mm ?? 5);
    this.points = spline.points_mm.map((p) => new THREE.Vector3(...p));
    if (spline.axis_point_mm) this.axisPoint = new THREE.Vector3(...spline.axis_point_mm);
    if (spline.direction) {
      const normal = new THREE.Vector3(...spline.direction).normalize();
      if (spline.operation !== "deposit") normal.negate();
      this.profile = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, this.points[0]);
    }
    this.waits = true;
    this.draw();
    this.send(write.Go({ step: parent }));
  }

  private get kind(): Kind {
    return select("spline-kind").value as Kind;
  }
  /** The action. Null if there are too few points. */
  private action(): Action | null {
    const closed = input("spline-closed").checked,
      { kind } = this,
      operation = select("spline-operation").value as Operation,
      size = input("spline-size").valueAsNumber;
    if (this.points.length < (closed || kind === "extrude" ? 3 : 2) || !(size > 0)) return null;
    const spline: Spline = {
      kind,
      operation,
      closed,
      interpolate: true,
      points_mm: this.points.map((p) => p.toArray()),
    };
    if (kind === "sweep") spline.radius_mm = size;
    if (kind === "extrude") {
      const direction = this.profile!.normal.clone();
      if (operation !== "deposit") direction.negate();
      spline.direction = direction.toArray();
      spline.length_mm = size;
    }
    if (kind === "revolve") {
      this.axisPoint ??= this.view.solid.boxOf(this.body()).getCenter(new THREE.Vector3());
      spline.axis_point_mm = this.axisPoint.toArray();
      spline.axis = [0, 0, 1];
    }
    return {
      verb: "spline",
      bodies: [this.old?.body ?? this.body()],
      material: Math.max(0, select("material").selectedIndex),
      spline,
    };
  }

  /**
   * Projects an extruded profile into one plane: the one that faced the viewer when the profile
   * began.
   */
  private flatten(): void {
    put("spline-size-name", t(this.kind === "extrude" ? "length" : "radius"));
    element("spline-size-label").hidden = this.kind === "revolve";
    if (this.kind !== "extrude" || this.points.length === 0) {
      if (this.kind !== "extrude") this.profile = null;
      return;
    }
    this.profile ??= this.facing(this.points[0]);
    for (const point of this.points) this.profile.projectPoint(point, point);
  }
  private facing(point: THREE.Vector3): THREE.Plane {
    return new THREE.Plane().setFromNormalAndCoplanarPoint(
      this.view.cameras.towardsEye(point),
      point,
    );
  }

  private changed(): void {
    this.draw();
    this.preview();
  }
  private preview(): void {
    this.again = this.requested;
    if (this.requested || this.waits || !this.active) return;
    const action = this.action();
    this.requested = true;
    this.send(write.PreviewAction({ action: action ? JSON.stringify(action) : "" }));
  }

  // ---- Pointers

  private nearest(x: number, y: number): number {
    let at = -1,
      near = NEAR_PX;
    this.points.forEach((point, i) => {
      const seen = this.view.cameras.onScreen(point.toArray());
      const far = Math.hypot(seen.x - x, seen.y - y);
      if (far < near) [near, at] = [far, i];
    });
    return at;
  }

  private down(event: PointerEvent): void {
    if (!this.active || event.button !== 0 || this.waits) return;
    const { clientX: x, clientY: y } = event;
    let point = this.nearest(x, y);
    if (point < 0) {
      const hit = this.view.hit(x, y)?.point;
      if (!hit && !event.shiftKey) return; // the view turns
      event.stopImmediatePropagation();
      if (this.points.length >= MAX_POINTS) return notify(t("spline_max", { max: MAX_POINTS }));
      const nearby =
        this.points.at(-1) ?? this.view.solid.boxOf(this.body()).getCenter(new THREE.Vector3());
      const plane = this.profile ?? (hit ? null : this.facing(nearby));
      const place = plane
        ? this.view.cameras.rayAt(x, y).intersectPlane(plane, new THREE.Vector3())
        : hit!.clone();
      if (!place) return;
      point = this.points.push(place) - 1;
      this.forces = [];
      if (this.kind === "extrude") this.profile ??= this.facing(place);
      this.changed();
    }
    event.stopImmediatePropagation();
    this.touched = point;
    this.held.set(event.pointerId, {
      point,
      plane: this.profile ?? this.facing(this.points[point]),
    });
    this.view.cameras.controls.enabled = false;
    this.canvas.setPointerCapture(event.pointerId);
    this.draw();
  }

  private move(event: PointerEvent): void {
    if (!this.active) return;
    const held = this.held.get(event.pointerId);
    // The tool does not follow the pointer meanwhile.
    if (!held) {
      if (event.buttons === 0) event.stopImmediatePropagation();
      return;
    }
    event.stopImmediatePropagation();
    const to = this.view.cameras
      .rayAt(event.clientX, event.clientY)
      .intersectPlane(held.plane, new THREE.Vector3());
    if (!to) return;
    this.points[held.point].copy(to);
    this.changed();
  }

  private up(event: PointerEvent): void {
    if (!this.held.delete(event.pointerId)) return;
    event.stopImmediatePropagation();
    if (this.held.size > 0) return;
    this.view.cameras.controls.enabled = true;
    this.forces = [];
    this.draw();
  }

  // ---- Drawing

  private clear(): void {
    for (const child of this.shown.children as (THREE.Points | THREE.Line)[]) {
      child.geometry.dispose();
      (child.material as THREE.Material).dispose();
    }
    this.shown.clear();
  }
  private draw(): void {
    this.clear();
    const over = { depthTest: false, transparent: true };
    const held = new Set([...this.held.values()].map(({ point }) => point));
    const line = [...this.points];
    if (input("spline-closed").checked && line.length > 2) line.push(line[0]);
    if (line.length > 1)
      this.shown.add(
        new THREE.Line(
          new THREE.BufferGeometry().setFromPoints(line),
          new THREE.LineBasicMaterial({ ...over, color: COLOR, opacity: 0.5 }),
        ),
      );
    for (const [color, of] of [
      [COLOR, (i: number) => !held.has(i)],
      [HELD, (i: number) => held.has(i)],
    ] as const) {
      const some = this.points.filter((_, i) => of(i));
      if (some.length === 0) continue;
      this.shown.add(
        new THREE.Points(
          new THREE.BufferGeometry().setFromPoints(some),
          new THREE.PointsMaterial({
            ...over,
            color,
            map: this.disc,
            size: HANDLE_PX,
            sizeAttenuation: false,
          }),
        ),
      );
    }
    const arrows = this.forces.flatMap((force, i) => {
      const long = Math.min(LONGEST_MM, MM_PER_NEWTON * force.length());
      if (!(long > 0.1) || !this.points[i]) return [];
      return [this.points[i], this.points[i].clone().addScaledVector(force, long / force.length())];
    });
    if (arrows.length > 0)
      this.shown.add(
        new THREE.LineSegments(
          new THREE.BufferGeometry().setFromPoints(arrows),
          new THREE.LineBasicMaterial({ ...over, color: HELD }),
        ),
      );
    this.view.redraw();
  }
}
