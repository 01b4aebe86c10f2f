// SPDX-License-Identifier: MIT
// The second hand: another finger, or the pointer where a force device holds the first tool. It
// works beside the first, with a tool of its own; what both do until both are lifted is one stroke.
import * as THREE from "three";
import { element, input, put, select } from "../base/dom";
import type { Mode } from "../connection/kinds";
import { write } from "../connection/messages";
import type { SecondHand as Told } from "../connection/messages";
import { TOOLS, held, heightOf, shortened, sizeOf, type HeldTool } from "../tools/tools";
import type { Hit } from "../view/pick";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";
import { newEvents, turnTowards } from "./pointer_path";

/** What it needs of the first hand. */
export interface FirstHand {
  /** The tool that is chosen now. */
  own(): HeldTool;
  depth(): number;
  radius(): number;
  working(): boolean;
  /** How a tool leads itself that goes so deep [mm]. */
  leading(leads: boolean, depth: number): { lead: number; entry: number; lift: number };
  /** Where a stroke begins that is pressed there: on the wood, or beside it. */
  beginning(x: number, y: number): Hit | null;
  /** Where a point of the window meets the plane through a place. */
  onPlane(x: number, y: number, plane: Hit): Hit | null;
}

export class SecondHand {
  private tool: HeldTool | null = null; // that was given to it
  private used: HeldTool | null = null; // the same, as it works at this depth
  private depth = 0;
  private stroke: {
    pointer: number;
    last: Hit;
    wood: Hit;
    axis: THREE.Vector3;
    time: number;
    /** Whether it began to look at the wood as it was; else the first hand did. */
    looks: boolean;
  } | null = null;

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
    private send: (message: Uint8Array) => void,
    private first: FirstHand,
  ) {
    select("second-mode").addEventListener("change", () => this.choose());
    input("leads").addEventListener("input", () => this.choose());
    element("second-takes").onclick = () => {
      this.tool = this.taken();
      this.choose();
    };
  }

  get mode(): Mode {
    return select("second-mode").value as Mode;
  }
  /** Whether there is one. */
  get there(): boolean {
    return this.mode !== "off";
  }
  get working(): boolean {
    return this.stroke !== null;
  }

  /** The first hand's tool; a press is not held in the second, and a ball is taken for a stamp. */
  private taken(): HeldTool {
    const tool = this.first.own();
    return tool.shape === "mesh" ? TOOLS.ball.make(this.first.radius(), 0) : tool;
  }

  /** What is chosen, to the studio. */
  choose(): void {
    this.lift();
    const { there } = this,
      tool = this.tool ?? this.taken();
    if (there) this.tool = tool;
    element("second-tool").hidden = !there;
    put("second-name", `${TOOLS[tool.shape].name}, ${sizeOf(tool)}`);
    const depth = (this.depth = this.first.depth()),
      adds = this.mode === "deposit";
    this.used = adds ? shortened(tool, depth + Math.max(depth, this.first.radius())) : tool;
    const leads = (TOOLS[tool.shape].leads ?? false) && !adds;
    this.send(
      write.ChooseSecond({
        tool: this.used,
        mode: this.mode,
        ...this.first.leading(leads, depth),
      }),
    );
  }
  /** Perhaps another depth. It is told before a stroke: during one, what is told ends it. */
  deepen(): void {
    if (this.there && !this.stroke && this.depth !== this.first.depth()) this.choose();
  }
  /** Another document: nothing is under way, and there is none. */
  begin(): void {
    this.stroke = null;
    this.tool = null;
    select("second-mode").value = "off";
    element("second-tool").hidden = true;
    this.show(null);
  }
  /** As the studio says; null: there is none. */
  show(told: Told | null): void {
    const there = told !== null && told.there !== 0;
    for (const id of ["second-force", "second-newtons"]) element(id).hidden = !there;
    if (told && there) this.view.secondTool.set(held(told.tool));
    this.view.secondTool.place(
      there ? told.tip : null,
      told?.axis ?? [0, 0, 1],
      told?.side ?? [1, 0, 0],
      told?.force ?? [0, 0, 0],
    );
    if (told && there) put("second-newtons", `${Math.hypot(...told.force).toFixed(1)} N`);
  }

  /** Whether a press there is this hand's. */
  down(event: PointerEvent): boolean {
    if (!this.there || this.stroke) return false;
    const hit = this.first.beginning(event.clientX, event.clientY);
    if (!hit) return false;
    this.canvas.setPointerCapture(event.pointerId);
    const looks = this.view.cameras.controls.enabled;
    this.view.cameras.controls.enabled = false;
    if (looks) this.view.solid.beginStroke();
    const axis = hit.normal.clone();
    this.stroke = {
      pointer: event.pointerId,
      last: hit,
      wood: hit,
      axis,
      time: event.timeStamp,
      looks,
    };
    this.send(
      write.PressSecond({
        tip: this.tipAt(hit, axis),
        axis: axis.toArray() as Vec3,
        time: event.timeStamp / 1000,
      }),
    );
    return true;
  }

  /** Whether this pointer is the hand's. */
  follow(event: PointerEvent): boolean {
    const { stroke } = this;
    if (!stroke || event.pointerId !== stroke.pointer) return false;
    for (const one of newEvents(event, stroke)) {
      const at = this.view.hit(one.clientX, one.clientY, true);
      if (at) stroke.wood = at;
      // Beside the wood the path goes on along the plane it left.
      const next = at ?? this.first.onPlane(one.clientX, one.clientY, stroke.wood);
      if (next) {
        const way = next.point.distanceTo(stroke.last.point);
        turnTowards(stroke.axis, next.normal, way, this.first.radius());
        stroke.last = next;
      }
      this.send(
        write.AimSecond({
          tip: this.tipAt(stroke.last, stroke.axis),
          axis: stroke.axis.toArray() as Vec3,
          time: one.timeStamp / 1000,
        }),
      );
    }
    return true;
  }

  /** The first hand lets go: whether this one goes on. */
  goesOn(): boolean {
    if (!this.stroke) return false;
    return (this.stroke.looks = true);
  }

  lift(pointer?: number): void {
    const { stroke } = this;
    if (!stroke || (pointer !== undefined && stroke.pointer !== pointer)) return;
    this.stroke = null;
    if (stroke.looks && !this.first.working()) {
      this.view.cameras.controls.enabled = true;
      this.view.solid.endStroke();
    }
    this.send(write.LiftSecond());
  }

  private tipAt(hit: Hit, axis: THREE.Vector3): Vec3 {
    const { depth } = this;
    const deep = this.mode === "deposit" ? heightOf(this.used!) - depth : this.first.depth();
    return hit.point.clone().addScaledVector(axis, -deep).toArray() as Vec3;
  }
}
