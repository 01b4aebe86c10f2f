// SPDX-License-Identifier: MIT
// Keeps size, depth, strength and the other numbers of each tool and each brush in this browser.
import { input } from "../base/dom";

const STORE = "kibori.tools";
/** The controls that are kept, by their ids. Check boxes are kept as "1" or "0". */
const OF_TOOLS = ["size", "depth", "strength", "form", "powered"] as const;
const OF_BRUSHES = ["size", "brush-strength", "falloff", "alpha", "keep"] as const;
/** The values of a tool or brush that was never used. */
const USUAL: Record<string, string> = {
  size: "4",
  depth: "2",
  strength: "200",
  powered: "1",
  falloff: "0",
  alpha: "none",
  keep: "0",
};

export type Values = Record<string, string>;
export const controlsOf = (brush: boolean): readonly string[] => (brush ? OF_BRUSHES : OF_TOOLS);

export class ToolMemory {
  private kept: Record<string, Values> = {};

  constructor() {
    try {
      const kept = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Record<string, unknown>;
      for (const [name, values] of Object.entries(kept))
        if (values !== null && typeof values === "object")
          this.kept[name] = Object.fromEntries(
            Object.entries(values).filter(([, value]) => typeof value === "string"),
          );
    } catch {
      // Ignore stored values that cannot be read.
    }
    window.addEventListener("pagehide", () => this.store());
    document.addEventListener("change", () => this.store());
  }

  /** Reads the controls of the tool or brush `name` and keeps their values. */
  remember(name: string, brush: boolean): void {
    this.kept[name] = this.current(brush);
  }
  current(brush: boolean): Values {
    return Object.fromEntries(
      controlsOf(brush).map((id) => {
        const control = input(id);
        return [id, control.type === "checkbox" ? (control.checked ? "1" : "0") : control.value];
      }),
    );
  }
  /** Sets the controls to the values of the tool or brush. `own`: its values before first use. */
  recall(name: string, brush: boolean, own: Values): void {
    const values = { ...USUAL, ...own, ...this.kept[name] };
    for (const id of controlsOf(brush)) {
      const control = input(id),
        value = values[id];
      if (value === undefined) continue;
      if (control.type === "checkbox") control.checked = value === "1";
      else if (control.value !== value) control.value = value;
    }
  }
  /** Replaces the kept values of a tool or brush. */
  replace(name: string, values: Values): void {
    this.kept[name] = { ...this.kept[name], ...values };
    this.store();
  }

  private store(): void {
    try {
      localStorage.setItem(STORE, JSON.stringify(this.kept));
    } catch {
      // Without storage the values hold until the page is reloaded.
    }
  }
}
