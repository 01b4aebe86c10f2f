// SPDX-License-Identifier: MIT
// Experiments: scenes that run by themselves, and the forces of several runs beside each other.
import uPlot from "uplot";
import { element } from "./dom";
import { write } from "./messages";

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
  rows: Float32Array; // ROW numbers a tick: time, force, moment
  shown: boolean;
}

const ROW = 7;
const MOST_RUNS = 12;
// Okabe and Ito's colours, which people with any kind of colour vision tell apart; dashed the second time round.
const COLOURS = ["#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00"];
const QUANTITIES: Record<string, { label: string; of: (r: Float32Array, i: number, most: number) => number }> = {
  force: { label: "|F| [N]", of: (r, i) => Math.hypot(r[i + 1], r[i + 2], r[i + 3]) },
  fx: { label: "Fx [N]", of: (r, i) => r[i + 1] },
  fy: { label: "Fy [N]", of: (r, i) => r[i + 2] },
  fz: { label: "Fz [N]", of: (r, i) => r[i + 3] },
  shape: { label: "|F| over its most", of: (r, i, most) => Math.hypot(r[i + 1], r[i + 2], r[i + 3]) / (most || 1) },
  moment: { label: "|M| [N mm]", of: (r, i) => Math.hypot(r[i + 4], r[i + 5], r[i + 6]) },
};

const cell = (text: string, kind = "td"): HTMLElement => {
  const made = document.createElement(kind);
  made.textContent = text;
  return made;
};
const rounded = new Intl.NumberFormat(undefined, { maximumSignificantDigits: 3 });
const escaped = (text: string): string => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

export class Experiments {
  private runs: Run[] = [];
  private plot: uPlot | null = null;

  constructor(
    private send: (message: Uint8Array) => void,
    private tell: (text: string) => void,
    private save: (name: string, what: Blob) => void,
  ) {
    element("run-form").addEventListener("submit", (event) => {
      event.preventDefault();
      void this.run();
    });
    element("scene-file").onchange = () => void this.run();
    element("compare").onclick = () => this.compare();
    element("compare-again").onclick = () => this.compare();
    element("quantity").onchange = () => this.draw();
    element("runs-csv").onclick = () => this.save("forces.csv", this.csv());
    element("runs-svg").onclick = () => this.save("forces.svg", new Blob([this.svg()], { type: "image/svg+xml" }));
    new ResizeObserver(() => element<HTMLDialogElement>("comparing").open && this.draw()).observe(element("runs-plot"));
    this.count();
  }

  /** What can be run: names of the studio's examples. */
  offer(examples: { name: string; about: string }[]): void {
    const scene = element<HTMLSelectElement>("scene"), before = scene.value;
    scene.replaceChildren(...examples.map((e) => new Option(e.about, e.name)), new Option("a scene of mine (TOML) …", ""));
    if (examples.some((e) => e.name === before)) scene.value = before;
  }

  /** What a run came to. */
  add(json: string, data: Uint8Array): void {
    const summary = JSON.parse(json) as Summary;
    if (this.runs.some((run) => run.run === summary.run)) return;
    this.runs.push({ ...summary, rows: new Float32Array(data.slice().buffer), shown: true });
    if (this.runs.length > MOST_RUNS) this.runs.shift();
    this.count();
    this.compare();
  }

  private count(): void {
    for (const id of ["compare", "compare-again"]) {
      element(id).hidden = this.runs.length === 0;
      element(id).textContent = this.runs.length === 1 ? "The run" : `Compare ${this.runs.length} runs`;
    }
  }

  private async run(): Promise<void> {
    const chosen = element<HTMLSelectElement>("scene").value, own = element<HTMLInputElement>("scene-file");
    let name = chosen, text = "";
    try {
      if (chosen) {
        text = await (await fetch(`/examples/${chosen}.toml`)).text();
      } else {
        const file = own.files?.[0];
        if (!file) return own.click();
        own.value = "";
        if (file.size > 500000) return this.tell(`${file.name} is too large for a scene`);
        name = file.name.replace(/\.toml$/, "");
        text = await file.text();
      }
    } catch {
      return this.tell("The scene did not arrive; is 'kibori studio' still running?");
    }
    this.send(write.RunExperiment({ name, scene: text, model: Number(element<HTMLSelectElement>("run-model").value), pace: Number(element<HTMLSelectElement>("pace").value) }));
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
    const rows = this.runs.map((run, i) => {
      const row = document.createElement("tr"), tick = document.createElement("input"), first = document.createElement("td"), label = document.createElement("label");
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
      row.append(first, cell(run.model), ...[run.max_force_N, run.mean_force_N, run.max_moment_Nmm, run.removed_mm3, run.step_us].map((v) => cell(rounded.format(v))));
      return row;
    });
    element("runs").replaceChildren(...rows);
    this.plot?.destroy();
    this.plot = null;
    const quantity = QUANTITIES[element<HTMLSelectElement>("quantity").value];
    const shown = this.runs.map((run, i) => ({ run, i })).filter(({ run }) => run.shown);
    const into = element("runs-plot");
    if (shown.length === 0 || into.clientWidth === 0) return;
    const style = getComputedStyle(document.documentElement);
    const axis = { stroke: style.getPropertyValue("--quiet"), grid: { stroke: style.getPropertyValue("--line"), width: 1 }, ticks: { stroke: style.getPropertyValue("--line") } };
    const tables = shown.map(({ run }) => {
      const x: number[] = [], y: number[] = [];
      for (let k = 0; k < run.rows.length; k += ROW) {
        x.push(run.rows[k]);
        y.push(quantity.of(run.rows, k, run.max_force_N));
      }
      return [x, y] as uPlot.AlignedData;
    });
    this.plot = new uPlot(
      {
        width: into.clientWidth,
        height: 260,
        scales: { x: { time: false } },
        axes: [{ ...axis, label: "s", labelSize: 16 }, { ...axis, label: quantity.label, size: 56, labelSize: 18 }],
        series: [{ label: "s" }, ...shown.map(({ run, i }) => ({ label: `${run.name}, ${run.model}`, stroke: this.colour(i), width: 1.5, spanGaps: true, points: { show: false }, ...(i >= COLOURS.length ? { dash: [6, 4] } : {}) }))],
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
      for (let k = 0; k < run.rows.length; k += ROW) lines.push(`${name},${[...run.rows.subarray(k, k + ROW)].map((v) => v.toPrecision(7)).join(",")}`);
      parts.push(lines.join("\n") + "\n");
    });
    return new Blob(parts, { type: "text/csv" });
  }

  /** The plot as a figure for a page of print. */
  private svg(): string {
    const quantity = QUANTITIES[element<HTMLSelectElement>("quantity").value];
    const shown = this.runs.map((run, i) => ({ run, i })).filter(({ run }) => run.shown);
    const width = 720, height = 400, left = 64, right = 16, top = 16, bottom = 52 + 18 * shown.length;
    let end = 0, low = 0, high = 0;
    for (const { run } of shown)
      for (let k = 0; k < run.rows.length; k += ROW) {
        end = Math.max(end, run.rows[k]);
        const v = quantity.of(run.rows, k, run.max_force_N);
        low = Math.min(low, v);
        high = Math.max(high, v);
      }
    end ||= 1;
    high = high === low ? low + 1 : high + 0.04 * (high - low);
    const total = height + bottom - 52;
    const x = (t: number): number => left + ((width - left - right) * t) / end;
    const y = (v: number): number => top + ((height - top - 52) * (high - v)) / (high - low);
    const ticks = (from: number, to: number): number[] => {
      const raw = (to - from) / 6, power = 10 ** Math.floor(Math.log10(raw)), step = power * ([1, 2, 5, 10].find((m) => m * power >= raw) ?? 10);
      const all: number[] = [];
      for (let v = Math.ceil(from / step) * step; v <= to + 1e-9 * step; v += step) all.push(Number(v.toPrecision(6)));
      return all;
    };
    const out = [`<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${total}" font-family="sans-serif" font-size="12"><rect width="${width}" height="${total}" fill="#fff"/>`];
    for (const v of ticks(low, high)) out.push(`<line x1="${left}" x2="${width - right}" y1="${y(v)}" y2="${y(v)}" stroke="#ddd"/><text x="${left - 6}" y="${y(v) + 4}" text-anchor="end">${v}</text>`);
    for (const t of ticks(0, end)) out.push(`<line x1="${x(t)}" x2="${x(t)}" y1="${top}" y2="${y(low)}" stroke="#eee"/><text x="${x(t)}" y="${y(low) + 16}" text-anchor="middle">${t}</text>`);
    out.push(`<text x="${(left + width) / 2}" y="${y(low) + 34}" text-anchor="middle">time [s]</text><text transform="translate(16 ${(top + y(low)) / 2}) rotate(-90)" text-anchor="middle">${quantity.label}</text>`);
    shown.forEach(({ run, i }, place) => {
      // As fine as can be seen: of each half unit of width the lowest and the highest.
      const points: string[] = [];
      let column = -1, least = 0, most = 0, at = 0;
      const put = (): void => {
        if (column >= 0) points.push(`${at.toFixed(1)},${y(least).toFixed(1)}`, ...(most > least ? [`${at.toFixed(1)},${y(most).toFixed(1)}`] : []));
      };
      for (let k = 0; k < run.rows.length; k += ROW) {
        const px = x(run.rows[k]), v = quantity.of(run.rows, k, run.max_force_N);
        if (Math.floor(2 * px) !== column) {
          put();
          column = Math.floor(2 * px);
          at = px;
          least = most = v;
        }
        least = Math.min(least, v);
        most = Math.max(most, v);
      }
      put();
      const look = `fill="none" stroke="${this.colour(i)}" stroke-width="1.5"${i >= COLOURS.length ? ' stroke-dasharray="6 4"' : ""}`;
      const line = height + 8 + 18 * place;
      out.push(`<polyline points="${points.join(" ")}" ${look}/><line x1="${left}" x2="${left + 28}" y1="${line}" y2="${line}" ${look}/><text x="${left + 36}" y="${line + 4}">${escaped(`${run.name}, ${run.model}`)}</text>`);
    });
    return out.join("\n") + "\n</svg>\n";
  }
}
