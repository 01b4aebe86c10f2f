// SPDX-License-Identifier: MIT
// Stores the choices of controls in this browser: by id, and groups of radio buttons by name.
const STORE = "kibori.settings";

type Control = HTMLInputElement | HTMLSelectElement;

export class Settings {
  private kept: Record<string, string> = {};

  constructor(private names: string[]) {
    try {
      const kept = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Record<string, unknown>;
      for (const name of names) if (typeof kept[name] === "string") this.kept[name] = kept[name];
    } catch {
      // A stored value that cannot be read is ignored.
    }
    document.addEventListener("change", (event) => {
      const { id, name } = event.target as Control;
      if (names.includes(id) || names.includes(name)) this.keep();
    });
    // Keyboard actions change controls without an event.
    window.addEventListener("pagehide", () => this.keep());
  }
  private restored = false;

  /** Restores the controls, as if the user had set them. Works once. */
  restore(): void {
    if (this.restored) return;
    this.restored = true;
    // Each restored control fires a change event, which would store all controls. The others are
    // not restored yet.
    const kept = { ...this.kept };
    for (const name of this.names) {
      const value = kept[name];
      const control =
        value === undefined
          ? undefined
          : this.controls(name).find((one) => one.type !== "radio" || one.value === value);
      if (!control) continue;
      if (control.type === "radio") (control as HTMLInputElement).checked = true;
      else if (control.type === "checkbox") (control as HTMLInputElement).checked = value === "1";
      else control.value = value;
      // The choice no longer exists.
      if (control instanceof HTMLSelectElement && control.selectedIndex < 0)
        control.selectedIndex = 0;
      for (const kind of ["input", "change"])
        control.dispatchEvent(new Event(kind, { bubbles: true }));
    }
  }

  private controls(name: string): Control[] {
    return [
      ...document.querySelectorAll<Control>(`#${name}, input[type=radio][name=${name}]`),
    ].filter((one) => "value" in one);
  }

  private keep(): void {
    if (!this.restored) return;
    for (const name of this.names) {
      const all = this.controls(name),
        one = all.find(
          (control) => control.type !== "radio" || (control as HTMLInputElement).checked,
        );
      if (one)
        this.kept[name] =
          one.type === "checkbox" ? ((one as HTMLInputElement).checked ? "1" : "0") : one.value;
    }
    try {
      localStorage.setItem(STORE, JSON.stringify(this.kept));
    } catch {
      // If the browser refuses to store it, it is valid until the page is closed.
    }
  }
}
