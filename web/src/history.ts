// SPDX-License-Identifier: MIT
// The history as a strip: the way from the stock to where the document stands, and on to where it was last; other
// branches by a mark where they leave it. Only the part around the present is in the page.

interface Step {
  id: number;
  parent: number;
  removed: number;
  next: number[];
}

const AROUND = 40; // steps shown before and after the present

export class History {
  private steps = new Map<number, Step>();
  private names = new Map<number, string>();
  private head = 0;
  /** Of a step that was gone back to: the one it was gone back from. */
  private last = new Map<number, number>();
  private document = 0; // counts
  private pictures = new Map<number, string>();
  private asked = new Set<number>();
  private due = false;

  constructor(
    private into: HTMLElement,
    private go: (step: number) => void,
    private name: () => void,
  ) {}

  clear(): void {
    this.steps.clear();
    this.names.clear();
    this.asked.clear();
    this.last.clear();
    this.document++;
    for (const url of this.pictures.values()) URL.revokeObjectURL(url);
    this.pictures.clear();
    this.head = 0;
    this.redraw();
  }

  add(data: Uint8Array): void {
    const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
    for (let at = 0; at + 12 <= data.byteLength; at += 12) {
      const step: Step = { id: view.getUint32(at, true), parent: view.getUint32(at + 4, true), removed: view.getFloat32(at + 8, true), next: [] };
      this.steps.set(step.id, step);
      this.steps.get(step.parent)?.next.push(step.id);
      this.last.delete(step.parent);
    }
    this.redraw();
  }

  setVersions(json: string): void {
    this.names.clear();
    for (const [name, step] of Object.entries(JSON.parse(json) as Record<string, number>)) {
      const other = this.names.get(step);
      this.names.set(step, other ? `${other}, ${name}` : name);
    }
    this.redraw();
  }

  setHead(step: number): void {
    if (step === this.head) return;
    // As redo goes: where it was gone back from. A step's number is above its parent's.
    const way: Step[] = [];
    let at = this.steps.get(this.head);
    for (; at && at.id > step; at = this.steps.get(at.parent)) way.push(at);
    if (at?.id === step) for (const left of way) this.last.set(left.parent, left.id);
    this.head = step;
    this.redraw();
  }

  setPicture(step: number, png: Blob): void {
    const old = this.pictures.get(step);
    if (old) URL.revokeObjectURL(old);
    this.pictures.set(step, URL.createObjectURL(png));
    this.asked.add(step);
    this.redraw();
  }

  /** Whether a picture of the step is there. */
  has(step: number): boolean {
    return this.pictures.has(step);
  }

  private redraw(): void {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.draw();
    });
  }

  private draw(): void {
    const way: Step[] = [];
    for (let at = this.steps.get(this.head); at && way.length < AROUND; at = this.steps.get(at.parent)) way.unshift(at);
    const cut = way.length > 0 && this.steps.has(way[0].parent);
    for (let at = this.steps.get(this.head); at && way.length < 2 * AROUND; ) {
      at = this.steps.get(this.last.get(at.id) ?? at.next[at.next.length - 1]);
      if (at) way.push(at);
    }
    const cells: HTMLElement[] = [];
    if (cut) cells.push(this.button("…", "farther back", () => this.go(way[0].id), "more"));
    for (const step of way) {
      cells.push(this.cell(step));
      const others = step.next.filter((id) => !way.some((s) => s.id === id));
      for (const id of others) cells.push(this.button(`⑂ ${this.names.get(this.tip(id)) ?? this.tip(id)}`, "another branch begins here: go to its end", () => this.go(this.tip(id)), "branch"));
    }
    cells.push(this.button("Name …", "give where you are a name, to come back to", this.name, "more"));
    const had = document.activeElement as HTMLElement | null;
    const focused = had && this.into.contains(had) ? cells.find((cell) => cell.dataset.step === had.dataset.step && cell.className === had.className && cell.title === had.title) : undefined;
    this.into.replaceChildren(...cells);
    focused?.focus();
    const here = this.into.querySelector<HTMLElement>("[aria-current]");
    if (here) this.into.scrollLeft = here.offsetLeft - this.into.clientWidth / 2 + here.offsetWidth / 2;
  }

  /** The newest end of the branch that a step is on. */
  private tip(id: number): number {
    let at = this.steps.get(id);
    while (at && at.next.length > 0) at = this.steps.get(at.next[at.next.length - 1]);
    return at?.id ?? id;
  }

  private cell(step: Step): HTMLElement {
    const removed = step.parent === 0 ? "the stock" : `${step.removed >= 0 ? "removed" : "added"} ${Math.abs(step.removed).toFixed(1)} mm³`;
    const cell = this.button("", `step ${step.id}: ${removed}`, () => this.go(step.id), "step");
    cell.dataset.step = String(step.id);
    if (step.id === this.head) cell.setAttribute("aria-current", "step");
    const picture = this.pictures.get(step.id);
    if (picture) {
      const image = document.createElement("img");
      image.src = picture;
      image.alt = "";
      cell.append(image);
    } else {
      this.ask(step.id);
    }
    const caption = document.createElement("span");
    caption.textContent = this.names.get(step.id) ?? (step.parent === 0 ? "stock" : String(step.id));
    if (this.names.has(step.id)) cell.classList.add("named");
    cell.append(caption);
    return cell;
  }

  private button(text: string, title: string, act: () => void, kind: string): HTMLButtonElement {
    const button = document.createElement("button");
    button.textContent = text;
    button.title = title;
    button.className = kind;
    button.onclick = act;
    return button;
  }

  private ask(step: number): void {
    if (this.asked.has(step)) return;
    this.asked.add(step);
    const { document } = this;
    fetch(`/thumbnail?step=${step}`)
      .then(async (answer) => {
        const picture = answer.status === 200 ? await answer.blob() : null;
        if (document !== this.document || this.has(step)) return;
        if (picture) this.setPicture(step, picture);
        // Whoever made the step may still be drawing it.
        else if (step === this.head) setTimeout(() => document === this.document && this.asked.delete(step), 3000);
      })
      .catch(() => this.asked.delete(step));
  }
}
