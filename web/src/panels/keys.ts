// SPDX-License-Identifier: MIT
// The user's key bindings and the list that changes them. The browser keeps them.
import { t } from "../base/texts";

export interface Action {
  label: string;
  keys: string[];
  run: () => void;
}

const STORE = "kibori.keys";

/** The key of an event as bindings write it: Ctrl+Shift+z, [, Home. */
function nameOf(event: KeyboardEvent): string {
  const control = event.ctrlKey || event.metaKey;
  const letter = event.key.length === 1 && event.key.toLowerCase() !== event.key.toUpperCase();
  const key = letter ? event.key.toLowerCase() : event.key;
  const shift = event.shiftKey && (control || letter);
  return `${control ? "Ctrl+" : ""}${event.altKey ? "Alt+" : ""}${shift ? "Shift+" : ""}${key === " " ? "Space" : key}`;
}

/** Converts keys that an older version stored with capital letters. */
function asNamed(key: string): string {
  return key.length === 1 && key !== key.toLowerCase() ? `Shift+${key.toLowerCase()}` : key;
}

export class Keys {
  private bound = new Map<string, string>(); // from key to action
  private waiting: string | null = null; // an action that waits for a key

  constructor(
    private actions: Record<string, Action>,
    private table: HTMLElement,
    private blocked: () => boolean,
  ) {
    this.load();
    window.addEventListener("keydown", (event) => this.press(event));
    this.draw();
  }

  /** Stops waiting for a key. */
  stopWaiting(): void {
    this.waiting = null;
    this.draw();
  }

  reset(): void {
    localStorage.removeItem(STORE);
    this.load();
    this.draw();
  }

  private load(): void {
    this.bound.clear();
    for (const [name, action] of Object.entries(this.actions))
      for (const key of action.keys) this.bound.set(key, name);
    try {
      const kept = JSON.parse(localStorage.getItem(STORE) ?? "null") as Record<
        string,
        string
      > | null;
      for (const [key, name] of Object.entries(kept ?? {}))
        if (name in this.actions) this.assign(asNamed(key), name);
    } catch {
      // Ignore stored bindings that cannot be read.
    }
  }

  private assign(key: string, action: string): void {
    for (const [other, name] of this.bound) if (name === action) this.bound.delete(other);
    this.bound.set(key, action);
  }

  /** Binds a key. Only changes are stored, so that new actions get their default keys. */
  private bind(key: string, action: string): void {
    this.assign(key, action);
    try {
      const kept = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Record<string, string>;
      for (const [other, name] of Object.entries(kept)) if (name === action) delete kept[other];
      localStorage.setItem(STORE, JSON.stringify({ ...kept, [key]: action }));
    } catch {
      // Without storage the binding holds until the page is reloaded.
    }
  }

  private press(event: KeyboardEvent): void {
    if (["Shift", "Control", "Alt", "Meta"].includes(event.key)) return;
    const key = nameOf(event);
    if (this.waiting) {
      event.preventDefault();
      const action = this.waiting;
      if (key !== "Escape") this.bind(key, action);
      return this.stopWaiting();
    }
    const field = event.target instanceof HTMLInputElement ? event.target.type : "";
    const typing =
      ["text", "number"].includes(field) ||
      (field === "range" && /^(Home|End|Page|Arrow)/.test(event.key));
    if (typing || event.target instanceof HTMLSelectElement || this.blocked()) return;
    const action = this.actions[this.bound.get(key) ?? ""];
    if (!action) return;
    event.preventDefault();
    action.run();
  }

  private draw(): void {
    this.table.replaceChildren(
      ...Object.entries(this.actions).map(([name, action]) => {
        const row = document.createElement("tr"),
          keys = document.createElement("td"),
          what = document.createElement("td");
        const button = document.createElement("button");
        button.type = "button";
        button.textContent =
          [...this.bound]
            .filter(([, to]) => to === name)
            .map(([key]) => key)
            .join(` ${t("or")} `) || t("no_key");
        if (this.waiting === name) button.textContent = t("press_a_key");
        button.onclick = () => {
          this.waiting = name;
          this.draw();
        };
        keys.append(button);
        what.textContent = action.label;
        row.append(keys, what);
        return row;
      }),
    );
  }
}
