// SPDX-License-Identifier: MIT
// The force over time, every servo tick of it, and as CSV.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { TICK_NUMBERS } from "./wire";

const SHOWN_S = 5;
const KEPT = 600000; // ten minutes

export class ForcePlot {
  paused = false;
  /** Nothing is drawn. */
  still = false;
  /** Rows of tip, force, moment, axis, as the studio sends them. */
  private rows: Float32Array[] = [];
  private starts: number[] = [];
  private count = 0;
  private plot: uPlot;
  private due = false;

  constructor(
    private into: HTMLElement,
    private rate: () => number,
  ) {
    const style = getComputedStyle(document.documentElement);
    const text = style.getPropertyValue("--quiet"), line = style.getPropertyValue("--line");
    const axis = { stroke: text, grid: { stroke: line, width: 1 }, ticks: { stroke: line } };
    // Okabe and Ito's colours, which people with any kind of colour vision tell apart.
    this.plot = new uPlot(
      {
        width: 354, height: 190,
        scales: {
          x: { time: false },
          y: { range: (_, least, most) => [Math.min(0, 1.1 * least), Math.max(1, 1.1 * most)] },
          m: { range: (_, least, most) => [Math.min(0, 1.1 * least), Math.max(10, 1.1 * most)] },
        },
        axes: [{ ...axis, label: "s", labelSize: 14, labelGap: 0 }, { ...axis, label: "N", size: 40, labelSize: 14 }, { ...axis, label: "N mm", side: 1, scale: "m", size: 40, labelSize: 14, grid: { show: false } }],
        series: [
          { label: "s" },
          { label: "|F|", stroke: "#d55e00", width: 1.5 },
          { label: "Fx", stroke: "#0072b2", show: false },
          { label: "Fy", stroke: "#009e73", show: false },
          { label: "Fz", stroke: "#cc79a7", show: false },
          { label: "|M|", stroke: "#56b4e9", scale: "m", dash: [4, 3] },
        ],
        cursor: { drag: { x: false, y: false } },
        legend: { live: false },
      },
      [[], [], [], [], [], []],
      into,
    );
    // Its names are buttons for keys, too.
    for (const name of into.querySelectorAll<HTMLElement>(".u-legend .u-series > *")) {
      name.tabIndex = 0;
      name.setAttribute("role", "button");
      name.setAttribute("aria-pressed", String(!name.parentElement!.classList.contains("u-off")));
      name.addEventListener("click", () => setTimeout(() => name.setAttribute("aria-pressed", String(!name.parentElement!.classList.contains("u-off")))));
      name.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        name.click();
      });
    }
  }

  add(start: number, rows: Float32Array): void {
    this.starts.push(start);
    this.rows.push(rows);
    this.count += rows.length / TICK_NUMBERS;
    while (this.count > KEPT) {
      this.starts.shift();
      this.count -= this.rows.shift()!.length / TICK_NUMBERS;
    }
    if (this.paused || this.still || this.due) return;
    this.due = true;
    setTimeout(() => {
      this.due = false;
      requestAnimationFrame(() => this.draw());
    }, 50);
  }

  private draw(): void {
    const most = SHOWN_S * this.rate();
    let from = this.rows.length, ticks = 0;
    while (from > 0 && ticks < most) ticks += this.rows[--from].length / TICK_NUMBERS;
    const columns: number[][] = [[], [], [], [], [], []];
    for (let b = from; b < this.rows.length; b++) {
      const r = this.rows[b];
      for (let i = 0; i < r.length; i += TICK_NUMBERS) {
        columns[0].push((this.starts[b] + i / TICK_NUMBERS) / this.rate());
        columns[1].push(Math.hypot(r[i + 3], r[i + 4], r[i + 5]));
        for (let k = 0; k < 3; k++) columns[2 + k].push(r[i + 3 + k]);
        columns[5].push(Math.hypot(r[i + 6], r[i + 7], r[i + 8]));
      }
    }
    if (this.into.clientWidth > 0 && this.plot.width !== this.into.clientWidth) this.plot.setSize({ width: this.into.clientWidth, height: 190 });
    this.plot.setData(columns as uPlot.AlignedData);
  }

  clear(): void {
    this.rows = [];
    this.starts = [];
    this.count = 0;
  }

  csv(): Blob {
    const parts = ["time_s,x_mm,y_mm,z_mm,fx_n,fy_n,fz_n,mx_nmm,my_nmm,mz_nmm\n"];
    this.rows.forEach((r, b) => {
      const lines: string[] = [];
      for (let i = 0; i < r.length; i += TICK_NUMBERS) {
        const cells = [((this.starts[b] + i / TICK_NUMBERS) / this.rate()).toFixed(4)];
        for (let k = 0; k < 9; k++) cells.push(r[i + k].toPrecision(7));
        lines.push(cells.join(","));
      }
      parts.push(lines.join("\n") + "\n");
    });
    return new Blob(parts, { type: "text/csv" });
  }
}
