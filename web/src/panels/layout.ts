// SPDX-License-Identifier: MIT
// The layout of the panels. The style sheet places them. This file folds panels to buttons and
// moves them into the bottom sheet of a narrow window. It measures the area that they leave free.
import { element } from "../base/dom";
import type { Insets } from "../view/cameras";

const STORE = "kibori.panels";
const NARROW = "(max-width: 599.98px)"; // as in style.css
const MIN_SHEET = 110,
  SHEET_USUAL = 320; // height of the sheet's panel [px]; it closes if dragged lower
const DRAGGED = 6; // a shorter drag is a click [px]
/** The elements that cover the view. */
const COVERS = "#bar, #grip, #fixed, #corner, #transport, .panel";

interface Kept {
  folded: Record<string, boolean>;
  height: number;
}

/**
 * The best rectangle of a window that overlaps none of `taken`: the one with the longest shorter
 * side, and of equal ones the largest.
 */
export function freeOf(width: number, height: number, taken: DOMRect[]): Insets {
  const shown = taken.filter((r) => r.width > 0 && r.height > 0);
  const within = (x: number, max: number): number => Math.max(0, Math.min(max, x));
  const lefts = [0, ...shown.map((r) => within(r.right, width))],
    rights = [width, ...shown.map((r) => within(r.left, width))];
  const tops = [0, ...shown.map((r) => within(r.bottom, height))],
    bottoms = [height, ...shown.map((r) => within(r.top, height))];
  let best: Insets = { left: 0, right: 0, top: 0, bottom: 0 },
    side = 0,
    area = 0;
  for (const left of lefts)
    for (const right of rights)
      for (const top of tops)
        for (const bottom of bottoms) {
          const w = right - left,
            h = bottom - top,
            short = Math.min(w, h);
          if (short < side || short <= 0 || (short === side && w * h <= area)) continue;
          if (
            shown.some((r) => r.left < right && r.right > left && r.top < bottom && r.bottom > top)
          )
            continue;
          best = { left, right: width - right, top, bottom: height - bottom };
          side = short;
          area = w * h;
        }
  return best;
}

export class Layout {
  private narrow = window.matchMedia(NARROW);
  private kept: Kept;
  private tab = "tools"; // the panel in the sheet
  private open = false; // whether the sheet is open
  private panels = [...document.querySelectorAll<HTMLElement>(".panel")];

  /** Calls `free` with the free area whenever it changes. */
  constructor(private free: (insets: Insets) => void) {
    // Small windows begin with the force panel folded.
    this.kept = { folded: { force: innerWidth < 1100 }, height: SHEET_USUAL };
    try {
      const kept = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Partial<Kept>;
      for (const { id } of this.panels)
        if (typeof kept.folded?.[id] === "boolean") this.kept.folded[id] = kept.folded[id];
      if (typeof kept.height === "number" && kept.height >= MIN_SHEET)
        this.kept.height = kept.height;
    } catch {
      // Ignore stored values that cannot be read.
    }
    for (const panel of this.panels)
      panel.querySelector<HTMLButtonElement>(".fold")!.onclick = () => {
        this.kept.folded[panel.id] = !this.kept.folded[panel.id];
        this.keep();
        this.show();
      };
    for (const tab of document.querySelectorAll<HTMLButtonElement>(".tab"))
      tab.onclick = () => {
        this.open = !this.open || this.tab !== tab.dataset.panel;
        this.tab = tab.dataset.panel!;
        this.show();
      };
    this.makeHandle();
    this.narrow.addEventListener("change", () => this.show());
    const watch = new ResizeObserver(() => this.measure());
    for (const cover of document.querySelectorAll(COVERS)) watch.observe(cover);
    window.addEventListener("resize", () => this.measure());
    // The tab shows the tool and its size. Observe the elements, because several parts change them.
    const tools = element("tools");
    for (const kind of ["input", "change"]) tools.addEventListener(kind, () => this.name());
    new MutationObserver(() => this.name()).observe(tools, {
      childList: true,
      characterData: true,
      subtree: true,
    });
    this.name();
    this.show();
  }

  /** Chooses the panel that the sheet opens with. */
  choose(panel: string): void {
    this.tab = panel;
    this.show();
  }

  /** Computes the area that the panels leave free and reports it at once. */
  measure(): void {
    const taken = [...document.querySelectorAll(COVERS)].map((cover) =>
      cover.getBoundingClientRect(),
    );
    this.free(freeOf(innerWidth, innerHeight, taken));
  }

  /** The handle opens, closes and resizes the sheet. */
  private makeHandle(): void {
    const handle = element<HTMLButtonElement>("handle");
    let from: { y: number; height: number; moved: boolean } | null = null;
    const panel = (): HTMLElement => element(this.tab);
    handle.onclick = (event) => {
      // Ignore the click after a drag. A key or a press without motion toggles the sheet.
      if (event.detail !== 0 && from?.moved) return;
      this.open = !this.open;
      this.show();
    };
    handle.onpointerdown = (event) => {
      handle.setPointerCapture(event.pointerId);
      from = {
        y: event.clientY,
        height: this.open ? panel().getBoundingClientRect().height : 0,
        moved: false,
      };
    };
    handle.onpointermove = (event) => {
      if (!from || !handle.hasPointerCapture(event.pointerId)) return;
      const up = from.y - event.clientY;
      from.moved ||= Math.abs(up) > DRAGGED;
      if (!from.moved) return;
      this.open = true;
      this.kept.height = Math.max(0, from.height + up);
      this.show();
    };
    handle.onlostpointercapture = () => {
      if (!from?.moved) return;
      this.open = this.kept.height >= MIN_SHEET;
      if (!this.open) this.kept.height = SHEET_USUAL;
      this.show();
      this.kept.height = Math.max(
        MIN_SHEET,
        this.open ? panel().getBoundingClientRect().height : this.kept.height,
      );
      this.keep();
    };
  }

  private name(): void {
    const shape =
      document.querySelector<HTMLInputElement>("#choices .lit input")?.getAttribute("aria-label") ??
      "";
    const texts: [string, string][] = [
      ["tab-tool", shape],
      ["tab-size", `${Number(Number(element<HTMLInputElement>("size").value).toFixed(1))} mm`],
    ];
    for (const [id, text] of texts)
      if (element(id).textContent !== text) element(id).textContent = text;
  }

  private keep(): void {
    try {
      localStorage.setItem(STORE, JSON.stringify(this.kept));
    } catch {
      // Without storage the layout holds until the page is reloaded.
    }
  }

  private show(): void {
    const sheet = this.narrow.matches;
    for (const panel of this.panels) {
      const shown = sheet ? this.open && this.tab === panel.id : !this.kept.folded[panel.id];
      panel.classList.toggle("folded", !shown);
      panel.querySelector(".fold")!.setAttribute("aria-expanded", String(shown));
      document
        .querySelector(`.tab[data-panel="${panel.id}"]`)!
        .setAttribute("aria-expanded", String(shown));
    }
    element("handle").setAttribute("aria-expanded", String(this.open));
    element("carving").style.setProperty("--sheet-height", `${this.kept.height}px`);
    this.measure();
  }
}
