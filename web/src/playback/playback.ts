// SPDX-License-Identifier: MIT
// The playback of a milling job: its buttons, its time line, the program, the problems and the
// forces. The studio computes the job and moves the tool. This file shows where it is.
import { announce, ask, dialog, element, input, put, read, select } from "../base/dom";
import { t, type TextKey } from "../base/texts";
import { write, type Played, type State } from "../connection/messages";
import { JobCurve } from "./curve";
import { ProgramView } from "./program_view";

interface Collision {
  kind: "rapid" | "neck" | "shank" | "holder" | "fixture";
  program: number;
  line: number;
  tool: number;
  time: number; // the end of the move [s]
  volume_mm3: number;
}
interface Job {
  programs: { name: string; lines: number }[];
  collisions: Collision[];
  warnings: string[];
  error: string;
}

const SHOWN_PROBLEMS = 200;
const NOTHING: Job = { programs: [], collisions: [], warnings: [], error: "" };

/** Minutes, seconds and tenths. */
export function clock(seconds: number): string {
  const tenths = Math.round(10 * seconds),
    minutes = Math.floor(tenths / 600) % 60,
    hours = Math.floor(tenths / 36000),
    rest = ((tenths % 600) / 10).toFixed(1).padStart(4, "0");
  return hours > 0 ? `${hours}:${String(minutes).padStart(2, "0")}:${rest}` : `${minutes}:${rest}`;
}

const textOf = (c: Collision): string => t(`collision_${c.kind}` as TextKey, { tool: c.tool });

export class Playback {
  private job = NOTHING;
  private at: Played | null = null;
  private program = -1; // the shown one
  private followed = 0; // the program of the last report
  private seeking = false;
  private stopped = -1;
  private text: ProgramView;
  private curve: JobCurve;

  constructor(private send: (message: Uint8Array) => void) {
    this.text = new ProgramView(element("program-text"), (line) => {
      this.send(write.GoToLine({ program: this.program, line }));
      element("program-text").focus();
    });
    this.curve = new JobCurve(element("job-curve"), (time) => this.seek(time));
    element("job-play").onclick = () => this.play(!this.at?.playing);
    element("job-back").onclick = () => this.send(write.StepProgram({ forward: 0 }));
    element("job-next").onclick = () => this.send(write.StepProgram({ forward: 1 }));
    element("program-text").onkeydown = (event) => {
      const forward = ["ArrowUp", "ArrowDown"].indexOf(event.key);
      if (forward < 0) return;
      event.preventDefault();
      event.stopPropagation();
      this.send(write.StepProgram({ forward }));
    };
    for (const id of ["job-speed", "job-stops"])
      element(id).addEventListener("change", () => this.play(this.at?.playing === 1));
    const time = input("job-time");
    time.oninput = () => {
      this.seeking = true;
      this.seek(time.valueAsNumber);
    };
    time.onchange = () => (this.seeking = false);
    select("program-name").onchange = () => this.showProgram(Number(select("program-name").value));
    element("job-keep").onclick = () => ask("keeping");
    dialog("keeping").onclose = () => {
      if (dialog("keeping").returnValue === "yes")
        this.send(write.KeepProgram({ name: input("keep-name").value.trim() }));
    };
  }

  /** A job is shown. */
  begin(name: string): void {
    this.job = NOTHING;
    this.at = null;
    this.program = -1;
    this.stopped = -1;
    this.seeking = false;
    this.curve.begin();
    input("keep-name").value = name.replace(/\.[^.]*$/, "");
    input("job-time").value = "0";
    delete document.body.dataset.job;
  }

  /** The job's programs and problems. */
  set(json: string): void {
    this.job = JSON.parse(json) as Job;
    const { programs } = this.job;
    const names = select("program-name");
    if (names.options.length !== programs.length || this.program < 0)
      names.replaceChildren(...programs.map((p, i) => new Option(p.name, String(i))));
    names.disabled = programs.length < 2;
    if (this.program < 0) this.showProgram(this.at?.program ?? 0);
    this.showProblems();
  }

  show(at: Played): void {
    const before = this.at;
    this.at = at;
    if (at.program !== this.followed || !before) {
      this.followed = at.program;
      if (at.program !== this.program && this.job.programs.length > 0) this.showProgram(at.program);
    }
    if (at.program === this.program) this.text.setLine(at.line);
    const time = input("job-time");
    time.max = String(at.computed);
    time.step = String(Math.max(at.computed / 2000, 1e-3));
    if (!this.seeking) time.value = String(at.time);
    time.setAttribute(
      "aria-valuetext",
      t("job_time_about", { time: clock(at.time), all: clock(at.computed) }),
    );
    read("job-clock", `${clock(at.time)} / ${clock(at.computed)}`);
    put("job-computed", at.done ? "" : t("job_computing", { n: Math.floor(100 * at.share) }));
    const play = element("job-play");
    play.setAttribute("aria-label", t(at.playing ? "job_pause" : "job_play"));
    play.title = t(at.playing ? "job_pause" : "job_play");
    play.classList.toggle("playing", at.playing !== 0);
    if (!before) select("job-speed").value = String(at.speed);
    if (!before) input("job-stops").checked = at.stops !== 0;
    const force = at.force > 0;
    read("job-line", at.line > 0 ? String(at.line) : "–");
    read("job-tool", at.tool > 0 ? `T${at.tool}` : "–");
    read("job-move", at.line > 0 ? t(at.rapid ? "job_rapid" : "job_feed") : "–");
    read("job-force", force ? `${at.force.toFixed(at.force < 10 ? 1 : 0)} N` : "–");
    read("job-power", force ? `${at.power.toFixed(at.power < 10 ? 1 : 0)} W` : "–");
    this.curve.show(at.time, at.computed);
    if (at.computed !== before?.computed) this.markTimes();
    if (at.stopped !== this.stopped) this.showStop(at.stopped);
    document.body.dataset.job = [
      at.playing ? "playing" : "paused",
      at.done ? "done" : "computing",
      at.line,
    ].join(" ");
  }

  /** The removed volume. */
  showPiece(s: State): void {
    read("job-removed", `${(Math.round(s.removed) / 1000 + 0).toFixed(2)} cm³`);
  }

  private play(playing: boolean): void {
    this.send(
      write.PlayProgram({
        playing: playing ? 1 : 0,
        speed: Number(select("job-speed").value),
        stops: input("job-stops").checked ? 1 : 0,
      }),
    );
  }

  private seek(time: number): void {
    this.send(write.SeekProgram({ time }));
  }

  private showProgram(index: number): void {
    const program = this.job.programs[index];
    if (!program) return;
    this.program = index;
    select("program-name").value = String(index);
    this.text.begin(index, program.lines);
    this.markLines();
    if (this.at?.program === index) this.text.setLine(this.at.line);
  }

  private markLines(): void {
    const lines = new Map<number, string>();
    for (const one of this.job.collisions)
      if (one.program === this.program)
        lines.set(one.line, [lines.get(one.line), textOf(one)].filter(Boolean).join("; "));
    this.text.setProblems(lines);
  }

  /** Marks the collisions over the time line. */
  private markTimes(): void {
    const all = this.at?.computed || 1;
    element("job-marks")
      .querySelector("path")!
      .setAttribute(
        "d",
        this.job.collisions.map(({ time }) => `M${((1000 * time) / all).toFixed(1)} 0V6`).join(""),
      );
  }

  private showStop(index: number): void {
    this.stopped = index;
    const met = this.job.collisions[index];
    element("job-stopped").hidden = !met;
    for (const [i, row] of [...element("job-problems").children].entries())
      row.classList.toggle("current", i === index);
    if (!met) return;
    const text = t("job_stopped", { line: met.line, what: textOf(met) });
    put("job-stopped", text);
    announce(text);
  }

  private showProblems(): void {
    const { collisions, warnings, error } = this.job;
    this.markLines();
    put(
      "job-count",
      collisions.length === 0
        ? t("job_no_problems")
        : collisions.length === 1
          ? t("job_one_problem")
          : t("job_problems", { n: collisions.length }),
    );
    element("job-problems").replaceChildren(
      ...collisions.slice(0, SHOWN_PROBLEMS).map((one) => this.problem(one)),
    );
    this.markTimes();
    element("job-error").hidden = error === "";
    put("job-error", error);
    element("job-warnings").hidden = warnings.length === 0;
    element("job-warning-list").replaceChildren(
      ...warnings.map((text) => {
        const item = document.createElement("li");
        item.textContent = text;
        return item;
      }),
    );
    this.stopped = -1;
    this.showStop(this.at?.stopped ?? -1);
  }

  private problem(one: Collision): HTMLElement {
    const item = document.createElement("li"),
      button = document.createElement("button"),
      place = document.createElement("strong");
    const name = this.job.programs.length > 1 ? `${this.job.programs[one.program]?.name} ` : "";
    place.textContent = t("job_line", { line: `${name}${one.line}` });
    button.append(place, ` ${textOf(one)}`);
    button.onclick = () => this.seek(one.time);
    item.append(button);
    return item;
  }
}
