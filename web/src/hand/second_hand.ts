// SPDX-License-Identifier: MIT
// The second hand: another finger, or the pointer where a force device holds the first tool. It
// works in parallel with the first and has its own tool. One stroke holds the work of both, until
// both are lifted.
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

/** The part of the first hand that the second hand needs. */
export interface FirstHand {
  /** The chosen tool. */
  own(): HeldTool;
  depth(): number;
  radius(): number;
  working(): boolean;
  /** How a leading tool enters and leaves, for a depth [mm]. */
  leading(leads: boolean, depth: number): { lead: number; entry: number; lift: number };
  /** Start of a stroke that is pressed at (x, y): on the wood or next to it. */
  beginning(x: number, y: number): Hit | null;
  /** Point of the plane through a place that is seen at (x, y) in the window. */
  onPlane(x: number, y: number, plane: Hit): Hit | null;
}

export class SecondHand {
  private tool: HeldTool | null = null; // the tool that the user gave to this hand
  private used: HeldTool | null = null; // the same tool, shortened for this depth if it adds
  private depth = 0;
  private stroke: {
    pointer: number;
    last: Hit;
    wood: Hit;
    axis: THREE.Vector3;
    time: number;
    /** True if this hand began the stroke; else the first hand did. */
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
  /** True if there is a second hand. */
  get there(): boolean {
    return this.mode !== "off";
  }
  get working(): boolean {
    return this.stroke !== null;
  }

  /** The first hand's tool. The second hand cannot hold a stamp and gets a ball instead. */
  private taken(): HeldTool {
    const tool = this.first.own();
    return tool.shape === "mesh" ? TOOLS.ball.make(this.first.radius(), 0) : tool;
  }

  /** Sends the choices to the studio. */
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
  /** Sends a changed depth, but not during a stroke, because the message would end it. */
  deepen(): void {
    if (this.there && !this.stroke && this.depth !== this.first.depth()) this.choose();
  }
  /** Resets for another document. It has no second hand. */
  begin(): void {
    this.stroke = null;
    this.tool = null;
    select("second-mode").value = "off";
    element("second-tool").hidden = true;
    this.show(null);
  }
  /** Shows the second hand that the studio reported; null: there is none. */
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

  /** Begins a stroke of this hand. Returns false if the press does not belong to it. */
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

  /** Continues the stroke. Returns false if the pointer does not belong to this hand. */
  follow(event: PointerEvent): boolean {
    const { stroke } = this;
    if (!stroke || event.pointerId !== stroke.pointer) return false;
    for (const one of newEvents(event, stroke)) {
      const at = this.view.hit(one.clientX, one.clientY, true);
      if (at) stroke.wood = at;
      // Off the wood, the path continues in the plane that it left.
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

  /** The first hand has lifted. Returns true if this hand continues the stroke. */
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
