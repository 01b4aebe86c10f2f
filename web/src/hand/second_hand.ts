// SPDX-License-Identifier: MIT
// The second hand: another finger, or the pointer while a force device holds the first tool. It
// works at the same time as the first hand and has its own tool. A stroke contains what both hands
// do, until both are lifted.
import * as THREE from "three";
import { element, input, put, select } from "../base/dom";
import type { Mode } from "../connection/kinds";
import { write } from "../connection/messages";
import type { SecondHand as SecondHandMessage } from "../connection/messages";
import { TOOLS, held, heightOf, shortened, sizeOf, type HeldTool } from "../tools/tools";
import type { Hit } from "../view/pick";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";
import { newEvents, turnTowards } from "./pointer_path";

/** What the second hand needs from the first hand. */
export interface FirstHand {
  /** The tool that is chosen now. */
  own(): HeldTool;
  depth(): number;
  radius(): number;
  working(): boolean;
  /** How a self-leading tool enters at this depth [mm]. */
  leading(leads: boolean, depth: number): { lead: number; entry: number; lift: number };
  /** Where a press at this point begins a stroke: on the wood or near it. */
  beginning(x: number, y: number): Hit | null;
  /** Where the line of sight through a point of the window meets a plane. */
  onPlane(x: number, y: number, plane: Hit): Hit | null;
}

export class SecondHand {
  private tool: HeldTool | null = null; // the tool that was given to this hand
  private used: HeldTool | null = null; // the same tool, adapted to the current depth
  private depth = 0;
  private stroke: {
    pointer: number;
    last: Hit;
    wood: Hit;
    axis: THREE.Vector3;
    time: number;
    /**
     * True if this hand stored the surface from before the stroke. Otherwise the first hand did.
     */
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
  /** True if the second hand is in use. */
  get there(): boolean {
    return this.mode !== "off";
  }
  get working(): boolean {
    return this.stroke !== null;
  }

  /** The first hand's tool. This hand cannot press a stamp, so it gets a ball instead. */
  private taken(): HeldTool {
    const tool = this.first.own();
    return tool.shape === "mesh" ? TOOLS.ball.make(this.first.radius(), 0) : tool;
  }

  /** Sends this hand's choices to the studio. */
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
  /** Sends a changed depth. Call it before a stroke, because the message ends a stroke. */
  deepen(): void {
    if (this.there && !this.stroke && this.depth !== this.first.depth()) this.choose();
  }
  /** Starts with another document. There is no second hand and no stroke. */
  begin(): void {
    this.stroke = null;
    this.tool = null;
    select("second-mode").value = "off";
    element("second-tool").hidden = true;
    this.show(null);
  }
  /** Shows the second hand's state from the studio. Null: there is none. */
  show(message: SecondHandMessage | null): void {
    const there = message !== null && message.there !== 0;
    for (const id of ["second-force", "second-newtons"]) element(id).hidden = !there;
    if (message && there) this.view.secondTool.set(held(message.tool));
    this.view.secondTool.place(
      there ? message.tip : null,
      message?.axis ?? [0, 0, 1],
      message?.side ?? [1, 0, 0],
      message?.force ?? [0, 0, 0],
    );
    if (message && there) put("second-newtons", `${Math.hypot(...message.force).toFixed(1)} N`);
  }

  /** Handles a press. Returns whether it belongs to this hand. */
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

  /** Handles a motion. Returns whether this pointer belongs to this hand. */
  follow(event: PointerEvent): boolean {
    const { stroke } = this;
    if (!stroke || event.pointerId !== stroke.pointer) return false;
    for (const one of newEvents(event, stroke)) {
      const at = this.view.hit(one.clientX, one.clientY, true);
      if (at) stroke.wood = at;
      // Outside the wood the path continues along the plane through its last point on the wood.
      const next = at ?? this.first.onPlane(one.clientX, one.clientY, stroke.wood);
      if (next) {
        const distance = next.point.distanceTo(stroke.last.point);
        turnTowards(stroke.axis, next.normal, distance, this.first.radius());
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

  /** Call it when the first hand is lifted. Returns whether this hand continues the stroke. */
  isActive(): boolean {
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
