// SPDX-License-Identifier: MIT
// The hand. It chooses the tool and turns mouse, pen and touch events into aims and strokes.
import { t } from "../base/texts";
import * as THREE from "three";
import { alphaOptions, BRUSHES, brushButtons, fillPalette, inverseOf } from "../tools/brushes";
import { element, input, put, select } from "../base/dom";
import { ALPHAS, type Alpha, type Mode, type Model, type Tool } from "../connection/kinds";
import { write } from "../connection/messages";
import { newEvents, turnTowards } from "./pointer_path";
import { pressureOf, pressureUse, sizeShare } from "./pen";
import { MaskControls } from "./mask";
import { SecondHand } from "./second_hand";
import { Stamp } from "../tools/stamp";
import { Texture } from "../tools/texture";
import { controlsOf, ToolMemory, type Values } from "../tools/tool_memory";
import { AtCursor } from "./at_cursor";
import { StrokeGuide } from "./stroke_guide";
import {
  TOOLS,
  held,
  heightOf,
  shortened,
  sizeOf,
  shapeOf,
  toolButtons,
  type HeldTool,
  type Shape,
} from "../tools/tools";
import type { Hit } from "../view/pick";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";

const chosen = (name: string): string =>
  (document.querySelector(`input[name=${name}]:checked`) as HTMLInputElement).value;

/** Height of the hovering tool above the wood [mm]. */
const HOVER = 2;
/** A path that leaves the wood continues along the last plane for this distance [tool radii]. */
const BEYOND = 3;

/**
 * Delay from a press to the mallet's blow, if every press is a blow [ms]. The tool reaches the wood
 * in this time.
 */
const BLOW_AFTER_MS = 120;

/** Length of pressed letters [mm]. */
const STAMP_LENGTH = 12;
/** With Shift, the brush smooths, and it is wider than the tool by this factor. */
const SHIFT_WIDTH = 1.5;
/**
 * Rotation of a twisted part per pixel of pointer motion to the right [rad]: half a turn in 300
 * pixels.
 */
const TURN_PER_PIXEL = 0.01;

/** The reference from which depth is measured. */
type DepthFrom = "began" | "now" | "held" | "set";
/** The numbers that the pointer or keys can change. */
export type Amount = "size" | "depth" | "brush-strength" | "strength";
/** Prefix of the names of brushes in tool_memory.ts. */
const BRUSH = "brush:";

/** The name for the user of a tool or brush that is stored in tool_memory.ts. Null: unknown. */
export function itemName(item: string): string | null {
  const shape = shapeOf(item);
  if (shape) return TOOLS[shape].name;
  return item.startsWith(BRUSH) ? (BRUSHES[item.slice(BRUSH.length) as Mode]?.name ?? null) : null;
}

export class Hand {
  axis = new THREE.Vector3(0, 0, 1);
  /** True if the pointer has aimed since the document was opened. */
  there = false;
  /**
   * True if a force device holds the tool. Then the pointer only turns the view, or moves the tool
   * to a place on the wood.
   */
  device = false;
  /** True if the document is open read-only. */
  readOnly = false;
  private stroke: {
    pointer: number;
    type: string;
    x: number;
    y: number;
    /** The path's current position, and its last position on the wood. */
    last: Hit;
    wood: Hit;
    /**
     * Depth is measured from this plane, and the path is in it. Null: the path follows the wood.
     */
    plane: Hit | null;
    mode: Mode;
    /** True if a key inverts the brush by a negative strength. */
    negative: boolean;
    /** Where a brush that turns or scales began: the pointer's place and the tool's rotation. */
    from: { x: number; y: number; turn: number };
    /** Time of the newest event that was used [ms]. */
    time: number;
    /** Pressure of the pen, 0 to 1. */
    pressure: number;
  } | null = null;
  /** The plane from which depth is measured, if the user has set one. */
  private plane: Hit | null = null;
  /** The wood under the pointer when it last hovered. */
  private over: Hit | null = null;
  /** True if the key that lets a stroke begin anywhere is down. */
  private anywhere = false;
  /** The second hand: another finger, or the pointer in addition to a force device. */
  readonly second: SecondHand;
  /** The guide that constrains strokes. */
  private guide: StrokeGuide;
  readonly stamp: Stamp;
  private texture: Texture;
  private masks: MaskControls;
  private sliding: { id: Amount; x: number; from: number } | null = null;
  /** The brush in the hand. Null: a tool. */
  private heldBrush: Mode | null = null;
  private memory = new ToolMemory();
  /** How far each shape is turned in this document [degrees]. */
  private turns = new Map<Shape, string>();
  private atCursor = new AtCursor();
  private keysDown = { shift: false, inverts: false };
  private at = { x: 0, y: 0 };
  private shown: HeldTool | null = null;
  private handing = false; // while the hand passes its pointer on to the view
  private aimed: Vec3 = [0, 0, 0];

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
    private send: (message: Uint8Array) => void,
    /** Tries to make the body at this point active. Returns whether it did. */
    private takesUp: (x: number, y: number) => boolean,
  ) {
    element("shapes").insertAdjacentHTML("beforeend", toolButtons());
    this.guide = new StrokeGuide(view, (message) => this.readOnly || send(message));
    this.stamp = new Stamp(
      (message) => this.readOnly || send(message),
      () => this.chooseTool(),
    );
    this.texture = new Texture(
      (message) => this.readOnly || send(message),
      () => this.chooseBrush(),
    );
    this.masks = new MaskControls((message) => this.readOnly || send(message), {
      bounds: () => view.solid.boxOf(null),
      plane: () => this.plane,
      restore: () => this.chooseBrush(),
      hide: (hides) => view.hideMasked(hides),
    });
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
    select("alpha").innerHTML = alphaOptions();
    fillPalette(element("palette"));
    element("palette").addEventListener("click", (event) => {
      const { color } = (event.target as HTMLElement).dataset;
      if (color) input("color").value = color;
      this.chooseBrush();
    });
    // These listeners are the first, so that later ones find the numbers stored.
    for (const id of new Set([...controlsOf(false), ...controlsOf(true)]))
      input(id).addEventListener("input", () => this.remember());
    for (const id of ["brush-strength", "keep", "color", "wall"])
      input(id).addEventListener("input", () => this.chooseBrush());
    for (const id of ["falloff", "alpha"])
      select(id).addEventListener("change", () => {
        this.remember();
        this.showControls();
        this.chooseBrush();
      });
    select("pen-brush").addEventListener("change", () => this.chooseBrush());
    for (const id of ["size", "depth", "form"])
      input(id).addEventListener("input", () => this.chooseTool());
    input("turn-by").addEventListener("input", () => {
      this.turns.set(this.shape, input("turn-by").value);
      this.chooseTurn();
    });
    element("turn-reset").onclick = () => this.turnTo("0");
    for (const id of ["strength", "stiffness", "powered"])
      input(id).addEventListener("input", () => this.chooseHand());
    select("depth-from").addEventListener("change", () => this.chooseDepthFrom());
    element("set-plane").onclick = () => this.setPlane();
    element("strike").onclick = () => this.strike();
    element("modes").addEventListener("change", () => this.chooseWork());
    element("brushes").addEventListener("change", (event) =>
      this.holdBrush((event.target as HTMLInputElement).value as Mode),
    );
    // A click on the current brush puts it away. A click on a tool or a mode takes the tool.
    for (const id of ["brushes", "shapes", "modes"])
      element(id).addEventListener("click", (event) => {
        if (!(event.target instanceof HTMLInputElement)) return;
        const { value } = event.target;
        if (id === "shapes" && this.heldBrush) this.take(value as Shape);
        if (id === "modes" || value === this.heldBrush) this.holdBrush(null);
      });
    select("second-mode").addEventListener("change", () => this.showControls());
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
    // Some browsers report the pointer before the next frame. The tool then does not wait for the
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
        this.keysDown = { shift: event.shiftKey, inverts: event.ctrlKey || event.altKey };
        if (["Control", "Alt", "Shift"].includes(event.key)) this.showRing();
      });
    window.addEventListener("blur", () => {
      this.keysDown = { shift: false, inverts: false };
      this.showRing();
    });
  }

  /** Starts with another document. No stroke is in progress. */
  begin(): void {
    if (this.stroke || this.second.working) this.view.solid.endStroke();
    this.second.begin();
    this.stroke = this.sliding = null;
    this.there = false;
    this.shown = this.plane = this.over = null;
    this.view.marks.showPlane(null);
    this.view.cameras.controls.enabled = true;
    this.stamp.begin();
    this.texture.begin();
    this.turns.clear();
    input("turn-by").value = "0";
    this.chooseShape();
    if (!this.readOnly) this.chooseTurn();
    this.guide.begin();
    if (this.readOnly) this.view.marks.showSymmetry(0, 1, 2);
    else this.showSymmetry();
  }

  /** Sends all choices to the studio. */
  chooseAll(): void {
    if (this.readOnly) return;
    this.stamp.begin();
    this.texture.begin();
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
  /** True if a cutting tool is far from its target. `tip` is the tool's tip [mm]. */
  heldBack(tip: Vec3): boolean {
    return (
      this.stroke?.mode === "cut" &&
      Math.hypot(...tip.map((x, i) => x - this.aimed[i])) > this.depth() / 2 + this.guide.slack
    );
  }
  /** Advice for the user if the wood holds the tool back. */
  get help(): string {
    const strength = Number(input("strength").value).toFixed(0),
      name = TOOLS[this.shape].name.toLowerCase();
    return t(this.powered ? "held_back_powered" : "held_back", { tool: name, strength });
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

  /** Measures depth from the plane of the wood under the pointer. */
  setPlane(): void {
    if (this.readOnly || !this.over) return;
    this.plane = { point: this.over.point.clone(), normal: this.over.normal.clone() };
    select("depth-from").value = "set";
    this.chooseDepthFrom();
  }
  /** Guides strokes in circles about the point of the wood under the pointer. */
  setCentre(): void {
    if (!this.readOnly && this.over) this.guide.setCentre(this.over);
  }
  private chooseDepthFrom(): void {
    const set = this.depthFrom === "set";
    this.view.marks.showPlane(set ? this.plane : null);
    if (!this.readOnly && this.brush) this.chooseBrush();
    element("plane-help").hidden = !set || this.plane !== null;
    this.showControls();
  }
  private get depthFrom(): DepthFrom {
    return select("depth-from").value as DepthFrom;
  }
  /** True if this page holds the tool. */
  get holds(): boolean {
    return this.holding;
  }
  set holds(now: boolean) {
    if (now === this.holding) return;
    this.holding = now;
    this.draw();
  }
  private holding = false;

  /** Shows the tool that another page holds. */
  show(tool: Tool | null): void {
    this.shown = held(tool);
    this.draw();
  }
  /** Shows the triangles of the stamp that some page holds. */
  showStamp(vertices: Uint8Array, triangles: Uint8Array): void {
    this.stamp.showShape(vertices, triangles);
    this.view.tool.set(null);
    this.draw();
  }

  nudge(id: Amount, factor: number): void {
    if (this.readOnly) return;
    // Change by at least one step of the slider.
    const now = Number(input(id).value),
      step = Number(input(id).step);
    this.setAmount(
      id,
      factor > 1 ? Math.max(now * factor, now + step) : Math.min(now * factor, now - step),
    );
  }
  /** The strength of what is held: of the brush, or of the hand. */
  get strength(): Amount {
    return this.heldBrush ? "brush-strength" : "strength";
  }
  /** Sets a number and shows it at the pointer. */
  private setAmount(id: Amount, value: number): void {
    input(id).value = String(value);
    this.remember();
    if (id === "strength") this.chooseHand();
    else if (id === "brush-strength") this.chooseBrush();
    else this.chooseTool();
    const text = element(`${id}-out`).textContent ?? "";
    this.atCursor.show(
      id === "size"
        ? t("size_now", { size: text })
        : id === "depth"
          ? t("depth_now", { depth: text })
          : t("brush_now", { strength: text }),
      this.at,
    );
    this.showRing();
  }

  /** Turns the tool by 15 degrees about its axis. */
  turn(): void {
    if (this.readOnly || !TOOLS[this.shape].turns) return;
    this.turnTo(String((Number(input("turn-by").value) + 15) % 180));
  }
  private turnTo(degrees: string): void {
    input("turn-by").value = degrees;
    this.turns.set(this.shape, degrees);
    this.chooseTurn();
    this.atCursor.show(t("turned_now", { turn: degrees }), this.at);
  }

  /** Starts changing a number by pointer motion to the right. A press ends it. */
  startSliding(id: Amount): void {
    if (!this.readOnly) this.sliding = { id, x: this.at.x, from: Number(input(id).value) };
  }

  /** Toggles the symmetry plane between the left and right halves. */
  toggleSymmetry(): void {
    if (this.readOnly) return;
    const boxes = [...element("symmetry").querySelectorAll("input")];
    const any = boxes.some((box) => box.checked);
    boxes.forEach((box, i) => (box.checked = !any && i === 0));
    this.chooseSymmetry();
  }

  /** Picks up a brush. If it is already held, the tool carves again. */
  pick(mode: Mode): void {
    if (!this.readOnly && !this.stroke) this.holdBrush(this.heldBrush === mode ? null : mode);
  }
  /** Takes a tool. */
  take(shape: Shape): void {
    if (this.readOnly || this.stroke) return;
    (document.querySelector(`input[name=shape][value=${shape}]`) as HTMLInputElement).checked =
      true;
    this.heldBrush = null;
    this.chooseShape();
    this.chooseWork();
  }
  /** Takes a brush. Null: puts the brush away, and the tool works again. */
  private holdBrush(mode: Mode | null): void {
    if (mode === this.heldBrush || this.stroke) return;
    this.heldBrush = mode;
    this.chooseWork();
  }

  /** The name of the held tool or brush in the memory of tools. */
  get item(): string {
    return this.heldBrush ? BRUSH + this.heldBrush : this.shape;
  }
  /** The numbers of the held tool or brush. */
  get values(): Values {
    const values = this.memory.current(this.heldBrush !== null);
    if (!this.heldBrush && !TOOLS[this.shape].form) delete values.form;
    return values;
  }
  /** Takes a tool or brush with these numbers. */
  use(item: string, values: Values): void {
    this.memory.replace(item, values);
    const brush = item.startsWith(BRUSH);
    if (this.readOnly || this.stroke) return;
    if (!brush) return this.take(item as Shape);
    this.heldBrush = item.slice(BRUSH.length) as Mode;
    this.chooseWork();
  }
  private remember(): void {
    this.memory.remember(this.item, this.heldBrush !== null);
  }
  /** Sets the controls to the numbers that the held tool or brush had last. */
  private recall(): void {
    const { form } = TOOLS[this.shape],
      brush = this.heldBrush && BRUSHES[this.heldBrush];
    this.memory.recall(
      this.item,
      this.heldBrush !== null,
      brush
        ? { "brush-strength": String(100 * brush.strength) }
        : form
          ? { form: String(form.value) }
          : {},
    );
  }

  lift(): void {
    if (!this.stroke) return;
    const { last, mode, negative } = this.stroke;
    this.stroke = null;
    this.guide.lift();
    if (!this.second.isActive()) {
      this.view.cameras.controls.enabled = true;
      this.view.solid.endStroke();
    }
    this.view.showWheel(this.mode === "turn", false);
    this.send(write.Lift());
    if (BRUSHES[mode]?.follows === "turns") this.chooseTurn();
    if (mode !== this.mode || negative) this.chooseWork(false);
    this.aim(last, -HOVER, performance.now());
    this.showRing();
  }

  private radius(): number {
    return Number(input("size").value);
  }
  private get shape(): Shape {
    return chosen("shape") as Shape;
  }
  private get mode(): Mode {
    return this.heldBrush ?? (chosen("mode") as Mode);
  }
  /** The current brush. Undefined if a tool is held. */
  private get brush(): (typeof BRUSHES)[Mode] {
    return BRUSHES[this.stroke?.mode ?? this.mode];
  }
  private depth(): number {
    return Number(input("depth").value);
  }
  private get adds(): boolean {
    return !this.device && (this.stroke?.mode ?? this.mode) === "deposit";
  }

  /** Changes to another shape. Restores the number that this shape had last. */
  private chooseShape(): void {
    const { form } = TOOLS[this.shape];
    if (form) {
      const slider = input("form");
      put("form-name", form.name);
      slider.min = String(form.min);
      slider.max = String(form.max);
      slider.value = String(form.value);
    }
    this.recall();
    this.showControls();
    const turn = this.turns.get(this.shape) ?? "0";
    if (input("turn-by").value !== turn) {
      input("turn-by").value = turn;
      if (!this.readOnly) this.chooseTurn();
    }
    this.chooseTool();
    if (!this.readOnly) this.chooseHand();
  }
  /** Shows the controls that the held tool or brush uses. */
  private showControls(): void {
    const { form, turns, powered, pressed } = TOOLS[this.shape],
      { heldBrush, mode } = this,
      brush = heldBrush !== null,
      textured = brush && BRUSHES[mode]?.follows === undefined && mode !== "crease";
    const shown: Record<string, boolean> = {
      depths: !brush,
      strengths: !brush,
      brush,
      keeps: BRUSHES[mode]?.keeps === true,
      alphas: textured,
      textures: textured && select("alpha").value === "picture",
      colours: mode === "paint",
      masks: mode === "mask",
      forms: !brush && form !== undefined,
      stamp: !brush && this.shape === "mesh",
      motor: !brush && powered && !pressed,
      mallet: !brush && !powered,
      turns: !brush && turns === true,
      "turn-reset": !brush && turns === true && input("turn-by").value !== "0",
      walls: mode === "turn",
      points: !brush,
      materials: mode === "deposit" || select("second-mode").value === "deposit",
      "depth-below": !brush || mode === "flatten",
      "set-plane": (!brush || mode === "flatten") && this.depthFrom === "set",
    };
    for (const [id, visible] of Object.entries(shown)) element(id).hidden = !visible;
    if (mode === "mask") this.masks.show();
    document.body.classList.toggle("brushing", brush);
    for (const label of element("choices").querySelectorAll("label")) {
      const button = label.querySelector("input")!,
        { name, value } = button;
      if (name === "brush") button.checked = value === heldBrush;
      label.classList.toggle("lit", value === (name === "brush" || brush ? heldBrush : this.shape));
    }
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
    // The corner radius cannot exceed the tool's radius.
    const value = tool.shape === "bull" ? tool.corner : (form?.value ?? 0);
    if (form) put("form-out", `${value.toFixed(form.unit === "mm" ? 1 : 0)} ${form.unit}`);
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
      // The stamp is as high and as wide as a ball would be. It is long enough for its depth, or
      // for the height of the added material.
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
  /** The chosen tool, regardless of the mode. */
  private bare(): HeldTool {
    const { form, make } = TOOLS[this.shape];
    if (form) form.value = Number(input("form").value);
    return make(this.radius(), form?.value ?? 0);
  }
  private own(): HeldTool {
    const tool = this.bare();
    return this.adds ? shortened(tool, this.depth() + Math.max(this.depth(), this.radius())) : tool;
  }
  /** Draws the tool: the chosen one if this page holds it, else the one that the studio reports. */
  private draw(): void {
    const own = this.brush ? null : this.own(); // a brush is shown as a ring on the wood
    this.view.tool.set(this.holds && !this.readOnly ? own : this.shown);
  }
  private chooseTurn(): void {
    const degrees = Number(input("turn-by").value);
    put("turn-out", `${degrees.toFixed(0)}°`);
    this.showControls();
    this.send(write.ChooseTurn({ turn: (degrees * Math.PI) / 180 }));
  }
  /** The symmetry planes as bits: 1 normal to x, 2 to y, 4 to z. */
  private planes(): number {
    return [...element("symmetry").querySelectorAll("input")].reduce(
      (all, box) => all + (box.checked ? Number(box.value) : 0),
      0,
    );
  }
  /** The rotational symmetry: the number of parts of a turn and the axis. */
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
  /** Sends the mode of the tool. A pointer's tool works only while the pointer is pressed. */
  private chooseWork(recalls = true): void {
    const { brush } = this;
    input("brush-strength").min = brush?.signed ? "-100" : "0";
    if (recalls) this.recall();
    this.showControls();
    this.view.showWheel(this.mode === "turn", false);
    put("brush-out", brush?.name ?? t("no_brush"));
    this.chooseTool();
    this.chooseBrush();
    if (!this.readOnly) this.chooseHand();
    this.showRing();
    if (this.device) this.send(write.ChooseWork({ mode: this.mode }));
  }
  /** Sends the brush. `radius` and `strength` override the chosen values. */
  private chooseBrush(radius = this.radius(), strength = this.brushStrength()): void {
    put("brush-strength-out", `${input("brush-strength").value} %`);
    const wall = Number(input("wall").value);
    put("wall-out", `${wall} mm`);
    const color = parseInt(input("color").value.slice(1), 16),
      set = this.depthFrom === "set" && this.plane;
    this.texture.choose();
    this.send(
      write.ChooseBrush({
        radius,
        strength,
        falloff: Number(select("falloff").value),
        keep: input("keep").checked && this.brush?.keeps ? 1 : 0,
        red: color >> 16,
        green: (color >> 8) & 255,
        blue: color & 255,
        plane: set ? 2 : 1,
        wall: this.mode === "turn" ? wall : 0,
        point: set ? (set.point.toArray() as Vec3) : [0, 0, 0],
        normal: set ? (set.normal.toArray() as Vec3) : [0, 0, 1],
        ...this.masks.fields(),
        // A preset may name a texture that does not exist.
        alpha: Math.max(0, ALPHAS.indexOf(select("alpha").value as Alpha)),
        pressure: pressureUse(),
      }),
    );
  }
  private brushStrength(): number {
    return Number(input("brush-strength").value) / 100;
  }
  /** The mode of a press with the keys that are down, and if its strength is negative. */
  private wanted(): { mode: Mode; negative: boolean } {
    const { mode } = this,
      { shift, inverts } = this.keysDown;
    if (shift) return { mode: "smooth", negative: false };
    const inverse = inverts ? inverseOf(mode) : mode;
    return { mode: inverse, negative: inverts && BRUSHES[mode]?.signed === true };
  }
  /** Draws the ring under the pointer: its colour shows what a press does. */
  private showRing(): void {
    const { marks } = this.view,
      { mode, negative } = this.stroke ?? this.wanted(),
      smooths = mode === "smooth" && this.mode !== "smooth";
    marks.styleRing(
      smooths ? "smooths" : negative || mode !== this.mode ? "inverts" : "usual",
      BRUSHES[mode] ? Number(select("falloff").value) : null,
    );
    marks.showRing(
      this.stroke?.last ?? this.over,
      (smooths ? SHIFT_WIDTH * this.radius() : this.radius()) *
        (this.stroke && !BRUSHES[mode]?.follows ? sizeShare(this.stroke.pressure) : 1),
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

  /**
   * Where the tip is during a stroke that scales: on the tool's axis, above or below the press. If
   * the axis points to the eye, the pointer's motion to the right and up counts.
   */
  private scaledTo(x: number, y: number): Hit {
    const { last, from } = this.stroke!,
      { cameras } = this.view;
    const shown = cameras.onScreen(last.point.toArray() as Vec3),
      tip = cameras.onScreen(last.point.clone().add(this.axis).toArray() as Vec3),
      pixel = cameras.perPixel(last.point);
    const size = Math.hypot(tip.x - shown.x, tip.y - shown.y);
    // If the axis looks shorter than half its length, a hand cannot follow its direction.
    const out =
      size * pixel < 0.5
        ? { x: Math.SQRT1_2, y: -Math.SQRT1_2 }
        : { x: (tip.x - shown.x) / size, y: (tip.y - shown.y) / size };
    const way = (x - from.x) * out.x + (y - from.y) * out.y;
    return { ...last, point: last.point.clone().addScaledVector(this.axis, way * pixel) };
  }

  /** The tool's axis at this position. It points away from the wood. */
  private axisAt(hit: Hit, event: PointerEvent): THREE.Vector3 {
    const how = select("axis").value;
    const axis =
      how === "view"
        ? this.view.cameras.towardsEye(hit.point)
        : how === "pen"
          ? this.view.cameras.alongPen(event.tiltX, event.tiltY)
          : hit.normal;
    // A flatter axis would push the tool's side through the wood.
    return axis.dot(hit.normal) > 0.15 ? axis.clone() : hit.normal.clone();
  }

  /**
   * The tip, the tool's lowest point, at depth `deep` below a position. A negative depth is above
   * it.
   */
  private tipAt(hit: Hit, deep: number): Vec3 {
    return hit.point.clone().addScaledVector(this.axis, -deep).toArray() as Vec3;
  }

  /** Aims at a position. `time` is the event's time [ms]. */
  private aim(hit: Hit, deep: number, time: number): void {
    if (this.device || this.readOnly) return;
    this.there = true;
    this.aimed = this.tipAt(hit, deep);
    this.send(
      write.Aim({
        tip: this.aimed,
        axis: this.axis.toArray() as Vec3,
        time: time / 1000,
        pressure: this.stroke?.pressure ?? 1,
      }),
    );
  }

  /** The depth of a press [mm]. It is negative for a tool that adds material. */
  private pressed(event: PointerEvent): number {
    if (this.brush) return 0;
    if (this.stroke?.mode === "deposit") return heightOf(this.own()) - this.depth();
    const pen = event.pointerType === "pen" && event.pressure > 0 && input("pressure").checked;
    return pen ? 2 * event.pressure * this.depth() : this.depth();
  }

  /**
   * Where the line of sight through a point of the window meets a plane. Null if the line is almost
   * parallel to the plane.
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
   * Where a press at this point of the window begins a stroke: on the wood, near it within the
   * tool's radius, or anywhere if the key for that is down. Null if it begins none.
   */
  private beginning(x: number, y: number): Hit | null {
    const on = this.view.hit(x, y, true);
    if (on) return on;
    const nearby = this.nearby(x, y);
    if (nearby) return this.onPlane(x, y, nearby) ?? nearby;
    if (!this.anywhere) return null;
    const point = this.over?.point ?? this.view.cameras.target;
    return this.onPlane(x, y, { point, normal: this.view.cameras.towardsEye(point) });
  }
  /** The nearest wood around a point of the window, at most one tool radius away. */
  private nearby(x: number, y: number): Hit | null {
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
      // A hand that holds a pen may rest on the screen. Ignore its touch.
      if (this.stroke.type !== "touch") return event.stopImmediatePropagation();
      return this.handToView();
    }
    if (this.sliding) {
      this.sliding = null;
      return event.stopImmediatePropagation();
    }
    // Another finger controls the view.
    const first = event.pointerType !== "touch" || event.isPrimary || this.second.working;
    const begins = first && event.button === 0 && this.holds && !this.stroke && !this.readOnly;
    if (begins && this.takesUp(event.clientX, event.clientY)) {
      event.stopImmediatePropagation();
      return;
    }
    const hit = begins ? this.beginning(event.clientX, event.clientY) : null;
    if (!hit) return; // a press outside the wood turns the view
    if (this.device) {
      // Bring the tool to a position clear of the wood. The event also reaches the view, which may
      // turn.
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
    this.keysDown = { shift: event.shiftKey, inverts: event.ctrlKey || event.altKey };
    const { mode, negative } = this.wanted();
    const follows = BRUSHES[mode]?.follows;
    // A dragging brush moves in the plane across the view.
    const across = { point: hit.point.clone(), normal: this.view.cameras.towardsEye(hit.point) };
    let plane = this.depthFrom === "held" ? hit : this.depthFrom === "set" ? this.plane : null;
    if (BRUSHES[mode]) plane = follows ? across : null;
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
      negative,
      from: {
        x: event.clientX,
        y: event.clientY,
        turn: (Number(input("turn-by").value) * Math.PI) / 180,
      },
      time: event.timeStamp,
      pressure: pressureOf(event),
    };
    if (mode === "turn") this.view.showWheel(true, true);
    if (mode !== this.mode) {
      this.chooseTool();
      // With Shift, the brush has full strength, so that one or two strokes smooth an edge.
      if (event.shiftKey) this.chooseBrush(SHIFT_WIDTH * this.radius(), 1);
      else if (this.brush) this.chooseBrush();
    } else if (negative) this.chooseBrush(this.radius(), -this.brushStrength());
    // If a guided stroke begins in a groove, the groove must not tilt the plane of its line or
    // circle.
    this.axis = this.axisAt(
      follows ? hit : this.guide.plane ? this.view.around(at, 2 * this.radius() + 1) : at,
      event,
    );
    this.aimed = this.tipAt(at, this.pressed(event));
    this.there = true;
    this.guide.press(at);
    this.send(
      write.Press({
        tip: this.aimed,
        axis: this.axis.toArray() as Vec3,
        mode,
        time: event.timeStamp / 1000,
        pressure: this.stroke.pressure,
      }),
    );
    if (input("blows").checked)
      setTimeout(() => this.stroke?.time === event.timeStamp && this.strike(), BLOW_AFTER_MS);
  }

  /**
   * Two fingers control the view. Cancels the first finger's stroke and passes its press to the
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
      const { id, from, x } = this.sliding,
        way = event.clientX - x;
      return this.setAmount(id, id === "brush-strength" ? from + way / 3 : from * 1.01 ** way);
    }
    if (this.second.follow(event)) return;
    if (this.stroke) return this.follow(event);
    if (event.buttons !== 0) return;
    this.over = this.view.hit(event.clientX, event.clientY);
    this.showRing();
    if (!this.over || !this.holds) return;
    this.axis = this.axisAt(this.over, event);
    this.aim(this.over, -HOVER, event.timeStamp);
  }

  /** Extends the stroke by every event that the browser has coalesced, each at its own time. */
  private follow(event: PointerEvent): void {
    const stroke = this.stroke!;
    if (event.pointerId !== stroke.pointer) return;
    Object.assign(stroke, { x: event.clientX, y: event.clientY });
    for (const one of newEvents(event, stroke)) this.followTo(one);
    this.showRing();
  }
  private followTo(event: PointerEvent): void {
    const stroke = this.stroke!,
      { clientX: x, clientY: y } = event;
    stroke.pressure = pressureOf(event);
    const follows = this.brush?.follows;
    if (follows === "turns") {
      const turn = stroke.from.turn + TURN_PER_PIXEL * (x - stroke.from.x);
      this.send(write.ChooseTurn({ turn }));
      return this.aim(stroke.last, 0, event.timeStamp);
    }
    if (follows === "scales") return this.aim(this.scaledTo(x, y), 0, event.timeStamp);
    let at: Hit | null;
    if (stroke.plane) {
      at = this.onPlane(x, y, stroke.plane);
    } else {
      at = this.view.hit(x, y, this.depthFrom === "began" && !this.brush);
      if (at) stroke.wood = at;
      // Outside the wood the path continues along the plane through its last point on the wood, so
      // that the tool comes out.
      else at = this.onPlane(x, y, stroke.wood);
      if (
        at &&
        at !== stroke.wood &&
        at.point.distanceTo(stroke.wood.point) > BEYOND * this.radius()
      )
        at = null;
    }
    if (at) {
      const distance = at.point.distanceTo(stroke.last.point);
      stroke.last = at;
      this.guide.follow(at);
      if (follows) return this.aim(at, 0, event.timeStamp);
      const wanted = this.axisAt(at, event);
      this.axis =
        select("axis").value === "normal"
          ? turnTowards(this.axis, wanted, distance, this.radius())
          : wanted;
    }
    this.aim(stroke.last, this.pressed(event), event.timeStamp);
  }
}
