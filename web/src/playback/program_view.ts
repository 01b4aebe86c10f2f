// SPDX-License-Identifier: MIT
// The text of a milling program, with the current line. Only the visible lines have elements, and
// the studio sends blocks of lines when they are needed. So a long program is as fast as a short one.
import { request } from "../connection/access";
import { t } from "../base/texts";

const LINE_PX = 20;
/** Browsers limit the height of an element. A longer text scrolls faster than the pointer. */
const MAX_PX = 8e6;
const BLOCK = 2000; // lines of one answer of the studio
const KEPT_BLOCKS = 16;
const AROUND = 4; // lines drawn above and below the visible ones
/** A faster change of the line cannot be read, and drawing text takes time. */
const FOLLOW_MS = 80;

export class ProgramView {
  private program = 0;
  private lines = 0;
  private current = 0; // from 1; 0: none
  private problems = new Map<number, string>(); // the text of a line's problems
  private blocks = new Map<number, string[]>();
  private asked = new Set<number>();
  private due = 0; // the timer that shows the current line
  private turn = 0; // counts programs, so that late answers are dropped
  private space = document.createElement("div");
  private rows = document.createElement("div");

  /** `go` is called with the number of a line that the user chooses. */
  constructor(
    private into: HTMLElement,
    private go: (line: number) => void,
  ) {
    this.rows.className = "rows";
    this.space.append(this.rows);
    into.append(this.space);
    into.addEventListener("scroll", () => this.draw());
    into.addEventListener("click", (event) => {
      const row = (event.target as HTMLElement).closest<HTMLElement>("[data-line]");
      if (row) this.go(Number(row.dataset.line));
    });
    // The panel may open after the line has changed.
    let height = 0;
    new ResizeObserver(() => {
      const opens = height === 0;
      height = into.clientHeight;
      if (opens) this.follow();
      else this.draw();
    }).observe(into);
  }

  /** Shows a program, from its first line on. */
  begin(program: number, lines: number): void {
    this.turn++;
    this.program = program;
    this.lines = lines;
    this.current = 0;
    this.blocks.clear();
    this.asked.clear();
    this.space.style.height = `${Math.min(MAX_PX, lines * LINE_PX)}px`;
    this.into.scrollTop = 0;
    this.draw();
  }

  setProblems(problems: Map<number, string>): void {
    this.problems = problems;
    this.draw();
  }

  /** Marks the current line and scrolls it into view. */
  setLine(line: number): void {
    if (line === this.current) return;
    this.current = line;
    this.due ||= window.setTimeout(() => {
      this.due = 0;
      this.follow();
    }, FOLLOW_MS);
  }

  private follow(): void {
    const line = this.current;
    const first = this.first(),
      shown = this.into.clientHeight / LINE_PX,
      margin = Math.min(3, shown / 4);
    if (line > 0 && !(line - 1 >= first + margin && line <= first + shown - margin))
      this.into.scrollTop = ((line - 1 - shown / 2) * LINE_PX) / this.scale;
    this.draw();
  }

  /** Lines per line of the scroll bar. */
  private get scale(): number {
    return Math.max(1, (this.lines * LINE_PX) / MAX_PX);
  }
  /** The first visible line, from 0. */
  private first(): number {
    return (this.into.scrollTop * this.scale) / LINE_PX;
  }

  private draw(): void {
    const height = this.into.clientHeight;
    if (height === 0) return;
    const first = Math.max(0, Math.floor(this.first()) - AROUND),
      last = Math.min(this.lines, Math.ceil(this.first() + height / LINE_PX) + AROUND);
    // The rows stay at their places in the visible part, also if the text scrolls faster.
    const top = this.into.scrollTop + (first - this.first()) * LINE_PX;
    this.rows.style.transform = `translateY(${Math.max(0, top)}px)`;
    const drawn: HTMLElement[] = [];
    for (let i = first; i < last; i++) drawn.push(this.row(i));
    this.rows.replaceChildren(...drawn);
  }

  private row(index: number): HTMLElement {
    const row = document.createElement("div"),
      number = document.createElement("span"),
      text = document.createElement("code"),
      line = index + 1,
      problem = this.problems.get(line);
    row.dataset.line = number.textContent = String(line);
    row.setAttribute("role", "option");
    row.setAttribute("aria-selected", String(line === this.current));
    row.classList.toggle("bad", problem !== undefined);
    if (problem) row.title = problem;
    const words = this.text(index),
      remark = words.search(/[(;]/);
    text.textContent = remark < 0 ? words : words.slice(0, remark);
    if (remark >= 0) {
      const quiet = document.createElement("i");
      quiet.textContent = words.slice(remark);
      text.append(quiet);
    }
    row.append(number, text);
    return row;
  }

  private text(index: number): string {
    const block = Math.floor(index / BLOCK),
      known = this.blocks.get(block);
    if (known) return known[index - block * BLOCK] ?? "";
    if (!this.asked.has(block)) void this.ask(block);
    return "…";
  }

  private async ask(block: number): Promise<void> {
    const { turn } = this;
    this.asked.add(block);
    try {
      const answer = await request(`/program?program=${this.program}&from=${block * BLOCK}`);
      if (turn !== this.turn) return;
      this.blocks.set(block, answer.ok ? ((await answer.json()) as string[]) : [t("no_lines")]);
      // The oldest block comes first.
      for (const old of this.blocks.keys()) {
        if (this.blocks.size <= KEPT_BLOCKS) break;
        this.blocks.delete(old);
        this.asked.delete(old);
      }
      if (turn === this.turn) this.draw();
    } catch {
      if (turn === this.turn) this.asked.delete(block);
    }
  }
}
