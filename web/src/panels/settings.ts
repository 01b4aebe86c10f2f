// SPDX-License-Identifier: MIT
// Keeps the values of controls in this browser, by their ids. Groups of radio buttons are kept by
// name.
const STORE = "kibori.settings";

type Control = HTMLInputElement | HTMLSelectElement;

export class Settings {
  private kept: Record<string, string> = {};

  constructor(private names: string[]) {
    try {
      const kept = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Record<string, unknown>;
      for (const name of names) if (typeof kept[name] === "string") this.kept[name] = kept[name];
    } catch {
      // Ignore stored values that cannot be read.
    }
    document.addEventListener("change", (event) => {
      const { id, name } = event.target as Control;
      if (names.includes(id) || names.includes(name)) this.keep();
    });
    // Controls that a key action has changed send no event, so they are stored here.
    window.addEventListener("pagehide", () => this.keep());
  }
  private restored = false;

  /** Sets the controls to the stored values, once, and fires their events. */
  restore(): void {
    if (this.restored) return;
    this.restored = true;
    // Each restored control fires an event that stores all controls. Work on a copy of the stored
    // values, so that this does not overwrite the rest.
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
      // A stored choice may no longer exist.
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
      // A group of radio buttons may have none checked.
      if (!one) delete this.kept[name];
      else
        this.kept[name] =
          one.type === "checkbox" ? ((one as HTMLInputElement).checked ? "1" : "0") : one.value;
    }
    try {
      localStorage.setItem(STORE, JSON.stringify(this.kept));
    } catch {
      // Without storage the settings hold until the page is reloaded.
    }
  }
}
