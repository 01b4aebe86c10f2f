// SPDX-License-Identifier: MIT
// The strip of the history. It shows the path from the stock to the current step, and the later
// steps that were undone. Consecutive strokes of one tool form a group, which the user can open.
// Lines above the path show where branches leave it. The page contains only the visible cells and
// asks only for their pictures.
import { t } from "../base/texts";
import { request } from "../connection/access";
import { isAction, MOVED, StepTree, type Branch, type Group, type Step } from "./steps";
import { BRUSHES } from "../tools/brushes";
import { TOOLS, held, iconOf, sizeOf } from "../tools/tools";

/** A cell of the strip: a step, or a group of several steps. */
interface Item {
  key: string;
  group: Group;
  step: Step; // of a group: the newest
  // The steps it represents: its own and the steps before it in which the tool only moved.
  steps: Step[];
  whole: boolean; // it is a group
  open: boolean;
  single: boolean; // the only cell of its group
  x: number;
  width: number;
  branches: Branch[] | null; // null: not computed yet
}

const STEP_PX = 76,
  GROUP_PX = 164,
  OPEN_PX = 112,
  APART_PX = 4;
const MARGIN_PX = 200; // cells outside the view exist up to this distance
// Lines above the cells [px]. The line of the path is at DIRECTION_Y, the ends of branches are in
// the lanes above it.
const DIRECTION_Y = 32,
  LANES_Y = [8, 20],
  TREE_PX = 40,
  DOT_PX = 13;
const MAX_PICTURES = 500; // max number that the page keeps
const LATER_MS = [3000, 10000]; // delays before asking for a picture that another page draws

const SVG = "http://www.w3.org/2000/svg";
function svg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Record<string, string | number>,
): SVGElementTagNameMap[K] {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  return made;
}
function text(kind: string, words: string, tag = "span"): HTMLElement {
  const made = document.createElement(tag);
  made.className = kind;
  made.textContent = words;
  return made;
}
const strokeCount = (n: number): string => (n === 1 ? t("one_stroke") : t("n_strokes", { n }));
function volume(removed: number): string {
  const size = Math.abs(removed),
    sign = removed >= 0 ? "−" : "+";
  return size >= 1000
    ? `${sign}${(size / 1000).toFixed(size < 10000 ? 1 : 0)} cm³`
    : `${sign}${size.toFixed(size < 10 ? 1 : 0)} mm³`;
}
/** The time of day, with the date if it is not today. */
function time(made: number, whole = false): string {
  if (made === 0) return "";
  const at = new Date(1000 * made),
    today = at.toDateString() === new Date().toDateString();
  const clock = at.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit", hour12: false });
  return today && !whole
    ? clock
    : `${at.toLocaleDateString([], { day: "numeric", month: "short" })} ${clock}`;
}
function toolName(step: Step): string {
  const known = held(step.tool),
    tool = known ? `${TOOLS[known.shape].name} ${sizeOf(known)}`.trimEnd() : t("other_tool");
  if (step.mode === "deposit") return t("tool_adds", { tool });
  if (step.mode === "press") return t("tool_presses", { tool });
  if (step.mode === "throw" || step.mode === "turn") return t("tool_on_wheel", { tool });
  // If the step used a brush, its name counts, not that of the tool.
  return BRUSHES[step.mode]?.name ?? tool;
}
/** The origin of a step: the stock, or a tool. Empty for an action, which has its own label. */
const toolOf = (step: Step): string =>
  step.parent === 0 ? t("stock") : isAction(step) ? "" : toolName(step);
function wordsOf(...parts: HTMLElement[]): HTMLElement {
  const words = document.createElement("span");
  words.className = "words";
  words.append(...parts);
  return words;
}
/** The icon of a step's tool. The stock and unknown tools have the icon of a block. */
const toolIcon = (step: Step): string => iconOf(held(step.tool)?.shape ?? "box");

export class History {
  private tree = new StepTree();
  private names = new Map<number, string>();
  private document = 0; // counts documents
  private pictures = new Map<number, string>();
  private requested = new Set<number>();
  /** Steps whose picture was not drawn by this page's camera. */
  private foreign = new Set<number>();
  private items: Item[] = [];
  private present: Item | undefined; // the current step's item
  private forked = false; // there is a branch
  private onPath = new Set<number>();
  // Groups that the user opened or closed, by their first steps.
  private toggled = new Map<number, boolean>();
  private cells = new Map<string, { cell: HTMLButtonElement; look: string }>();
  private focus = ""; // key of the item in the tab order; empty: the present one
  private due = false;
  private changed = false; // the content has changed, not only its visible part
  private centre = false;
  private moved = false; // the current step has changed since the last layout
  private scroller = document.createElement("div");
  private inner = document.createElement("div");
  private lines = svg("svg", { class: "tree" });

  constructor(
    into: HTMLElement,
    private go: (step: number) => void,
    name: () => void,
  ) {
    this.scroller.className = "scroller";
    this.inner.className = "cells";
    this.inner.setAttribute("role", "toolbar");
    this.inner.setAttribute("aria-label", t("steps_help"));
    this.inner.append(this.lines);
    this.scroller.append(this.inner);
    const more = text("more", "Name …", "button") as HTMLButtonElement;
    more.title = t("name_step_hint");
    more.onclick = name;
    into.append(this.scroller, more);
    this.scroller.addEventListener("scroll", () => this.redraw(false));
    // A wheel that turns in only one direction scrolls along the strip.
    this.scroller.addEventListener("wheel", (event) => {
      if (event.deltaX !== 0 || event.shiftKey) return;
      event.preventDefault();
      this.scroller.scrollLeft += event.deltaY;
    });
    this.inner.addEventListener("keydown", (event) => this.press(event));
    new ResizeObserver(() => this.redraw(false)).observe(this.scroller);
  }

  clear(): void {
    this.tree.clear();
    this.names.clear();
    this.requested.clear();
    this.foreign.clear();
    this.toggled.clear();
    this.focus = "";
    this.document++;
    for (const url of this.pictures.values()) URL.revokeObjectURL(url);
    this.pictures.clear();
    this.redraw();
  }

  add(data: Uint8Array): void {
    this.tree.add(data);
    this.centre = true;
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
    if (step === this.tree.head) return;
    this.tree.setHead(step);
    this.focus = "";
    this.centre = this.moved = true;
    this.redraw();
    const { document } = this;
    for (const later of LATER_MS)
      setTimeout(() => {
        if (document === this.document && step === this.tree.head && !this.pictures.has(step))
          this.ask(step);
      }, later);
  }

  setPicture(step: number, png: Blob, foreign = false): void {
    const old = this.pictures.get(step);
    if (old) URL.revokeObjectURL(old);
    this.pictures.delete(step);
    this.pictures.set(step, URL.createObjectURL(png));
    const [oldest, url] = this.pictures.entries().next().value!;
    if (this.pictures.size > MAX_PICTURES) {
      URL.revokeObjectURL(url);
      this.pictures.delete(oldest);
      this.requested.delete(oldest);
    }
    this.requested.add(step);
    if (foreign) this.foreign.add(step);
    else this.foreign.delete(step);
    this.tree.setPictured(step);
    this.redraw();
  }

  /** True if the step lacks a picture by the page's own camera. */
  wants(step: number): boolean {
    const own = this.tree.get(step);
    return own !== undefined && (own.picture !== step || this.foreign.has(step));
  }

  private redraw(changed = true): void {
    this.changed ||= changed;
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.draw();
    });
  }

  private draw(): void {
    if (this.changed) this.updateLayout();
    this.changed = false;
    const { present } = this;
    if (this.centre && present)
      this.scroller.scrollLeft = present.x + present.width / 2 - this.scroller.clientWidth / 2;
    this.centre = false;
    const from = this.scroller.scrollLeft - MARGIN_PX,
      to = this.scroller.scrollLeft + this.scroller.clientWidth + MARGIN_PX;
    let first = 0;
    for (let end = this.items.length; first < end; ) {
      const middle = (first + end) >> 1;
      if (this.items[middle].x + this.items[middle].width < from) first = middle + 1;
      else end = middle;
    }
    const seen: Item[] = [];
    for (let i = first; i < this.items.length && this.items[i].x <= to; i++)
      seen.push(this.items[i]);
    // The item in the tab order exists even if it is out of view.
    const stop = this.items.find((item) => item.key === this.focus) ?? present;
    const there = new Set(seen);
    if (stop) there.add(stop);
    const keys = new Set([...there].map((item) => item.key));
    for (const [key, { cell }] of this.cells)
      if (!keys.has(key)) {
        cell.remove();
        this.cells.delete(key);
      }
    // Keep the order of the strip for screen readers. Do not move a cell that stays, because moving
    // takes its focus.
    let place = this.lines.nextSibling;
    for (const item of [...there].sort((a, b) => a.x - b.x)) {
      const cell = this.show(item, item === stop);
      if (cell === place) place = cell.nextSibling;
      else this.inner.insertBefore(cell, place);
    }
    this.drawTree(seen, first);
  }

  /** Computes the position of every item. */
  private updateLayout(): void {
    const path = this.tree.path();
    this.onPath = new Set(path.map((step) => step.id));
    this.items = [];
    let x = 0;
    const put = (
      item: Pick<Item, "key" | "group" | "steps" | "step"> & Partial<Item>,
      width: number,
    ): void => {
      this.items.push({
        whole: false,
        open: false,
        single: false,
        branches: null,
        ...item,
        x,
        width,
      });
      x += width + APART_PX;
    };
    for (const group of this.tree.groups(path, (step) => this.names.has(step.id))) {
      // Steps in which the tool only moved have no cell. Exceptions are the current step and named
      // steps.
      const cells: { step: Step; steps: Step[] }[] = [];
      let moved: Step[] = [];
      for (const step of group.steps) {
        moved.push(step);
        if (step.mode === MOVED && step.id !== this.tree.head && !this.names.has(step.id)) continue;
        cells.push({ step, steps: moved });
        moved = [];
      }
      if (cells.length === 0) cells.push({ step: moved.at(-1)!, steps: moved });
      else cells.at(-1)!.steps.push(...moved);
      if (cells.length === 1) {
        put({ key: `step ${cells[0].step.id}`, group, ...cells[0], single: true }, STEP_PX);
        continue;
      }
      const present = group.steps.some((step) => step.id === this.tree.head);
      if (present && this.moved) this.toggled.delete(group.steps[0].id);
      const open = this.toggled.get(group.steps[0].id) ?? present;
      put(
        {
          key: `group ${group.steps[0].id}`,
          group,
          step: cells.at(-1)!.step,
          steps: group.steps,
          whole: true,
          open,
        },
        open ? OPEN_PX : GROUP_PX,
      );
      if (open)
        for (const { step, steps } of cells)
          put({ key: t("step_number", { step: step.id }), group, step, steps }, STEP_PX);
    }
    this.moved = false;
    const { head } = this.tree;
    this.present = this.items.find((item) =>
      item.whole
        ? !item.open && item.steps.some((step) => step.id === head)
        : item.step.id === head,
    );
    this.inner.style.width = `${Math.max(0, x - APART_PX)}px`;
    this.forked = this.tree.forked;
  }

  private toggle(item: Item): void {
    this.toggled.set(item.group.steps[0].id, !item.open);
    this.focus = item.key;
    this.redraw();
  }

  private show(item: Item, stop: boolean): HTMLElement {
    const { step, group } = item;
    const picture = item.whole && item.open ? 0 : step.picture;
    const url = picture ? this.pictures.get(picture) : undefined;
    if (picture && !url) this.ask(picture);
    const present = item === this.present,
      ahead =
        step.id > this.tree.head &&
        !present &&
        !(item.whole && group.steps[0].id <= this.tree.head);
    const named = this.names.get(step.id);
    const look = JSON.stringify([
      item.x,
      item.open,
      group.steps.length,
      url,
      picture,
      present,
      ahead,
      named,
      stop,
    ]);
    const had = this.cells.get(item.key);
    if (had?.look === look) return had.cell;
    const cell = had?.cell ?? document.createElement("button");
    this.cells.set(item.key, { cell, look });
    cell.style.left = `${item.x}px`;
    cell.style.width = `${item.width}px`;
    cell.tabIndex = stop ? 0 : -1;
    cell.dataset.key = item.key;
    cell.className = item.whole ? "group" : "step";
    cell.classList.toggle("ahead", ahead);
    cell.classList.toggle("named", named !== undefined && !(item.whole && item.open));
    if (present) cell.setAttribute("aria-current", "step");
    else cell.removeAttribute("aria-current");
    const shown = this.pictureOf(step, picture, url);
    if (item.whole) this.fillGroup(cell, item, shown, named);
    else this.fillStep(cell, item, shown, named);
    cell.setAttribute("aria-label", cell.title);
    return cell;
  }

  /**
   * The picture of a step. `url` is the image of step `picture`, which may be an earlier one; 0:
   * none.
   */
  private pictureOf(step: Step, picture: number, url: string | undefined): HTMLElement {
    const shown = document.createElement("span");
    shown.className = "shown";
    if (url) {
      const image = document.createElement("img");
      image.src = url;
      image.alt = "";
      shown.append(image);
      // The picture belongs to an earlier step.
      shown.classList.toggle("earlier", picture !== step.id);
    }
    if (!url || picture !== step.id) shown.insertAdjacentHTML("beforeend", toolIcon(step));
    return shown;
  }

  private fillGroup(
    cell: HTMLElement,
    item: Item,
    shown: HTMLElement,
    named: string | undefined,
  ): void {
    const { group } = item,
      tool = toolOf(item.step),
      made = group.steps[0].made;
    const strokes = strokeCount(group.steps.filter(({ mode }) => mode !== MOVED).length);
    cell.setAttribute("aria-expanded", String(item.open));
    cell.onclick = () => this.toggle(item);
    cell.title = t(item.open ? "group_close" : "group_open", {
      tool,
      strokes,
      time: time(made, true),
    });
    const words = wordsOf(
      text("tool", tool),
      text("quiet", strokes),
      !item.open && named ? text("name", named) : text("quiet", time(made)),
    );
    const arrow = svg("svg", { viewBox: "0 0 10 10", class: "arrow", "aria-hidden": "true" });
    arrow.append(svg("path", { d: item.open ? "M6.5 1.5L3 5L6.5 8.5" : "M3.5 1.5L7 5L3.5 8.5" }));
    cell.replaceChildren(shown, words, arrow);
  }

  private fillStep(
    cell: HTMLElement,
    { step, single }: Item,
    shown: HTMLElement,
    named: string | undefined,
  ): void {
    const tool = toolOf(step),
      { picture } = step;
    const changed =
      step.parent === 0 ? "" : step.mode === MOVED ? t("moved_only") : volume(step.removed);
    cell.onclick = () => this.go(step.id);
    const about = [
      step.label,
      named && `“${named}”`,
      step.parent !== 0 &&
        step.mode !== MOVED &&
        !isAction(step) &&
        t(step.removed >= 0 ? "removed_volume" : "added_volume", {
          volume: Math.abs(step.removed).toFixed(1),
        }),
      time(step.made, true),
    ];
    if (picture && picture !== step.id) about.push(t("picture_of_step", { step: picture }));
    cell.title = t("step_about", {
      step: step.id,
      about: [tool, ...about].filter(Boolean).join(", "),
    });
    cell.dataset.step = String(step.id);
    const words = wordsOf(
      named
        ? text("name", named)
        : text("tool", step.label || (single ? tool : t("step_number", { step: step.id }))),
      text("quiet", single ? time(step.made) : changed),
    );
    cell.replaceChildren(shown, words);
  }

  /** Draws the path as a line, and the branches that leave the visible part of it. */
  private drawTree(seen: Item[], first: number): void {
    const held = document.activeElement?.closest<SVGElement>("#history .branch")?.dataset.tip;
    this.lines.replaceChildren();
    if (seen.length === 0 || !this.forked) return;
    const { head } = this.tree,
      last = seen.at(-1)!;
    const middle = (item: Item): number => item.x + item.width / 2;
    this.lines.setAttribute("width", String(last.x + last.width));
    this.lines.setAttribute("height", String(TREE_PX));
    const begin = first > 0 ? middle(this.items[first - 1]) : middle(seen[0]);
    const end = this.items[first + seen.length] ? last.x + last.width : middle(last);
    const { present } = this;
    const here = present ? Math.min(end, Math.max(begin, middle(present))) : begin;
    this.lines.append(
      svg("path", { class: "way ahead", d: `M${here} ${DIRECTION_Y}H${end}` }),
      svg("path", { class: "way", d: `M${begin} ${DIRECTION_Y}H${here}` }),
    );
    seen.forEach((item, i) => {
      if (item.whole && item.open) return;
      const x = middle(item),
        next = this.items[first + i + 1];
      item.branches ??= item.steps.flatMap((step) => this.tree.branches(step, this.onPath));
      const room = Math.max(
        1,
        next
          ? Math.floor((middle(next) - x - 14) / DOT_PX)
          : Math.floor((this.scroller.clientWidth - 20) / DOT_PX),
      );
      const { curves, dots } = this.drawBranches(item, item.branches, x, room);
      const ahead = item.step.id > head && item !== present;
      this.lines.append(
        ...curves,
        svg("circle", {
          cx: x,
          cy: DIRECTION_Y,
          r: item === present ? 5.5 : 3.5,
          class: `node${item === present ? " here" : ahead ? " ahead" : ""}`,
        }),
        ...dots,
      );
    });
    if (held) this.lines.querySelector<SVGElement>(`[data-tip="${held}"]`)?.focus();
  }

  /**
   * Draws the branches that leave a cell at x: their lines and their ends, in a number of columns.
   */
  private drawBranches(
    item: Item,
    all: Branch[],
    x: number,
    columns: number,
  ): { curves: SVGElement[]; dots: SVGElement[] } {
    const places = LANES_Y.length * columns;
    // If there is no room for all branches, the last place represents all the oldest ones.
    const shown = all.length <= places ? all : all.slice(all.length - places + 1);
    const hidden = all.length - shown.length;
    const curves: SVGElement[] = [],
      dots: SVGElement[] = [];
    const add = (branch: Branch, k: number, title: string, ...marks: SVGElement[]): void => {
      // The newest branch is the nearest to the cell. The low lane is filled first.
      const dx = x + 16 + DOT_PX * Math.floor(k / LANES_Y.length),
        dy = LANES_Y[LANES_Y.length - 1 - (k % LANES_Y.length)];
      curves.push(
        svg("path", {
          class: "off",
          d: `M${x} ${DIRECTION_Y}C${x + 4} ${dy} ${x + 6} ${dy} ${dx} ${dy}`,
        }),
      );
      dots.push(this.branchEnd(item, branch, title, dx, dy, marks));
    };
    [...shown].reverse().forEach((branch, k) => {
      const name = this.names.get(branch.tip.id);
      const title = t("branch_about", {
        name: name ? ` “${name}”` : "",
        strokes: strokeCount(branch.strokes),
        tool: toolName(branch.tip),
        time: time(branch.tip.made, true),
        step: branch.tip.id,
      });
      const marks: SVGElement[] = [
        svg("circle", { r: name ? 4.5 : 3.5, class: name ? "dot named" : "dot" }),
      ];
      if (name && all.length === 1) {
        const label = svg("text", { x: 9, y: 3.5 });
        label.textContent = name.length > 14 ? `${name.slice(0, 13)}…` : name;
        marks.push(label);
      }
      add(branch, k, title, ...marks);
    });
    if (hidden > 0) {
      const mark = svg("text", { "text-anchor": "middle", y: 3.5 });
      mark.textContent = `+${hidden}`;
      add(
        all[hidden - 1],
        shown.length,
        t("older_branches", { n: hidden, step: all[hidden - 1].tip.id }),
        mark,
      );
    }
    return { curves, dots };
  }
  /** A button at the end of a branch that leaves a cell. */
  private branchEnd(
    { key }: Item,
    { tip }: Branch,
    title: string,
    x: number,
    y: number,
    marks: SVGElement[],
  ): SVGElement {
    const g = svg("g", {
      class: "branch",
      role: "button",
      tabindex: -1,
      "aria-label": title,
      transform: `translate(${x} ${y})`,
    });
    g.dataset.tip = String(tip.id);
    g.dataset.from = key;
    const about = svg("title", {});
    about.textContent = title;
    g.append(about, svg("circle", { r: 7, class: "hit" }), ...marks);
    g.addEventListener("click", () => this.go(tip.id));
    return g;
  }

  /**
   * Handles the arrow keys: along the strip, up to the branches that leave a cell, and back down.
   */
  private press(event: KeyboardEvent): void {
    const at = event.target as HTMLElement | SVGElement;
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    // Enter and Space press only the cell, no other action.
    if (event.key === "Enter" || event.key === " ") event.stopPropagation();
    const branch = at.closest<SVGElement>(".branch");
    const along: Record<string, number> = { ArrowLeft: -1, ArrowRight: 1 };
    if (branch) {
      const siblings = [...this.lines.querySelectorAll<SVGElement>(".branch")].filter(
        (other) => other.dataset.from === branch.dataset.from,
      );
      if (event.key in along) siblings[siblings.indexOf(branch) + along[event.key]]?.focus();
      else if (event.key === "ArrowDown") this.cells.get(branch.dataset.from!)?.cell.focus();
      else if (event.key === "Enter" || event.key === " ") this.go(Number(branch.dataset.tip));
      else return;
    } else {
      const index = this.items.findIndex(
        (item) => item.key === at.closest<HTMLElement>("[data-key]")?.dataset.key,
      );
      const to =
        event.key in along
          ? index + along[event.key]
          : event.key === "Home"
            ? 0
            : event.key === "End"
              ? this.items.length - 1
              : -1;
      if (event.key === "ArrowUp")
        [...this.lines.querySelectorAll<SVGElement>(".branch")]
          .find((other) => other.dataset.from === this.items[index]?.key)
          ?.focus();
      else if (!(event.key in along || event.key === "Home" || event.key === "End")) return;
      else if (this.items[to]) this.moveFocus(this.items[to]);
    }
    event.preventDefault();
    event.stopPropagation();
  }

  private moveFocus(item: Item): void {
    this.focus = item.key;
    const { scrollLeft, clientWidth } = this.scroller;
    if (item.x < scrollLeft) this.scroller.scrollLeft = item.x - APART_PX;
    if (item.x + item.width > scrollLeft + clientWidth)
      this.scroller.scrollLeft = item.x + item.width - clientWidth + APART_PX;
    this.draw();
    this.cells.get(item.key)?.cell.focus({ preventScroll: true });
  }

  private ask(step: number): void {
    if (this.requested.has(step)) return;
    this.requested.add(step);
    const { document } = this;
    request(`/thumbnail?step=${step}`)
      .then(async (answer) => {
        const picture = answer.status === 200 ? await answer.blob() : null;
        const foreign = picture !== null && (await hasGround(picture));
        if (document !== this.document || this.pictures.has(step)) return;
        if (picture) this.setPicture(step, picture, foreign);
        else this.requested.delete(step);
      })
      .catch(() => this.requested.delete(step));
  }
}

/**
 * True if the picture's first pixel is opaque. It is transparent in pictures that the page draws.
 */
async function hasGround(png: Blob): Promise<boolean> {
  const canvas = document.createElement("canvas"),
    into = canvas.getContext("2d")!;
  try {
    into.drawImage(await createImageBitmap(png), 0, 0);
  } catch {
    return true; // not a picture, so it is drawn again
  }
  return into.getImageData(0, 0, 1, 1).data[3] > 0;
}
