// SPDX-License-Identifier: MIT
// Shows a number next to the pointer while it changes.
import { element } from "../base/dom";

const SHOWN_MS = 1200;
const ASIDE_PX = 18;

export class AtCursor {
  private timer = 0;

  /** Shows a text next to a point of the window for a moment. */
  show(text: string, { x, y }: { x: number; y: number }): void {
    const box = element("at-cursor");
    box.textContent = text;
    box.hidden = false;
    const { width, height } = box.getBoundingClientRect();
    box.style.left = `${Math.max(0, Math.min(x + ASIDE_PX, innerWidth - width))}px`;
    box.style.top = `${Math.max(0, Math.min(y + ASIDE_PX, innerHeight - height))}px`;
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => (box.hidden = true), SHOWN_MS);
  }
}
