// SPDX-License-Identifier: MIT
// The tree of steps, as the message Steps reports it. This file computes the path that the strip
// of the history (history.ts) shows. It also finds the groups of strokes on this path, and the
// branches that leave the path. It does not use the elements of the page.
import type { Mode, Tool } from "../connection/kinds";
import { Reader } from "../connection/wire";

export interface Step {
  id: number;
  parent: number;
  removed: number; // [mm^3]; negative: added
  made: number; // [s since 1970]; 0: unknown
  // Null: the stock, an action on bodies, or a tool that pages do not know. Steps with equal tools
  // refer to the same object, so === compares tools.
  tool: Tool | null;
  mode: Mode; // off: the tool only moved
  label: string;
  next: number[];
  /** The nearest step on the path to this one, itself included, that has a picture. 0: none has. */
  picture: number;
}

/**
 * Consecutive steps with the same tool and mode, all made within five minutes of the first one. The
 * stock is a group too.
 */
export interface Group {
  steps: Step[];
  mode: Mode; // of the steps that did more than move
}

/** The end of a branch that leaves the path. */
export interface Branch {
  tip: Step;
  strokes: number; // number of strokes from where it leaves
}

const GROUP_S = 300;
/** The mode of a step in which the tool only moved. */
export const MOVED: Mode = "off";

/** True if the step is an action on bodies, not a stroke. Its label says which action. */
export const isAction = (step: Step): boolean => step.tool === null && step.label !== "";

export class StepTree {
  private steps = new Map<number, Step>();
  private tools = new Map<string, Tool | null>(); // by their JSON text
  /** For each step from which redo can continue: its next step on the path that was undone last. */
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
    // Remember the path for redo. A step's number is greater than its parent's.
    const path: Step[] = [];
    let at = this.steps.get(this.head);
    for (; at && at.id > step; at = this.steps.get(at.parent)) path.push(at);
    if (at?.id === step) for (const left of path) this.last.set(left.parent, left.id);
    this.head = step;
  }

  /** Records that the step now has a picture. */
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

  /** The path from the stock to the head, and the later steps that were undone. */
  path(): Step[] {
    const path: Step[] = [];
    for (let at = this.steps.get(this.head); at; at = this.steps.get(at.parent)) path.push(at);
    path.reverse();
    for (let at: Step | undefined = path.at(-1); at; ) {
      at = this.steps.get(this.last.get(at.id) ?? at.next.at(-1) ?? 0);
      if (at) path.push(at);
    }
    return path;
  }

  /**
   * Splits the path into groups. `ends` returns true for a step that must be the last one of its
   * group, for example because the user named it.
   */
  groups(path: Step[], ends: (step: Step) => boolean): Group[] {
    const groups: Group[] = [];
    let ended = true;
    for (const step of path) {
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
  branches(step: Step, onPath: Set<number>): Branch[] {
    const found: Branch[] = [];
    const open = step.next.filter((id) => !onPath.has(id)).map((id) => ({ id, before: 0 }));
    for (let at = open.pop(); at; at = open.pop()) {
      const tip = this.steps.get(at.id)!;
      const strokes = at.before + (tip.mode === MOVED ? 0 : 1);
      if (tip.next.length === 0) found.push({ tip, strokes });
      for (const id of tip.next) open.push({ id, before: strokes });
    }
    return found.sort((a, b) => a.tip.id - b.tip.id);
  }

  /** True if there is any branch. */
  get forked(): boolean {
    for (const step of this.steps.values()) if (step.next.length > 1) return true;
    return false;
  }
}
