// SPDX-License-Identifier: MIT
// The hand: which tool, and where mouse, pen or finger want it.
import * as THREE from "three";
import { BRUSHES, brushButtons, fillPalette } from "../tools/brushes";
import { element, input, put, select } from "../base/dom";
import type { Mode, Model, Tool } from "../connection/kinds";
import { write } from "../connection/messages";
import { newEvents, turnTowards } from "./pointer_path";
import { SecondHand } from "./second_hand";
import { Stamp } from "../tools/stamp";
import { StrokeGuide } from "./stroke_guide";
import {
  TOOLS,
  held,
  heightOf,
  shortened,
  sizeOf,
  toolButtons,
  type HeldTool,
  type Shape,
} from "../tools/tools";
import type { Hit } from "../view/pick";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";

const chosen = (name: string): string =>
  (document.querySelector(`input[name=${name}]:checked`) as HTMLInputElement).value;

/** Height above the wood at which the tool hovers [mm]. */
const HOVER = 2;
/**
 * A path that leaves the wood continues in the plane that it left, for at most this many tool
 * radii.
 */
const BEYOND = 3;

/**
 * Delay from a press to the blow of the mallet, if every press is a blow [ms]. The tool has reached
 * the wood by then.
 */
const BLOW_AFTER_MS = 120;

/** Length of a stamp that is pressed in [mm]. */
const STAMP_LENGTH = 12;
/** Width of the brush that smooths while Shift is down, as a multiple of the tool's width. */
const SHIFT_WIDTH = 1.5;
/**
 * Turn of a twist per pixel that the pointer moves to the right [rad]: half a turn in 300 pixels.
 */
const TURN_PER_PIXEL = 0.01;

/** The surface or plane that depth is measured from. */
type DepthFrom = "began" | "now" | "held" | "set";

export class Hand {
  axis = new THREE.Vector3(0, 0, 1);
  /** True if the hand has pointed anywhere since the document was opened. */
  there = false;
  /**
   * True if a force device holds the tool. The pointer then only turns the view or brings the tool
   * to a place.
   */
  device = false;
  /** True if the document is open read-only. */
  readOnly = false;
  private stroke: {
    pointer: number;
    type: string;
    x: number;
    y: number;
    /** The last position of the path, and the last position on the wood. */
    last: Hit;
    wood: Hit;
    /** The path is in this plane, and depth is measured from it; null: both follow the wood. */
    plane: Hit | null;
    mode: Mode;
    /** Start of a brush that drags or turns: the pointer's x in the window, and the tool's turn. */
    from: { x: number; turn: number };
    /** Time of the latest event that was used [ms]. */
    time: number;
  } | null = null;
  /** The plane that the user set to measure depth from. */
  private plane: Hit | null = null;
  /** The last known place on the wood under the pointer. */
  private over: Hit | null = null;
  /** True while the key that lets a stroke begin anywhere is down. */
  private anywhere = false;
  /** Another finger, or the pointer while a device holds the first tool. */
  readonly second: SecondHand;
  /** Keeps strokes on a guide. */
  private guide: StrokeGuide;
  readonly stamp: Stamp;
  private sliding: { id: "size" | "depth"; x: number; from: number } | null = null;
  private at = { x: 0, y: 0 };
  private shown: HeldTool | null = null;
  private handing = false; // the view is receiving a pointer that was the hand's
  private aimed: Vec3 = [0, 0, 0];

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
    private send: (message: Uint8Array) => void,
    /** Returns true if a press at (x, y) made another body the active one. */
    private takesUp: (x: number, y: number) => boolean,
  ) {
    element("shapes").insertAdjacentHTML("beforeend", toolButtons());
    this.guide = new StrokeGuide(view, (message) => this.readOnly || send(message));
    this.stamp = new Stamp(
      (message) => this.readOnly || send(message),
      () => this.chooseTool(),
    );
    this.second = new SecondHand(canvas, view, send, {
      own: () => this.bare(),
      depth: () => this.depth(),
      radius: () => this.radius(),
      working: () => this.stroke !== null,
      leading: (leads, depth) => this.guide.leading(leads, depth),
      beginning: (x, y) => this.beginning(x, y),
      onPlane: (x, y, plane) => this.onPlane(x, y, plane),
    });
    element("shapes").addEventListener("change", () => this.chooseShape());
    element("brushes").insertAdjacentHTML("beforeend", brushButtons());
    fillPalette(element("palette"));
    element("palette").addEventListener("click", (event) => {
      const { color } = (event.target as HTMLElement).dataset;
      if (color) input("color").value = color;
      this.chooseBrush();
    });
    for (const id of ["brush-strength", "keep", "color", "wall"])
      input(id).addEventListener("input", () => this.chooseBrush());
    select("falloff").addEventListener("change", () => this.chooseBrush());
    for (const id of ["size", "depth", "form"])
      input(id).addEventListener("input", () => this.chooseTool());
    input("turn-by").addEventListener("input", () => this.chooseTurn());
    for (const id of ["strength", "stiffness", "powered"])
      input(id).addEventListener("input", () => this.chooseHand());
    select("depth-from").addEventListener("change", () => this.chooseDepthFrom());
    element("set-plane").onclick = () => this.setPlane();
    element("strike").onclick = () => this.strike();
    for (const id of ["modes", "brushes"])
      element(id).addEventListener("change", () => this.chooseWork());
    for (const id of ["symmetry", "fold", "fold-axis"])
      element(id).addEventListener("change", () => this.chooseSymmetry());
    select("material").onchange = () =>
      this.send(write.ChooseMaterial({ material: Number(select("material").value) }));
    select("model").onchange = () =>
      this.send(write.ChooseModel({ model: select("model").value as Model }));
    this.listenToPointer();
  }

  private listenToPointer(): void {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    // Some browsers report the pointer before the next frame. Then the tool does not wait for the
    // frame.
    canvas.addEventListener(
      "pointerrawupdate",
      (event) =>
        this.second.follow(event as PointerEvent) ||
        (this.stroke && this.follow(event as PointerEvent)),
    );
    canvas.addEventListener("pointerup", (event) => {
      this.second.lift(event.pointerId);
      if (event.pointerId === this.stroke?.pointer) this.lift();
    });
    for (const end of ["pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(end, (event) => {
        this.second.lift(event.pointerId);
        if (event.pointerId === this.stroke?.pointer) this.lift();
      });
    window.addEventListener("blur", () => {
      this.second.lift();
      this.lift();
    });
    for (const [kind, down] of [
      ["keydown", true],
      ["keyup", false],
    ] as const)
      window.addEventListener(kind, (event) => {
        if (event.key.toLowerCase() === "b" && !event.ctrlKey && !event.metaKey)
          this.anywhere = down;
      });
  }

  /** Resets the hand for another document. */
  begin(): void {
    if (this.stroke || this.second.working) this.view.solid.endStroke();
    this.second.begin();
    this.stroke = this.sliding = null;
    this.there = false;
    this.shown = this.plane = this.over = null;
    this.view.marks.showPlane(null);
    this.view.cameras.controls.enabled = true;
    this.stamp.begin();
    this.chooseShape();
    this.guide.begin();
    if (this.readOnly) this.view.marks.showSymmetry(0, 1, 2);
    else this.showSymmetry();
  }

  /** Sends all choices to the studio. */
  chooseAll(): void {
    if (this.readOnly) return;
    this.stamp.begin();
    this.chooseTurn();
    this.chooseHand();
    this.chooseWork();
    this.chooseSymmetry();
    this.guide.choose();
    this.send(write.ChooseMaterial({ material: Number(select("material").value) }));
    this.send(write.ChooseModel({ model: select("model").value as Model }));
    this.second.choose();
  }

  get working(): boolean {
    return this.stroke !== null || this.second.working;
  }
  /** True if the tool is cutting and its tip is far from the place that the hand aims at. */
  heldBack(tip: Vec3): boolean {
    return (
      this.stroke?.mode === "cut" &&
      Math.hypot(...tip.map((x, i) => x - this.aimed[i])) > this.depth() / 2 + this.guide.slack
    );
  }
  /** Message: what to do if the wood holds the tool back. */
  get help(): string {
    const strength = Number(input("strength").value).toFixed(0),
      name = TOOLS[this.shape].name.toLowerCase();
    const more = this.powered
      ? "Raise Strength, or take a smaller tool."
      : "Strike it with the mallet (Space), move it sideways, raise Strength, or take a smaller tool or one with a motor.";
    return `The wood holds the ${name} back: the hand pushes with all its ${strength} N. ${more}`;
  }
  /** True if a motor turns the tool or a press drives it. */
  private get powered(): boolean {
    const { powered, pressed } = TOOLS[this.shape];
    return pressed || (powered && input("powered").checked);
  }

  /** Strikes the tool with the mallet. */
  strike(): void {
    if ((this.stroke?.mode === "cut" || this.device) && !this.powered) this.send(write.Strike());
  }

  /** Sets the plane that depth is measured from to the plane of the wood under the pointer. */
  setPlane(): void {
    if (this.readOnly || !this.over) return;
    this.plane = { point: this.over.point.clone(), normal: this.over.normal.clone() };
    select("depth-from").value = "set";
    this.chooseDepthFrom();
  }
  /** Sets the centre of the circle guide to the wood under the pointer. */
  setCentre(): void {
    if (!this.readOnly && this.over) this.guide.setCentre(this.over);
  }
  private chooseDepthFrom(): void {
    const set = this.depthFrom === "set";
    this.view.marks.showPlane(set ? this.plane : null);
    if (!this.readOnly && this.brush) this.chooseBrush();
    element("plane-help").hidden = !set || this.plane !== null;
  }
  private get depthFrom(): DepthFrom {
    return select("depth-from").value as DepthFrom;
  }
  /** True if this page controls the tool. */
  get holds(): boolean {
    return this.holding;
  }
  set holds(now: boolean) {
    if (now === this.holding) return;
    this.holding = now;
    this.draw();
  }
  private holding = false;

  /** Shows the tool that is held in any page. */
  show(tool: Tool | null): void {
    this.shown = held(tool);
    this.draw();
  }
  /** Shows the triangles of the stamp that is held in any page. */
  showStamp(vertices: Uint8Array, triangles: Uint8Array): void {
    this.stamp.showShape(vertices, triangles);
    this.view.tool.set(null);
    this.draw();
  }

  nudge(id: "size" | "depth", factor: number): void {
    if (this.readOnly) return;
    // At least one step of the slider.
    const now = Number(input(id).value),
      step = Number(input(id).step);
    input(id).value = String(
      factor > 1 ? Math.max(now * factor, now + step) : Math.min(now * factor, now - step),
    );
    this.chooseTool();
  }

  /** Turns the tool by 15 degrees about its axis. */
  turn(): void {
    if (this.readOnly || !TOOLS[this.shape].turns) return;
    input("turn-by").value = String((Number(input("turn-by").value) + 15) % 180);
    this.chooseTurn();
  }

  /**
   * Until the next press, moving the pointer to the right increases the tool's size or depth.
   */
  startSliding(id: "size" | "depth"): void {
    if (!this.readOnly) this.sliding = { id, x: this.at.x, from: Number(input(id).value) };
  }

  /** Switches the mirror plane between left and right on or off. */
  toggleSymmetry(): void {
    if (this.readOnly || this.shape === "mesh") return;
    const boxes = [...element("symmetry").querySelectorAll("input")];
    const any = boxes.some((box) => box.checked);
    boxes.forEach((box, i) => (box.checked = !any && i === 0));
    this.chooseSymmetry();
  }

  /** Picks up a brush. If that brush is already held, lays it down, and the tool carves again. */
  pick(mode: Mode): void {
    if (this.readOnly || this.stroke) return;
    const wanted = this.mode === mode ? "cut" : mode;
    (document.querySelector(`input[name=mode][value=${wanted}]`) as HTMLInputElement).checked =
      true;
    this.chooseWork();
  }

  lift(): void {
    if (!this.stroke) return;
    const { last, mode } = this.stroke;
    this.stroke = null;
    this.guide.lift();
    if (!this.second.goesOn()) {
      this.view.cameras.controls.enabled = true;
      this.view.solid.endStroke();
    }
    this.view.showWheel(this.mode === "turn", false);
    this.send(write.Lift());
    if (BRUSHES[mode]?.goes === "turns") this.chooseTurn();
    if (mode !== this.mode) this.chooseWork();
    this.aim(last, -HOVER, performance.now());
  }

  private radius(): number {
    return Number(input("size").value);
  }
  private get shape(): Shape {
    return chosen("shape") as Shape;
  }
  private get mode(): Mode {
    return chosen("mode") as Mode;
  }
  /** The brush that is held; undefined: a tool is held. */
  private get brush(): (typeof BRUSHES)[Mode] {
    return BRUSHES[this.stroke?.mode ?? this.mode];
  }
  private depth(): number {
    return Number(input("depth").value);
  }
  private get adds(): boolean {
    return !this.device && (this.stroke?.mode ?? this.mode) === "deposit";
  }

  /** Changes to another shape, with the number that this shape had when it was last held. */
  private chooseShape(): void {
    const { form, turns, powered, pressed } = TOOLS[this.shape];
    element("forms").hidden = !form;
    element("stamp").hidden = this.shape !== "mesh";
    element("motor").hidden = !powered || pressed === true;
    element("mallet").hidden = powered;
    element("turns").hidden = !turns;
    if (form) {
      const slider = input("form");
      put("form-name", form.name);
      slider.min = String(form.min);
      slider.max = String(form.max);
      slider.value = String(form.value);
    }
    this.chooseTool();
    if (!this.readOnly) this.chooseHand();
  }
  private chooseTool(): void {
    const tool = this.own(),
      { name, form } = TOOLS[this.shape];
    put("shape-out", name);
    const means =
      tool.shape === "finger"
        ? `, ${sizeOf(tool)}`
        : tool.shape === "mesh"
          ? `, ${this.stamp.sizeOf(2 * this.radius())}`
          : "";
    put("size-out", `${this.radius().toFixed(1)} mm${means}`);
    put("depth-out", `${this.depth().toFixed(1)} mm`);
    // The corner radius is limited by the tool's width.
    const said = tool.shape === "bull" ? tool.corner : (form?.value ?? 0);
    if (form) put("form-out", `${said.toFixed(form.unit === "mm" ? 1 : 0)} ${form.unit}`);
    this.draw();
    if (this.readOnly) return;
    this.second.deepen();
    this.guide.hold(
      TOOLS[this.shape].leads ?? false,
      this.depth(),
      this.brush !== undefined || this.adds,
      tool.shape === "mesh" ? this.stamp.every : null,
    );
    if (tool.shape === "mesh") {
      // Same height and width as a ball. Long enough for its depth, or for the height that it adds.
      const depth = this.depth(),
        radius = this.radius();
      this.stamp.choose({
        size: 2 * radius,
        depth,
        length: this.adds ? depth + Math.max(depth, radius) : STAMP_LENGTH,
      });
    } else {
      this.stamp.leave();
      this.send(write.ChooseTool({ tool }));
    }
    if (this.brush && !this.stroke) this.chooseBrush();
  }
  /** The chosen tool, not yet shortened for adding. */
  private bare(): HeldTool {
    const { form, make } = TOOLS[this.shape];
    if (form) form.value = Number(input("form").value);
    return make(this.radius(), form?.value ?? 0);
  }
  private own(): HeldTool {
    const tool = this.bare();
    return this.adds ? shortened(tool, this.depth() + Math.max(this.depth(), this.radius())) : tool;
  }
  /**
   * Draws the tool: the chosen one if this page holds the tool, else the one that the studio
   * reported.
   */
  private draw(): void {
    const own = this.brush ? null : this.own(); // a brush is a ring on the wood
    this.view.tool.set(this.holds && !this.readOnly ? own : this.shown);
  }
  private chooseTurn(): void {
    const degrees = Number(input("turn-by").value);
    put("turn-out", `${degrees.toFixed(0)}°`);
    this.send(write.ChooseTurn({ turn: (degrees * Math.PI) / 180 }));
  }
  /** The mirror planes as bits: 1 normal to x, 2 to y, 4 to z. */
  private planes(): number {
    return [...element("symmetry").querySelectorAll("input")].reduce(
      (all, box) => all + (box.checked ? Number(box.value) : 0),
      0,
    );
  }
  /** The rotational symmetry: the number of copies, and their axis. */
  private around(): { fold: number; axis: number } {
    const fold = Math.min(16, Math.max(1, Math.round(Number(input("fold").value)) || 1));
    return { fold, axis: Number(select("fold-axis").value) };
  }
  private showSymmetry(): void {
    const { fold, axis } = this.around();
    this.view.marks.showSymmetry(this.planes(), fold, axis);
  }
  private chooseSymmetry(): void {
    const { fold, axis } = this.around();
    input("fold").value = String(fold);
    this.showSymmetry();
    this.send(write.ChooseSymmetry({ planes: this.planes(), fold, axis }));
  }
  /**
   * Chooses the mode. A pointer sends it with each press, so only a device needs a message here.
   */
  private chooseWork(): void {
    const { brush } = this;
    document.body.classList.toggle("brushing", brush !== undefined);
    element("brush").hidden = !brush;
    element("keeps").hidden = !brush?.keeps;
    element("colours").hidden = this.mode !== "paint";
    element("walls").hidden = this.mode !== "turn";
    this.view.showWheel(this.mode === "turn", false);
    put("brush-out", brush?.name ?? "by a brush");
    input("brush-strength").min = this.mode === "inflate" ? "-100" : "0";
    if (brush) input("brush-strength").value = String(100 * brush.strength);
    this.chooseTool();
    this.chooseBrush();
    if (this.device) this.send(write.ChooseWork({ mode: this.mode }));
  }
  /** Sends the chosen brush. `radius` and `strength` replace the chosen values. */
  private chooseBrush(
    radius = this.radius(),
    strength = Number(input("brush-strength").value) / 100,
  ): void {
    if (this.brush && this.brush === BRUSHES[this.mode]) this.brush.strength = strength;
    put("brush-strength-out", `${input("brush-strength").value} %`);
    const wall = Number(input("wall").value);
    put("wall-out", `${wall} mm`);
    const color = parseInt(input("color").value.slice(1), 16),
      set = this.depthFrom === "set" && this.plane;
    this.send(
      write.ChooseBrush({
        radius,
        strength,
        falloff: Number(select("falloff").value),
        keep: input("keep").checked && this.brush?.keeps ? 1 : 0,
        red: color >> 16,
        green: (color >> 8) & 255,
        blue: color & 255,
        plane: set ? 2 : 0,
        wall: this.mode === "turn" ? wall : 0,
        point: set ? (set.point.toArray() as Vec3) : [0, 0, 0],
        normal: set ? (set.normal.toArray() as Vec3) : [0, 0, 1],
      }),
    );
  }
  private chooseHand(): void {
    const strength = Number(input("strength").value),
      stiffness = Number(input("stiffness").value) || 0;
    put("strength-out", `${strength.toFixed(0)} N`);
    this.send(
      write.ChooseHand({
        strength,
        stiffness,
        powered: TOOLS[this.shape].pressed ? 2 : this.powered ? 1 : 0,
      }),
    );
  }

  /** Direction of the tool's axis at a place, out of the wood. */
  private axisAt(hit: Hit, event: PointerEvent): THREE.Vector3 {
    const how = select("axis").value;
    const axis =
      how === "view"
        ? this.view.cameras.towardsEye(hit.point)
        : how === "pen"
          ? this.view.cameras.alongPen(event.tiltX, event.tiltY)
          : hit.normal;
    // If it were flatter, the tool's side would enter the wood.
    return axis.dot(hit.normal) > 0.15 ? axis.clone() : hit.normal.clone();
  }

  /**
   * The tip (the tool's lowest point) at a depth below a place [mm]. A negative depth is above the
   * place.
   */
  private tipAt(hit: Hit, deep: number): Vec3 {
    return hit.point.clone().addScaledVector(this.axis, -deep).toArray() as Vec3;
  }

  /** Sends the place that the hand aims at. `time`: time of the event [ms]. */
  private aim(hit: Hit, deep: number, time: number): void {
    if (this.device || this.readOnly) return;
    this.there = true;
    this.aimed = this.tipAt(hit, deep);
    this.send(write.Aim({ tip: this.aimed, axis: this.axis.toArray() as Vec3, time: time / 1000 }));
  }

  /**
   * Depth of the tip [mm]. A tool that adds stands out of the wood by the depth that it would
   * otherwise sink in.
   */
  private pressed(event: PointerEvent): number {
    if (this.brush) return 0;
    if (this.stroke?.mode === "deposit") return heightOf(this.own()) - this.depth();
    const pen = event.pointerType === "pen" && event.pressure > 0 && input("pressure").checked;
    return pen ? 2 * event.pressure * this.depth() : this.depth();
  }

  /**
   * Point of the plane through a place that is seen at (x, y) in the window; null if the line of
   * sight is nearly parallel to the plane.
   */
  private onPlane(x: number, y: number, plane: Hit): Hit | null {
    const ray = this.view.cameras.rayAt(x, y);
    if (Math.abs(ray.direction.dot(plane.normal)) < 0.05) return null;
    const point = ray.intersectPlane(
      new THREE.Plane().setFromNormalAndCoplanarPoint(plane.normal, plane.point),
      new THREE.Vector3(),
    );
    return point && { point, normal: plane.normal.clone() };
  }

  /**
   * Start of a stroke that is pressed at (x, y): on the wood, next to it within the tool's radius,
   * or anywhere.
   */
  private beginning(x: number, y: number): Hit | null {
    const on = this.view.hit(x, y, true);
    if (on) return on;
    const beside = this.beside(x, y);
    if (beside) return this.onPlane(x, y, beside) ?? beside;
    if (!this.anywhere) return null;
    const point = this.over?.point ?? this.view.cameras.target;
    return this.onPlane(x, y, { point, normal: this.view.cameras.towardsEye(point) });
  }
  /** The nearest wood around a point of the window, within the tool's radius. */
  private beside(x: number, y: number): Hit | null {
    const max =
      this.radius() / this.view.cameras.perPixel(this.over?.point ?? this.view.cameras.target);
    for (let ring = 1; ring <= 4; ring++)
      for (let i = 0; i < 16; i++) {
        const angle = (2 * Math.PI * i) / 16,
          r = (max * ring) / 4;
        const hit = this.view.hit(x + r * Math.cos(angle), y + r * Math.sin(angle), true);
        if (hit) return hit;
      }
    return null;
  }

  private down(event: PointerEvent): void {
    if (this.handing) return;
    element("hint").hidden = true;
    if (this.second.there && (this.stroke || this.device) && this.holds && !this.readOnly)
      if (event.button === 0 && (this.second.down(event) || this.stroke))
        return event.stopImmediatePropagation();
    if (this.stroke && event.pointerType === "touch" && event.pointerId !== this.stroke.pointer) {
      // The hand that holds a pen may rest on the glass.
      if (this.stroke.type !== "touch") return event.stopImmediatePropagation();
      return this.handToView();
    }
    if (this.sliding) {
      this.sliding = null;
      return event.stopImmediatePropagation();
    }
    // Another finger turns the view.
    const first = event.pointerType !== "touch" || event.isPrimary || this.second.working;
    const begins = first && event.button === 0 && this.holds && !this.stroke && !this.readOnly;
    if (begins && this.takesUp(event.clientX, event.clientY)) {
      event.stopImmediatePropagation();
      return;
    }
    const hit = begins ? this.beginning(event.clientX, event.clientY) : null;
    if (!hit) return; // not on the piece: the view turns
    if (this.device) {
      // Above the wood. The view may turn.
      this.axis = hit.normal.clone();
      return this.send(write.BringTool({ tip: this.tipAt(hit, -1) }));
    }
    event.stopImmediatePropagation();
    this.press(event, hit);
  }

  /** Begins a stroke. */
  private press(event: PointerEvent, hit: Hit): void {
    this.canvas.focus();
    this.canvas.setPointerCapture(event.pointerId);
    this.view.cameras.controls.enabled = false;
    this.view.solid.beginStroke();
    const adds = this.mode === "cut" && (event.ctrlKey || event.altKey);
    const mode = event.shiftKey ? "smooth" : adds ? "deposit" : this.mode;
    const goes = BRUSHES[mode]?.goes;
    // A dragged surface moves in the plane across the view.
    const across = { point: hit.point.clone(), normal: this.view.cameras.towardsEye(hit.point) };
    let plane = this.depthFrom === "held" ? hit : this.depthFrom === "set" ? this.plane : null;
    if (BRUSHES[mode]) plane = goes ? across : null;
    const at = plane ? (this.onPlane(event.clientX, event.clientY, plane) ?? hit) : hit;
    this.stroke = {
      pointer: event.pointerId,
      type: event.pointerType,
      x: event.clientX,
      y: event.clientY,
      last: at,
      wood: hit,
      plane,
      mode,
      from: { x: event.clientX, turn: (Number(input("turn-by").value) * Math.PI) / 180 },
      time: event.timeStamp,
    };
    if (mode === "turn") this.view.showWheel(true, true);
    if (mode !== this.mode) {
      this.chooseTool();
      // With Shift, one or two strokes smooth an edge away.
      if (this.brush) this.chooseBrush(SHIFT_WIDTH * this.radius(), 1);
    }
    this.axis = this.axisAt(goes ? hit : at, event);
    this.aimed = this.tipAt(at, this.pressed(event));
    this.there = true;
    this.guide.press(at);
    this.send(
      write.Press({
        tip: this.aimed,
        axis: this.axis.toArray() as Vec3,
        mode,
        time: event.timeStamp / 1000,
      }),
    );
    if (input("blows").checked)
      setTimeout(() => this.stroke?.time === event.timeStamp && this.strike(), BLOW_AFTER_MS);
  }

  /**
   * Two fingers turn the view. Cancels the stroke of the first finger and passes that finger to the
   * view.
   */
  private handToView(): void {
    const { pointer, x, y } = this.stroke!;
    this.send(write.Cancel());
    this.lift();
    this.handing = true;
    this.canvas.dispatchEvent(
      new PointerEvent("pointerdown", {
        pointerId: pointer,
        pointerType: "touch",
        isPrimary: true,
        buttons: 1,
        clientX: x,
        clientY: y,
      }),
    );
    this.handing = false;
  }

  private move(event: PointerEvent): void {
    this.at = { x: event.clientX, y: event.clientY };
    if (this.sliding) {
      input(this.sliding.id).value = String(
        this.sliding.from * 1.01 ** (event.clientX - this.sliding.x),
      );
      return this.chooseTool();
    }
    if (this.second.follow(event)) return;
    if (this.stroke) return this.follow(event);
    if (event.buttons !== 0) return;
    this.over = this.view.hit(event.clientX, event.clientY);
    this.view.marks.showRing(this.over, this.radius());
    if (!this.over || !this.holds) return;
    this.axis = this.axisAt(this.over, event);
    this.aim(this.over, -HOVER, event.timeStamp);
  }

  /**
   * Continues the stroke through every event that the browser has coalesced, each at its own time.
   */
  private follow(event: PointerEvent): void {
    const stroke = this.stroke!;
    if (event.pointerId !== stroke.pointer) return;
    Object.assign(stroke, { x: event.clientX, y: event.clientY });
    for (const one of newEvents(event, stroke)) this.followTo(one);
    this.view.marks.showRing(stroke.last, this.radius());
  }
  private followTo(event: PointerEvent): void {
    const stroke = this.stroke!,
      { clientX: x, clientY: y } = event;
    const goes = this.brush?.goes;
    if (goes === "turns") {
      const turn = stroke.from.turn + TURN_PER_PIXEL * (x - stroke.from.x);
      this.send(write.ChooseTurn({ turn }));
      return this.aim(stroke.last, 0, event.timeStamp);
    }
    let at: Hit | null;
    if (stroke.plane) {
      at = this.onPlane(x, y, stroke.plane);
    } else {
      at = this.view.hit(x, y, this.depthFrom === "began" && !this.brush);
      if (at) stroke.wood = at;
      // Off the wood, the path continues in the plane that it left, so that the tool comes out of
      // the wood.
      else at = this.onPlane(x, y, stroke.wood);
      if (
        at &&
        at !== stroke.wood &&
        at.point.distanceTo(stroke.wood.point) > BEYOND * this.radius()
      )
        at = null;
    }
    if (at) {
      const way = at.point.distanceTo(stroke.last.point);
      stroke.last = at;
      this.guide.follow(at);
      if (goes) return this.aim(at, 0, event.timeStamp);
      const wanted = this.axisAt(at, event);
      this.axis =
        select("axis").value === "normal"
          ? turnTowards(this.axis, wanted, way, this.radius())
          : wanted;
    }
    this.aim(stroke.last, this.pressed(event), event.timeStamp);
  }
}
