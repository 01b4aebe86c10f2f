// SPDX-License-Identifier: MIT
// Presets: named copies of a tool or brush with its numbers. They are kept in this browser,
// exported and imported as TOML.
import { element, input } from "../base/dom";
import { save } from "../base/files";
import { notify } from "../base/notice";
import { t } from "../base/texts";
import { fromToml, PresetError, toToml, type Preset } from "./preset_file";

const STORE = "kibori.presets";
const MAX_PRESETS = 200;

/** What the presets need from the hand. */
export interface PresetUser {
  /** The chosen tool or brush and its numbers. */
  current(): Omit<Preset, "name">;
  use(preset: Preset): void;
  /** The name of a tool or brush for the user. Null: it is unknown. */
  nameOf(item: string): string | null;
}

export class Presets {
  private presets: Preset[] = [];

  constructor(private user: PresetUser) {
    try {
      const kept = localStorage.getItem(STORE);
      if (kept) this.presets = fromToml(kept, (item) => user.nameOf(item) !== null);
    } catch {
      // Ignore stored presets that cannot be read.
    }
    element("preset-form").addEventListener("submit", (event) => {
      event.preventDefault();
      const name = input("preset-name").value.trim();
      if (!name) return;
      this.add([{ name, ...user.current() }]);
      input("preset-name").value = "";
    });
    element("preset-export").onclick = () =>
      save("kibori-presets.toml", new Blob([toToml(this.presets)], { type: "application/toml" }));
    input("preset-import").onchange = () => void this.import();
    this.show();
  }

  private async import(): Promise<void> {
    const file = input("preset-import").files?.[0];
    input("preset-import").value = "";
    if (!file) return;
    try {
      const presets = fromToml(await file.text(), (item) => this.user.nameOf(item) !== null);
      if (presets.length === 0) return notify(t("preset_missing", { file: file.name }));
      this.add(presets);
      notify(t("presets_imported", { n: presets.length }));
    } catch (error) {
      if (!(error instanceof PresetError)) throw error;
      notify(
        t("preset_wrong", {
          file: file.name,
          line: error.line,
          reason: t(`preset_reason_${error.reason}`),
        }),
      );
    }
  }

  /** Adds presets. A preset replaces an older one of the same name. */
  private add(more: Preset[]): void {
    const names = new Set(more.map(({ name }) => name));
    this.presets = [...this.presets.filter(({ name }) => !names.has(name)), ...more].slice(
      -MAX_PRESETS,
    );
    this.keep();
  }
  private keep(): void {
    try {
      localStorage.setItem(STORE, toToml(this.presets));
    } catch {
      // Without storage the presets hold until the page is reloaded.
    }
    this.show();
  }
  private show(): void {
    element("preset-none").hidden = this.presets.length > 0;
    element<HTMLButtonElement>("preset-export").disabled = this.presets.length === 0;
    element("preset-list").replaceChildren(
      ...this.presets.map((preset) => {
        const row = document.createElement("li"),
          use = document.createElement("button"),
          remove = document.createElement("button");
        use.textContent = preset.name;
        use.title = t("preset_use", {
          name: preset.name,
          tool: this.user.nameOf(preset.item) ?? "",
        });
        use.onclick = () => this.user.use(preset);
        remove.textContent = "×";
        remove.title = remove.ariaLabel = t("preset_delete", { name: preset.name });
        remove.onclick = () => {
          this.presets = this.presets.filter((other) => other !== preset);
          this.keep();
        };
        row.append(use, remove);
        return row;
      }),
    );
  }
}
