// SPDX-License-Identifier: MIT
// The hand: which tool, and where mouse, pen or finger want it.
import * as THREE from "three";
import { element, input, put, select } from "./dom";
import { write } from "./messages";
import type { Hit, View } from "./view";
import type { Vec3 } from "./wire";

const chosen = (name: string): number => Number((document.querySelector(`input[name=${name}]:checked`) as HTMLInputElement).value);

/** From a tool's tip to its other end [mm], where its size does not say. */
const TOOL_LENGTH = 25, FINGER_LENGTH = 20;
/** Shapes as of ChooseTool, of a radius and of one number more, which only some have [mm]. */
interface Shape {
  name: string;
  form?: { name: string; unit: string; least: number; most: number; value: number };
  tool(radius: number, form: number): { size: number; length: number; other: number };
  /** Whether it matters how far it is turned about its axis. */
  turns?: boolean;
}
const SHAPES: Shape[] = [
  { name: "Ball", tool: (r) => ({ size: r, length: 2 * r, other: 0 }) },
  // Its Ks such that it is as wide as a ball would be, a radius above its tip.
  { name: "Finger", tool: (r) => ({ size: 1 / r, length: FINGER_LENGTH, other: 0 }) },
  { name: "End mill", tool: (r) => ({ size: r, length: TOOL_LENGTH, other: 0 }) },
  { name: "Capsule", tool: (r) => ({ size: r, length: TOOL_LENGTH + 2 * r, other: 0 }) },
  {
    name: "Bull nose",
    form: { name: "Corner", unit: "mm", least: 0.1, most: 12, value: 1.5 },
    tool: (r, corner) => ({ size: r, length: TOOL_LENGTH, other: Math.min(corner, r) }),
  },
  { name: "V cutter", form: { name: "Angle", unit: "°", least: 20, most: 150, value: 90 }, tool: (r, angle) => ({ size: r, length: TOOL_LENGTH, other: angle }) },
  { name: "Box", form: { name: "Breadth", unit: "mm", least: 0.5, most: 24, value: 4 }, tool: (r, breadth) => ({ size: 2 * r, length: breadth, other: TOOL_LENGTH }), turns: true },
  { name: "Ellipsoid", form: { name: "Breadth", unit: "mm", least: 1, most: 24, value: 12 }, tool: (r, breadth) => ({ size: r, length: breadth / 2, other: r }), turns: true },
];
/** A tool as ChooseTool and ShowTool say it. */
interface Held {
  shape: number;
  size: number;
  length: number;
  other: number;
}
/** From the tip to the other end [mm]. */
const heightOf = ({ shape, size, length, other }: Held): number => (shape === 0 ? 2 * size : shape === 6 ? other : shape === 7 ? 2 * other : length);
/** No higher than so, where its shape allows: what is added is not to come out of the other side of the wood. */
function shortened(held: Held, height: number): Held {
  const { shape, size, length, other } = held;
  if (shape === 6) return { ...held, other: Math.min(other, height) };
  const least = shape === 3 ? 2 * size : shape === 4 ? 2 * other : 0;
  return shape === 0 || shape === 7 ? held : { ...held, length: Math.min(length, Math.max(height, least)) };
}
const AIM_EVERY_MS = 4;
/** The modes of Press. */
const CUT = 0, FILL = 1;

export class Hand {
  axis = new THREE.Vector3(0, 0, 1);
  /** Whether it has pointed anywhere since the document was opened. */
  there = false;
  /** Whether a force device holds the tool; then the pointer only looks, and brings it to a place. */
  device = false;
  /** Whether the document is only looked at. */
  readOnly = false;
  private stroke: { pointer: number; type: string; x: number; y: number; last: Hit; mode: number } | null = null;
  private sliding: { id: "size" | "depth"; x: number; from: number } | null = null;
  private at = { x: 0, y: 0 };
  private shown: Held | null = null;
  private handing = false; // the view is told of a pointer that was the hand's
  private aimed: Vec3 = [0, 0, 0];
  private aimedAt = 0;

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
    private send: (message: Uint8Array) => void,
  ) {
    element("shapes").addEventListener("change", () => this.chooseShape());
    for (const id of ["size", "depth", "form"]) input(id).addEventListener("input", () => this.chooseTool());
    input("turn-by").addEventListener("input", () => this.chooseTurn());
    input("spring").addEventListener("input", () => this.chooseSpring());
    element("modes").addEventListener("change", () => this.chooseWork());
    element("symmetry").addEventListener("change", () => this.chooseSymmetry());
    select("material").onchange = () => this.send(write.ChooseMaterial({ material: Number(select("material").value) }));
    select("model").onchange = () => this.send(write.ChooseModel({ model: Number(select("model").value) }));
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event));
    // Where the browser tells of the pointer before the next frame, the tool need not wait for that.
    canvas.addEventListener("pointerrawupdate", (event) => this.stroke && event.timeStamp - this.aimedAt >= AIM_EVERY_MS && this.move(event as PointerEvent));
    canvas.addEventListener("pointerup", (event) => event.pointerId === this.stroke?.pointer && this.lift());
    for (const end of ["pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(end, (event) => event.pointerId === this.stroke?.pointer && this.lift());
    window.addEventListener("blur", () => this.lift());
  }

  /** Another document: nothing is under way. */
  begin(): void {
    if (this.stroke) this.view.endStroke();
    this.stroke = this.sliding = null;
    this.there = false;
    this.shown = null;
    this.view.controls.enabled = true;
    this.chooseShape();
    this.view.mirrored = this.readOnly ? 0 : this.planes();
  }

  /** All that is chosen, to the studio. */
  chooseAll(): void {
    if (this.readOnly) return;
    this.chooseTool();
    this.chooseTurn();
    this.chooseSpring();
    this.chooseSymmetry();
    this.chooseWork();
    this.send(write.ChooseMaterial({ material: Number(select("material").value) }));
    this.send(write.ChooseModel({ model: Number(select("model").value) }));
  }

  get working(): boolean {
    return this.stroke !== null;
  }
  /** Whether the tool, whose tip is there, is to cut and far from where it is wanted. */
  heldBack(tip: Vec3): boolean {
    return this.stroke?.mode === CUT && Math.hypot(...tip.map((x, i) => x - this.aimed[i])) > this.depth() / 2;
  }
  /** Whether this page holds the tool. */
  get holds(): boolean {
    return this.holding;
  }
  set holds(now: boolean) {
    if (now === this.holding) return;
    this.holding = now;
    this.draw();
  }
  private holding = false;

  /** The tool that is held in some page. */
  show(tool: Held): void {
    this.shown = tool;
    this.draw();
  }

  nudge(id: "size" | "depth", factor: number): void {
    if (this.readOnly) return;
    // At least by what the slider goes at once.
    const now = Number(input(id).value), step = Number(input(id).step);
    input(id).value = String(factor > 1 ? Math.max(now * factor, now + step) : Math.min(now * factor, now - step));
    this.chooseTool();
  }

  /** A little further about its axis. */
  turn(): void {
    if (this.readOnly || !SHAPES[this.shape].turns) return;
    input("turn-by").value = String((Number(input("turn-by").value) + 15) % 180);
    this.chooseTurn();
  }

  /** From now on, the pointer's way to the right is the tool's size, or its depth; until it is pressed. */
  startSliding(id: "size" | "depth"): void {
    if (!this.readOnly) this.sliding = { id, x: this.at.x, from: Number(input(id).value) };
  }

  /** The plane through the left and right halves, or none. */
  toggleSymmetry(): void {
    if (this.readOnly) return;
    const boxes = [...element("symmetry").querySelectorAll("input")];
    const any = boxes.some((box) => box.checked);
    boxes.forEach((box, i) => (box.checked = !any && i === 0));
    this.chooseSymmetry();
  }

  lift(): void {
    if (!this.stroke) return;
    const { last, mode } = this.stroke;
    this.stroke = null;
    this.view.controls.enabled = true;
    this.view.endStroke();
    this.send(write.Lift());
    if (mode !== chosen("mode")) this.chooseTool();
    this.aim(last, -2);
  }

  private radius(): number {
    return Number(input("size").value);
  }
  private get shape(): number {
    return chosen("shape");
  }
  private depth(): number {
    return Number(input("depth").value);
  }
  private get adds(): boolean {
    return !this.device && (this.stroke?.mode ?? chosen("mode")) === FILL;
  }

  /** Another shape, with the number it had when it was last held. */
  private chooseShape(): void {
    const { form, turns } = SHAPES[this.shape];
    element("forms").hidden = !form;
    element("turns").hidden = !turns;
    if (form) {
      const slider = input("form");
      put("form-name", form.name);
      slider.min = String(form.least);
      slider.max = String(form.most);
      slider.value = String(form.value);
    }
    this.chooseTool();
  }
  private chooseTool(): void {
    const { shape, size, length, other } = this.own(), radius = this.radius(), { name, form } = SHAPES[shape];
    put("shape-out", name);
    put("size-out", `${radius.toFixed(1)} mm${shape === 1 ? `, Ks ${size.toFixed(2)}/mm` : ""}`);
    put("depth-out", `${this.depth().toFixed(1)} mm`);
    // A corner is no wider than the tool.
    const said = form?.name === "Corner" ? other : (form?.value ?? 0);
    if (form) put("form-out", `${said.toFixed(form.unit === "°" ? 0 : 1)} ${form.unit}`);
    this.draw();
    if (!this.readOnly) this.send(write.ChooseTool({ shape, size, length, other }));
  }
  private own(): Held {
    const shape = this.shape, { form, tool } = SHAPES[shape];
    if (form) form.value = Number(input("form").value);
    const held = { shape, ...tool(this.radius(), form?.value ?? 0) };
    return this.adds ? shortened(held, this.depth() + Math.max(this.depth(), this.radius())) : held;
  }
  /** The tool that is held: here, as it is chosen; elsewhere, as the studio says. */
  private draw(): void {
    const held = this.holds && !this.readOnly ? this.own() : this.shown;
    if (held) this.view.setTool(held.shape, held.size, held.length, held.other);
  }
  private chooseTurn(): void {
    const degrees = Number(input("turn-by").value);
    put("turn-out", `${degrees.toFixed(0)}°`);
    this.send(write.ChooseTurn({ turn: (degrees * Math.PI) / 180 }));
  }
  /** As bits: 1 normal to x, 2 to y, 4 to z. */
  private planes(): number {
    return [...element("symmetry").querySelectorAll("input")].reduce((all, box) => all + (box.checked ? Number(box.value) : 0), 0);
  }
  private chooseSymmetry(): void {
    this.view.mirrored = this.planes();
    this.send(write.ChooseSymmetry({ planes: this.planes() }));
  }
  /** A pointer says what its tool does when it presses. */
  private chooseWork(): void {
    this.chooseTool();
    if (this.device) this.send(write.ChooseWork({ mode: chosen("mode") }));
  }
  private chooseSpring(): void {
    const stiffness = 10 ** Number(input("spring").value);
    element("spring-out").textContent = `${stiffness.toPrecision(2)} N/mm`;
    this.send(write.ChooseSpring({ stiffness }));
  }

  /** Which way the tool points there: away from the wood. */
  private axisAt(hit: Hit, event: PointerEvent): THREE.Vector3 {
    const how = select("axis").value;
    const axis = how === "view" ? this.view.towardsEye(hit.point) : how === "pen" ? this.view.alongPen(event.tiltX, event.tiltY) : hit.normal;
    // Flatter than that it would go through the wood with its side.
    return axis.dot(hit.normal) > 0.15 ? axis.clone() : hit.normal.clone();
  }

  /** The tip, the tool's lowest point, that presses so deep at a place; above it for a depth below zero. */
  private tipAt(hit: Hit, deep: number): Vec3 {
    return hit.point.clone().addScaledVector(this.axis, -deep).toArray() as Vec3;
  }

  private aim(hit: Hit, deep: number): void {
    if (this.device || this.readOnly) return;
    this.there = true;
    this.aimedAt = performance.now();
    this.aimed = this.tipAt(hit, deep);
    this.send(write.Aim({ tip: this.aimed, axis: this.axis.toArray() as Vec3 }));
  }

  /** How deep: where it adds, so that the tool stands out as much as it else would sink in. */
  private pressed(event: PointerEvent): number {
    if (this.stroke?.mode === FILL) return heightOf(this.own()) - this.depth();
    const pen = event.pointerType === "pen" && event.pressure > 0 && input("pressure").checked;
    return pen ? 2 * event.pressure * this.depth() : this.depth();
  }

  private down(event: PointerEvent): void {
    if (this.handing) return;
    element("hint").hidden = true;
    if (this.stroke && event.pointerType === "touch" && event.pointerId !== this.stroke.pointer) {
      // The hand that holds a pen may rest on the glass.
      if (this.stroke.type !== "touch") return event.stopImmediatePropagation();
      // Two fingers look; what the first began was not meant, and the view is told of it now.
      const { pointer, x, y } = this.stroke;
      this.send(write.Cancel());
      this.lift();
      this.handing = true;
      this.canvas.dispatchEvent(new PointerEvent("pointerdown", { pointerId: pointer, pointerType: "touch", isPrimary: true, buttons: 1, clientX: x, clientY: y }));
      this.handing = false;
      return;
    }
    if (this.sliding) {
      this.sliding = null;
      return event.stopImmediatePropagation();
    }
    const first = event.pointerType !== "touch" || event.isPrimary; // another finger looks
    const hit = first && event.button === 0 && this.holds && !this.stroke && !this.readOnly ? this.view.hit(event.clientX, event.clientY) : null;
    if (!hit) return; // beside it: the view turns
    if (this.device) {
      // Clear of the wood; the view may turn.
      this.axis = hit.normal.clone();
      return this.send(write.BringTool({ tip: this.tipAt(hit, -1) }));
    }
    event.stopImmediatePropagation();
    this.canvas.focus();
    this.canvas.setPointerCapture(event.pointerId);
    this.view.controls.enabled = false;
    this.view.beginStroke();
    const mode = chosen("mode") === CUT && (event.ctrlKey || event.altKey) ? FILL : chosen("mode");
    this.stroke = { pointer: event.pointerId, type: event.pointerType, x: event.clientX, y: event.clientY, last: hit, mode };
    if (mode !== chosen("mode")) this.chooseTool();
    this.axis = this.axisAt(hit, event);
    // To cut, from so far above that walls beside the place are not in the way. To add, where it adds.
    const deep = this.pressed(event), from = mode === FILL ? deep : -Math.max(1, this.radius());
    this.send(write.Press({ tip: this.tipAt(hit, from), axis: this.axis.toArray() as Vec3, mode }));
    this.aim(hit, deep);
  }

  private move(event: PointerEvent): void {
    this.at = { x: event.clientX, y: event.clientY };
    if (this.sliding) {
      input(this.sliding.id).value = String(this.sliding.from * 1.01 ** (event.clientX - this.sliding.x));
      return this.chooseTool();
    }
    const hit = this.view.hit(event.clientX, event.clientY);
    if (this.stroke) {
      if (event.pointerId !== this.stroke.pointer) return;
      Object.assign(this.stroke, this.at);
      if (hit) this.stroke.last = hit;
      this.axis = this.axisAt(this.stroke.last, event);
      this.aim(this.stroke.last, this.pressed(event));
      this.view.showRing(this.stroke.last, this.radius());
    } else if (event.buttons === 0) {
      this.view.showRing(hit, this.radius());
      if (!hit || !this.holds) return;
      this.axis = this.axisAt(hit, event);
      this.aim(hit, -2);
    }
  }
}
