// SPDX-License-Identifier: MIT
// Hides parts of the piece from view: a drag draws a box or a lasso, and what is behind it is
// hidden. With Alt, what is outside is hidden.
import { t } from "../base/texts";
import { element } from "../base/dom";
import { notify } from "../base/notice";
import type { ScreenPoint } from "../view/hidden_parts";
import type { View } from "../view/view";
import { fewer } from "./bodies";

const GESTURES = ["box", "lasso"] as const;
export type HidingGesture = (typeof GESTURES)[number];

/** Tolerance for simplifying a lasso [pixels]. */
const LINE_PX = 0.7;
/** A smaller box or lasso is a click [pixels]. */
const MIN_PX = 4;

export class Hiding {
  private gesture: HidingGesture | null = null;
  private drag: { pointer: number; line: ScreenPoint[] } | null = null;
  private drawn = element("drawn-line").querySelector("polyline")!;

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
  ) {
    for (const gesture of GESTURES) element(`hide-${gesture}`).onclick = () => this.take(gesture);
    element("hide-none").onclick = () => this.showAll();
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event), { capture: true });
    canvas.addEventListener("pointerup", (event) => this.up(event), { capture: true });
    for (const end of ["pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(
        end,
        (event) => event.pointerId === this.drag?.pointer && this.leaveOff(),
      );
  }

  /** Starts with another document, which shows everything. */
  begin(): void {
    this.set(null);
    this.show();
  }
  /** The next drag draws a box or a lasso. The same gesture again: the tool works. */
  take(gesture: HidingGesture): void {
    this.set(gesture === this.gesture ? null : gesture);
    if (this.gesture) notify(t(gesture === "box" ? "help_hide_box" : "help_hide_lasso"));
  }
  /** Leaves the gesture on Escape. Returns whether there was one. */
  leaveOff(): boolean {
    if (!this.gesture) return false;
    this.set(null);
    return true;
  }
  showAll(): void {
    this.view.showAll();
    this.show();
  }

  private set(gesture: HidingGesture | null): void {
    if (this.gesture) notify("");
    if (this.drag) this.view.cameras.controls.enabled = true;
    this.gesture = gesture;
    this.drag = null;
    this.drawn.setAttribute("points", "");
    for (const one of GESTURES)
      element(`hide-${one}`).setAttribute("aria-pressed", String(one === gesture));
  }
  private show(): void {
    element<HTMLButtonElement>("hide-none").disabled = !this.view.solid.hidden.any;
  }

  private down(event: PointerEvent): void {
    if (!this.gesture || event.button !== 0) return;
    event.stopImmediatePropagation();
    if (this.drag) return;
    this.drag = { pointer: event.pointerId, line: [{ x: event.clientX, y: event.clientY }] };
    this.view.cameras.controls.enabled = false;
    this.canvas.setPointerCapture(event.pointerId);
  }
  private move(event: PointerEvent): void {
    if (!this.gesture) return;
    event.stopImmediatePropagation();
    if (event.pointerId !== this.drag?.pointer) return;
    const { line } = this.drag,
      from = line[0],
      now = { x: event.clientX, y: event.clientY };
    if (this.gesture === "lasso") line.push(now);
    else this.drag.line = [from, { x: now.x, y: from.y }, now, { x: from.x, y: now.y }];
    this.drawn.setAttribute(
      "points",
      [...this.drag.line, from].map(({ x, y }) => `${x},${y}`).join(" "),
    );
  }
  private up(event: PointerEvent): void {
    if (event.pointerId !== this.drag?.pointer) return;
    event.stopImmediatePropagation();
    const { line } = this.drag,
      outline = this.gesture === "lasso" ? fewer([...line, line[0]], LINE_PX).slice(0, -1) : line;
    this.set(null);
    const wide = (axis: "x" | "y"): number =>
      Math.max(...outline.map((p) => p[axis])) - Math.min(...outline.map((p) => p[axis]));
    if (outline.length < 3 || wide("x") < MIN_PX || wide("y") < MIN_PX) return;
    this.view.hide(outline, event.altKey);
    this.show();
  }
}
