// SPDX-License-Identifier: MIT
// Experiments: scenes that run without a hand, and the forces of several runs in one plot.
import uPlot from "uplot";
import { element } from "../base/dom";
import { save } from "../base/files";
import { notify } from "../base/notice";
import { figure } from "./figure";
import { write } from "../connection/messages";
import { MODEL_NOTES } from "../connection/kinds";
import { markSpikes } from "./plot";
import { robustRange } from "./robust";

interface Mark {
  label: string;
  time_s: number;
}
interface Summary {
  run: number;
  mean_force_N: number;
  name: string;
  model: string;
  finished: boolean;
  ticks: number;
  removed_mm3: number;
  max_force_N: number;
  max_moment_Nmm: number;
  step_us: number;
  marks: Mark[];
}
interface Run extends Summary {
  rows: Float32Array; // ROW numbers per tick: time, force, moment
  shown: boolean;
}

const ROW = 7;
const MAX_RUNS = 12;
// Okabe and Ito's colours, which people with any colour vision can distinguish. Further curves
// repeat them, dashed.
const COLOURS = ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
const QUANTITIES: Record<
  string,
  { label: string; unit: string; of: (r: Float32Array, i: number, max: number) => number }
> = {
  force: {
    label: "Force |F| [N]",
    unit: "N",
    of: (r, i) => Math.hypot(r[i + 1], r[i + 2], r[i + 3]),
  },
  fx: { label: "Force Fx [N]", unit: "N", of: (r, i) => r[i + 1] },
  fy: { label: "Force Fy [N]", unit: "N", of: (r, i) => r[i + 2] },
  fz: { label: "Force Fz [N]", unit: "N", of: (r, i) => r[i + 3] },
  shape: {
    label: "Force |F| over its largest [1]",
    unit: "",
    of: (r, i, max) => Math.hypot(r[i + 1], r[i + 2], r[i + 3]) / (max || 1),
  },
  moment: {
    label: "Moment |M| [N mm]",
    unit: "N mm",
    of: (r, i) => Math.hypot(r[i + 4], r[i + 5], r[i + 6]),
  },
};

const cell = (text: string, kind = "td"): HTMLElement => {
  const made = document.createElement(kind);
  made.textContent = text;
  return made;
};
const rounded = new Intl.NumberFormat(undefined, { maximumSignificantDigits: 3 });

export class Experiments {
  private runs: Run[] = [];
  private plot: uPlot | null = null;

  constructor(private send: (message: Uint8Array) => void) {
    element("run-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.run();
    });
    element("scene-file").onchange = () => void this.run();
    element("compare").onclick = () => this.compare();
    element("compare-again").onclick = () => this.compare();
    element("quantity").onchange = () => this.draw();
    element("runs-csv").onclick = () => save("forces.csv", this.csv());
    element("runs-svg").onclick = () =>
      save("forces.svg", new Blob([this.svg()], { type: "image/svg+xml" }));
    new ResizeObserver(() => element<HTMLDialogElement>("comparing").open && this.draw()).observe(
      element("runs-plot"),
    );
    this.count();
  }

  /** The experiments: names of the studio's examples. */
  offer(examples: { name: string; about: string }[]): void {
    const scene = element<HTMLSelectElement>("scene"),
      before = scene.value;
    scene.replaceChildren(
      ...examples.map((e) => new Option(e.about, e.name)),
      new Option("a scene of mine (TOML) …", ""),
    );
    if (examples.some((e) => e.name === before)) scene.value = before;
  }

  /** Adds the result of a run. */
  add(json: string, data: Uint8Array): void {
    const summary = JSON.parse(json) as Summary;
    if (this.runs.some((run) => run.run === summary.run)) return;
    this.runs.push({ ...summary, rows: new Float32Array(data.slice().buffer), shown: true });
    if (this.runs.length > MAX_RUNS) this.runs.shift();
    this.count();
    this.compare();
  }

  private count(): void {
    for (const id of ["compare", "compare-again"]) {
      element(id).hidden = this.runs.length === 0;
      element(id).textContent =
        this.runs.length === 1 ? "The run" : `Compare ${this.runs.length} runs`;
    }
  }

  private async run(): Promise<void> {
    const chosen = element<HTMLSelectElement>("scene").value,
      own = element<HTMLInputElement>("scene-file");
    let name = chosen,
      text = "";
    try {
      if (chosen) {
        text = await (await fetch(`/examples/${chosen}.toml`)).text();
      } else {
        const file = own.files?.[0];
        if (!file) return own.click();
        own.value = "";
        if (file.size > 500000) return notify(`${file.name} is too large for a scene`);
        name = file.name.replace(/\.toml$/, "");
        text = await file.text();
      }
    } catch {
      return notify("The scene did not arrive; is 'kibori studio' still running?");
    }
    const model = element<HTMLSelectElement>("run-model").value,
      pace = Number(element<HTMLSelectElement>("pace").value);
    this.send(write.RunExperiment({ name, scene: text, model, pace }));
  }

  private compare(): void {
    const dialog = element<HTMLDialogElement>("comparing");
    if (!dialog.open) dialog.showModal();
    this.draw();
  }

  private colour(i: number): string {
    return COLOURS[i % COLOURS.length];
  }

  private draw(): void {
    element("runs").replaceChildren(...this.runs.map((run, i) => this.row(run, i)));
    element("runs-models").replaceChildren(...this.notes().map((says) => cell(says, "p")));
    this.drawPlot();
  }
  private row(run: Run, i: number): HTMLElement {
    const row = document.createElement("tr"),
      tick = document.createElement("input"),
      first = document.createElement("td"),
      label = document.createElement("label");
    tick.type = "checkbox";
    tick.checked = run.shown;
    tick.onchange = () => {
      run.shown = tick.checked;
      this.draw();
    };
    const line = document.createElement("span");
    line.className = "line";
    line.style.borderTop = `3px ${i < COLOURS.length ? "solid" : "dashed"} ${this.colour(i)}`;
    label.append(tick, line, run.name + (run.finished ? "" : " (stopped)"));
    first.append(label);
    const numbers = [
      run.max_force_N,
      run.mean_force_N,
      run.max_moment_Nmm,
      run.removed_mm3,
      run.step_us,
    ];
    row.append(first, cell(run.model), ...numbers.map((v) => cell(rounded.format(v))));
    return row;
  }

  private drawPlot(): void {
    this.plot?.destroy();
    this.plot = null;
    const quantity = this.quantity(),
      shown = this.shown();
    const into = element("runs-plot");
    if (shown.length === 0 || into.clientWidth === 0) return;
    const style = getComputedStyle(document.documentElement);
    const axis = {
      stroke: style.getPropertyValue("--quiet"),
      grid: { stroke: style.getPropertyValue("--line"), width: 1 },
      ticks: { stroke: style.getPropertyValue("--line") },
      font: "11px system-ui, sans-serif",
      labelFont: "12px system-ui, sans-serif",
    };
    const curves = shown.map(({ run }) => this.curve(run));
    const tables = curves.map(({ x, y }) => [x, y] as uPlot.AlignedData);
    const range = robustRange(
      curves.map(({ y }) => y),
      0,
    );
    this.plot = new uPlot(
      {
        width: into.clientWidth,
        height: 260,
        scales: { x: { time: false }, y: { range: [range.low, range.high] } },
        axes: [
          { ...axis, label: "Time [s]", size: 32, labelSize: 18, labelGap: 0 },
          { ...axis, label: quantity.label, size: 56, labelSize: 18 },
        ],
        hooks: {
          draw: [
            (plot) =>
              markSpikes(
                plot,
                curves.map((curve, k) => ({
                  ...curve,
                  range,
                  colour: this.colour(shown[k].i),
                  unit: quantity.unit,
                })),
              ),
          ],
        },
        series: [
          { label: "Time [s]" },
          ...shown.map(({ run, i }) => ({
            label: `${run.name}, ${run.model}`,
            stroke: this.colour(i),
            width: 1.5,
            spanGaps: true,
            points: { show: false },
            ...(i >= COLOURS.length ? { dash: [6, 4] } : {}),
          })),
        ],
        legend: { show: false },
      },
      tables.length === 1 ? tables[0] : uPlot.join(tables),
      into,
    );
  }

  private csv(): Blob {
    const parts = ["run,scene,model,time_s,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n"];
    this.runs.forEach((run, i) => {
      if (!run.shown) return;
      const name = `${i + 1},"${run.name.replaceAll('"', '""')}",${run.model}`;
      const lines: string[] = [];
      for (let k = 0; k < run.rows.length; k += ROW)
        lines.push(
          `${name},${[...run.rows.subarray(k, k + ROW)].map((v) => v.toPrecision(7)).join(",")}`,
        );
      parts.push(lines.join("\n") + "\n");
    });
    return new Blob(parts, { type: "text/csv" });
  }

  /** The plot as a figure for print. */
  private svg(): string {
    const quantity = this.quantity();
    const curves = this.shown().map(({ run, i }) => ({
      name: `${run.name}, ${run.model}`,
      colour: this.colour(i),
      dashed: i >= COLOURS.length,
      ...this.curve(run),
    }));
    return figure(curves, quantity.label, this.notes());
  }

  private quantity(): (typeof QUANTITIES)[string] {
    return QUANTITIES[element<HTMLSelectElement>("quantity").value];
  }
  private shown(): { run: Run; i: number }[] {
    return this.runs.map((run, i) => ({ run, i })).filter(({ run }) => run.shown);
  }
  private curve(run: Run): { x: number[]; y: number[] } {
    const quantity = this.quantity(),
      x: number[] = [],
      y: number[] = [];
    for (let k = 0; k < run.rows.length; k += ROW) {
      x.push(run.rows[k]);
      y.push(quantity.of(run.rows, k, run.max_force_N));
    }
    return { x, y };
  }
  /** A note on each force model in the plot. */
  private notes(): string[] {
    const models = new Set(this.shown().map(({ run }) => run.model));
    return Object.entries(MODEL_NOTES)
      .filter(([model]) => models.has(model))
      .map(([, says]) => says);
  }
}
