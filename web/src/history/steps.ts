// SPDX-License-Identifier: MIT
// The tree of steps, from the message Steps: the path through it that the strip shows, the groups
// of strokes along the path, and the branches next to it. This file is independent of the page.
import type { Mode, Tool } from "../connection/kinds";
import { Reader } from "../connection/wire";

export interface Step {
  id: number;
  parent: number;
  removed: number; // [mm^3]; negative: added
  made: number; // [s since 1970]; 0: unknown
  tool: Tool | null; // null: the stock, actions on bodies, unknown tools; steps share it
  mode: Mode; // `off`: the tool only moved
  label: string;
  next: number[];
  /** The nearest step with a picture on the path to this step, or this step itself; 0: none. */
  picture: number;
}

/** Consecutive steps of one tool with the same numbers, made within five minutes. All cut, or all
 * fill. The stock is also a group. */
export interface Group {
  steps: Step[];
  mode: Mode; // number of steps in which the tool did not only move
}

/** The end of a branch that leaves the path. */
export interface Branch {
  tip: Step;
  strokes: number; // counted from the step at which it leaves
}

const GROUP_S = 300;
/** The mode of a step in which the tool only moved. */
export const MOVED: Mode = "off";

/** True if the step is not a stroke but an action on bodies. Its label describes it. */
export const isAction = (step: Step): boolean => step.tool === null && step.label !== "";

export class StepTree {
  private steps = new Map<number, Step>();
  private tools = new Map<string, Tool | null>(); // by the tool's text
  /** For each step that an undo went back to: the step before the undo. */
  private last = new Map<number, number>();
  head = 0;

  clear(): void {
    this.steps.clear();
    this.last.clear();
    this.head = 0;
  }

  get(id: number): Step | undefined {
    return this.steps.get(id);
  }

  add(data: Uint8Array): void {
    const read = new Reader(data.slice().buffer);
    while (read.more) {
      const id = read.u32(),
        parent = read.u32(),
        removed = read.f32(),
        made = read.f64(),
        tool = this.toolOf(read.text());
      const mode = read.mode(),
        pictured = read.u8() === 1,
        label = read.text();
      const before = this.steps.get(parent);
      before?.next.push(id);
      this.last.delete(parent);
      this.steps.set(id, {
        id,
        parent,
        removed,
        made,
        tool,
        mode,
        label,
        next: [],
        picture: pictured ? id : (before?.picture ?? 0),
      });
    }
  }

  private toolOf(text: string): Tool | null {
    const known = this.tools.get(text);
    if (known !== undefined) return known;
    const tool = JSON.parse(text) as Tool | null;
    this.tools.set(text, tool);
    return tool;
  }

  setHead(step: number): void {
    // The child that redo goes to. A step's number is greater than its parent's.
    const way: Step[] = [];
    let at = this.steps.get(this.head);
    for (; at && at.id > step; at = this.steps.get(at.parent)) way.push(at);
    if (at?.id === step) for (const left of way) this.last.set(left.parent, left.id);
    this.head = step;
  }

  /** Marks a step as having a picture. */
  setPictured(step: number): void {
    const own = this.steps.get(step);
    if (!own || own.picture === step) return;
    const before = own.picture;
    own.picture = step;
    // Parents come before their children.
    for (const other of this.steps.values())
      if (other.id > step && other.picture === before)
        other.picture = this.steps.get(other.parent)?.picture ?? 0;
  }

  /** The path from the stock to the head, and on to the last step before an undo. */
  way(): Step[] {
    const way: Step[] = [];
    for (let at = this.steps.get(this.head); at; at = this.steps.get(at.parent)) way.push(at);
    way.reverse();
    for (let at: Step | undefined = way.at(-1); at; ) {
      at = this.steps.get(this.last.get(at.id) ?? at.next.at(-1) ?? 0);
      if (at) way.push(at);
    }
    return way;
  }

  /** `ends` is true for a step that ends a group, for example because it has a name. */
  groups(way: Step[], ends: (step: Step) => boolean): Group[] {
    const groups: Group[] = [];
    let ended = true;
    for (const step of way) {
      const last = groups.at(-1),
        first = last?.steps[0];
      const alike =
        last &&
        first &&
        first.tool === step.tool &&
        !isAction(first) &&
        !isAction(step) &&
        (step.mode === last.mode || step.mode === MOVED || last.mode === MOVED);
      if (!alike || ended || step.made - first.made > GROUP_S)
        groups.push({ steps: [step], mode: step.mode });
      else {
        last.steps.push(step);
        if (last.mode === MOVED) last.mode = step.mode;
      }
      ended = step.parent === 0 || ends(step);
    }
    return groups;
  }

  /** The ends of all branches that leave the path at a step, newest last. */
  branches(step: Step, onWay: Set<number>): Branch[] {
    const found: Branch[] = [];
    const open = step.next.filter((id) => !onWay.has(id)).map((id) => ({ id, before: 0 }));
    for (let at = open.pop(); at; at = open.pop()) {
      const tip = this.steps.get(at.id)!;
      const strokes = at.before + (tip.mode === MOVED ? 0 : 1);
      if (tip.next.length === 0) found.push({ tip, strokes });
      for (const id of tip.next) open.push({ id, before: strokes });
    }
    return found.sort((a, b) => a.tip.id - b.tip.id);
  }

  /** True if there is a branch. */
  get forked(): boolean {
    for (const step of this.steps.values()) if (step.next.length > 1) return true;
    return false;
  }
}
