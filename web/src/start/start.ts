// SPDX-License-Identifier: MIT
// The start page: a new piece, a file, an example or an existing document.
import { element, input } from "../base/dom";
import { request } from "../connection/access";
import { Importer } from "./import";
import { IMPORTS } from "../connection/kinds";
import { write } from "../connection/messages";
import type { Material } from "../view/wood";
import type { Vec3 } from "../base/vec3";

interface Listed {
  name: string;
  changed: number;
  bytes: number;
}
export interface Example {
  name: string;
  about: string;
}

const value = (id: string): string => input(id).value;

export class Start {
  /** Imports files as documents, or as bodies of the open document. */
  readonly importer: Importer;

  constructor(private send: (message: Uint8Array) => void) {
    this.importer = new Importer();
    element("begin").addEventListener("submit", (event) => {
      event.preventDefault();
      this.begin();
    });
    const file = element<HTMLInputElement>("file");
    file.accept = IMPORTS;
    file.onchange = () => {
      this.bring(file.files);
      file.value = ""; // so that the same file can be chosen again
    };
    const box = element("start");
    box.addEventListener("dragover", (event) => event.preventDefault());
    box.addEventListener("drop", (event) => {
      event.preventDefault();
      this.bring(event.dataTransfer?.files);
    });
  }

  /** Several files are a milling job. */
  private bring(files: FileList | null | undefined): void {
    const all = [...(files ?? [])];
    if (all.length > 0) void this.importer.bring(all[0], 0, all);
  }

  /** Shows the start page with the studio's lists. Returns the examples. */
  show(json: string): Example[] {
    const { documents, materials, examples, page } = JSON.parse(json) as {
      documents: Listed[];
      materials: Material[];
      examples: Example[];
      page: string;
    };
    this.importer.offer(page, materials);
    const wood = element<HTMLSelectElement>("wood");
    const before = wood.selectedIndex;
    wood.replaceChildren(...materials.map((m, i) => new Option(m.name, String(i))));
    wood.selectedIndex = Math.max(0, before);
    element("example-list").replaceChildren(...examples.map((e) => this.example(e)));
    element("recent").hidden = documents.length === 0;
    element("documents").replaceChildren(...documents.map((d) => this.row(d)));
    // If the page is already shown, only the lists change. Keep the focus where the user types.
    const opens = element("start").hidden;
    element("start").hidden = false;
    if (opens || document.activeElement === document.body) element("go").focus();
    return examples;
  }
  hide(): void {
    this.importer.leave();
    element("start").hidden = true;
  }

  private begin(): void {
    const shape = Number(
      (document.querySelector("input[name=stock]:checked") as HTMLInputElement).value,
    );
    const long = Number(value("length"));
    const size: Vec3 = [
      [long, 0.625 * long, 0.375 * long] as Vec3,
      [0.5 * long, 0.5 * long, long] as Vec3,
      [long, long, long] as Vec3,
    ][shape];
    this.send(
      write.Begin({
        shape,
        size,
        pitch: long / Number(value("detail")),
        material: Number(value("wood")),
        name: value("name").trim(),
      }),
    );
  }

  private example(example: Example): HTMLElement {
    const button = document.createElement("button"),
      item = document.createElement("li");
    button.textContent = example.about;
    button.onclick = () => this.send(write.CarveExample({ name: example.name }));
    item.append(button);
    return item;
  }

  private row(listed: Listed): HTMLElement {
    const button = document.createElement("button");
    const when = new Date(1000 * listed.changed).toLocaleString(undefined, {
      dateStyle: "medium",
      timeStyle: "short",
    });
    const name = document.createElement("strong"),
      about = document.createElement("span");
    name.textContent = listed.name;
    about.textContent = `${when}, ${(listed.bytes / 1e6).toFixed(1)} MB`;
    button.append(name, about);
    button.onclick = () => this.send(write.Open({ name: listed.name }));
    request(`/thumbnail?document=${encodeURIComponent(listed.name)}`)
      .then(async (answer) => {
        if (answer.status !== 200) return;
        const image = document.createElement("img");
        image.src = URL.createObjectURL(await answer.blob());
        image.onload = () => URL.revokeObjectURL(image.src);
        image.alt = "";
        button.prepend(image);
      })
      .catch(() => undefined);
    const item = document.createElement("li");
    item.append(button);
    return item;
  }
}
