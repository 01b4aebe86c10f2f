// SPDX-License-Identifier: MIT
// Saved views of a document: camera positions. The browser keeps them by the document's name.
import { element } from "../base/dom";
import { notify } from "../base/notice";
import { t } from "../base/texts";
import type { Vec3 } from "../base/vec3";
import type { Cameras } from "../view/cameras";

const STORE = "kibori.views";
const MAX_VIEWS = 12,
  MAX_DOCUMENTS = 50;

interface Saved {
  eye: Vec3;
  target: Vec3;
}
const isVec3 = (a: unknown): a is Vec3 =>
  Array.isArray(a) && a.length === 3 && a.every((x) => Number.isFinite(x));

/** The saved views of all documents, the newest document last. */
function all(): Record<string, Saved[]> {
  try {
    const kept = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Record<string, Saved[]>;
    return Object.fromEntries(
      Object.entries(kept).map(([name, views]) => [
        name,
        Array.isArray(views)
          ? views.filter((view) => isVec3(view?.eye) && isVec3(view?.target))
          : [],
      ]),
    );
  } catch {
    return {}; // Ignore stored views that cannot be read.
  }
}

export class SavedViews {
  private document = "";
  private views: Saved[] = [];
  private last = -1; // the view that was shown last

  constructor(private cameras: Cameras) {
    element("view-save").onclick = () => this.save();
    this.show();
  }

  /** Starts with another document. */
  begin(name: string): void {
    this.document = name;
    this.views = all()[name] ?? [];
    this.last = -1;
    this.show();
  }
  save(): void {
    const { eye, target } = this.cameras;
    this.views = [...this.views, { eye, target: target.toArray() as Vec3 }].slice(-MAX_VIEWS);
    this.last = this.views.length - 1;
    this.keep();
  }
  /** Shows the next saved view. */
  next(): void {
    if (this.views.length === 0) notify(t("view_none"));
    else this.go((this.last + 1) % this.views.length);
  }

  private go(index: number): void {
    this.last = index;
    const { eye, target } = this.views[index];
    this.cameras.place(eye, target);
  }
  private keep(): void {
    const others = Object.entries(all()).filter(([name]) => name !== this.document);
    try {
      localStorage.setItem(
        STORE,
        JSON.stringify(
          Object.fromEntries([...others, [this.document, this.views]].slice(-MAX_DOCUMENTS)),
        ),
      );
    } catch {
      // Without storage the views hold until the page is reloaded.
    }
    this.show();
  }
  private show(): void {
    element("view-list").replaceChildren(
      ...this.views.map((view, i) => {
        const row = document.createElement("li"),
          go = document.createElement("button"),
          remove = document.createElement("button"),
          name = t("view_name", { n: i + 1 });
        go.textContent = name;
        go.onclick = () => this.go(i);
        remove.textContent = "×";
        remove.title = remove.ariaLabel = t("view_delete", { view: name });
        remove.onclick = () => {
          this.views = this.views.filter((other) => other !== view);
          this.last = -1;
          this.keep();
        };
        row.append(go, remove);
        return row;
      }),
    );
  }
}
