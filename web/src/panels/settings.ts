// SPDX-License-Identifier: MIT
// What is chosen in controls, kept in this browser: by their ids, and groups of radio buttons by
// their name.
const STORE = "kibori.settings";

type Control = HTMLInputElement | HTMLSelectElement;

export class Settings {
  private kept: Record<string, string> = {};

  constructor(private names: string[]) {
    try {
      const kept = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Record<string, unknown>;
      for (const name of names) if (typeof kept[name] === "string") this.kept[name] = kept[name];
    } catch {
      // What can't be read is as if it were not there.
    }
    document.addEventListener("change", (event) => {
      const { id, name } = event.target as Control;
      if (names.includes(id) || names.includes(name)) this.keep();
    });
    // Keys change controls without an event.
    window.addEventListener("pagehide", () => this.keep());
  }
  private restored = false;

  /** Puts the controls to what was kept, as if by hand; once. */
  restore(): void {
    if (this.restored) return;
    this.restored = true;
    // Each that is put back tells of a change, and all of them are kept again: the rest as it still
    // is.
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
      // A choice that is no longer there.
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
      // Then it holds for this visit.
    }
  }
}
