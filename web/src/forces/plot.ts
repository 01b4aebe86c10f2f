// SPDX-License-Identifier: MIT
// Plots the force of every servo tick over time and exports it as CSV. The scale fits nearly all
// ticks. Higher values are cut off and marked.
import { t } from "../base/texts";
import uPlot from "uplot";
import { robustRange, spikes, type Range } from "./robust";
import { TICK_NUMBERS } from "../connection/wire";

const rounded = new Intl.NumberFormat(undefined, { maximumSignificantDigits: 3 });

/** A curve whose spikes leave the range of its scale. */
interface Clipped {
  x: ArrayLike<number>;
  y: ArrayLike<number | null | undefined>;
  range: Range;
  colour: string;
  unit: string;
}

/**
 * Marks spikes at the edge of the plot and writes their sizes where there is room. Returns the
 * sizes of all of them, largest first.
 */
export function markSpikes(plot: uPlot, curves: Clipped[]): string[] {
  const { ctx, bbox } = plot,
    pixel = uPlot.pxRatio,
    labelled: [number, number][] = [];
  const marks = curves.flatMap((curve) => {
    const width = (plot.scales.x.max ?? 0) - (plot.scales.x.min ?? 0);
    return spikes(curve.x, curve.y, curve.range, (8 * pixel * width) / bbox.width).map((spike) => ({
      ...spike,
      curve,
      at: plot.valToPos(spike.x, "x", true),
    }));
  });
  marks.sort((a, b) => Math.abs(b.value) - Math.abs(a.value));
  ctx.save();
  ctx.font = `${10 * pixel}px system-ui, sans-serif`;
  ctx.textAlign = "left";
  ctx.textBaseline = "alphabetic";
  for (const { at, value, curve } of marks) {
    const top = value > 0,
      edge = top ? bbox.top : bbox.top + bbox.height,
      in_ = (top ? 1 : -1) * pixel;
    ctx.fillStyle = curve.colour;
    ctx.beginPath();
    ctx.moveTo(at, edge);
    ctx.lineTo(at - 4 * pixel, edge + 7 * in_);
    ctx.lineTo(at + 4 * pixel, edge + 7 * in_);
    ctx.fill();
    const words = `${rounded.format(value)} ${curve.unit}`.trim(),
      wide = ctx.measureText(words).width;
    const from =
      at + 6 * pixel + wide > bbox.left + bbox.width ? at - 6 * pixel - wide : at + 6 * pixel;
    if (labelled.some(([a, b]) => from < b + 6 * pixel && from + wide > a - 6 * pixel)) continue;
    labelled.push([from, from + wide]);
    ctx.fillText(words, from, edge + (top ? 9 : -2) * pixel);
  }
  ctx.restore();
  return marks.map(({ value, curve }) => `${rounded.format(value)} ${curve.unit}`.trim());
}

/** True if any tick has a force or a moment. */
const hasForce = (rows: Float32Array): boolean =>
  rows.some((number, i) => {
    const at = i % TICK_NUMBERS;
    return at >= 3 && at < 9 && number !== 0;
  });

const SHOWN_S = 5;
const KEPT = 600000; // ticks; ten minutes at 1 kHz

// Okabe and Ito's colours, which people with any kind of colour vision can distinguish.
const SERIES = [
  {
    label: t("plot_f"),
    about: t("plot_f_about"),
    stroke: "#d55e00",
    show: true,
    scale: "y",
    unit: "N",
  },
  {
    label: "Fx, N",
    about: t("plot_fx_about"),
    stroke: "#0072b2",
    show: false,
    scale: "y",
    unit: "N",
  },
  {
    label: "Fy, N",
    about: t("plot_fy_about"),
    stroke: "#009e73",
    show: false,
    scale: "y",
    unit: "N",
  },
  {
    label: "Fz, N",
    about: t("plot_fz_about"),
    stroke: "#cc79a7",
    show: false,
    scale: "y",
    unit: "N",
  },
  {
    label: t("plot_m"),
    about: t("plot_m_about"),
    stroke: "#56b4e9",
    show: true,
    scale: "m",
    dash: [4, 3],
    unit: "N mm",
  },
];

/** A scale that fits the visible series that use it. */
export const scaled = (scale: string, min: number) => ({
  range: (plot: uPlot): [number, number] => {
    const { low, high } = robustRange(
      plot.series.flatMap((s, i) =>
        i > 0 && s.show && (s.scale ?? "y") === scale ? [plot.data[i]] : [],
      ),
      min,
    );
    return [low, high];
  },
});

/** Axes for the time, for the force on the left, and for another scale "m" on the right. */
export function forceAxes(right: string): uPlot.Axis[] {
  const style = getComputedStyle(document.documentElement);
  const text = style.getPropertyValue("--quiet"),
    line = style.getPropertyValue("--line");
  const axis = {
    stroke: text,
    grid: { stroke: line, width: 1 },
    ticks: { stroke: line },
    font: "11px system-ui, sans-serif",
    labelFont: "12px system-ui, sans-serif",
  };
  return [
    { ...axis, label: t("axis_time"), size: 28, labelSize: 16, labelGap: 0 },
    { ...axis, label: t("axis_force"), size: 42, labelSize: 16 },
    {
      ...axis,
      label: right,
      side: 1,
      scale: "m",
      size: 42,
      labelSize: 16,
      grid: { show: false },
    },
  ];
}

/** Turns the names of the series into buttons, so that the keyboard reaches them. */
function namesAsButtons(into: HTMLElement): void {
  const names = [...into.querySelectorAll<HTMLElement>(".u-legend .u-series > *")];
  for (const [i, name] of names.entries()) {
    name.title = i > 0 ? t("plot_toggle", { about: SERIES[i - 1].about }) : "";
    name.tabIndex = 0;
    name.setAttribute("role", "button");
    name.setAttribute("aria-pressed", String(!name.parentElement!.classList.contains("u-off")));
    name.addEventListener("click", () =>
      setTimeout(() =>
        name.setAttribute("aria-pressed", String(!name.parentElement!.classList.contains("u-off"))),
      ),
    );
    name.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      name.click();
    });
  }
}

export class ForcePlot {
  paused = false;
  /** Stops all drawing. For measurements. */
  still = false;
  /** Rows of tip, force, moment, axis and side, as the studio sends them. */
  private rows: Float32Array[] = [];
  private starts: number[] = [];
  private count = 0;
  private plot: uPlot;
  private picture: HTMLElement;
  private due = false;
  private flat = false; // whether the drawn curve is flat

  constructor(
    private into: HTMLElement,
    private rate: () => number,
  ) {
    this.plot = new uPlot(
      {
        width: 354,
        height: 190,
        scales: {
          x: { time: false },
          y: scaled("y", 1),
          m: scaled("m", 10),
        },
        axes: forceAxes(t("axis_moment")),
        series: [
          { label: t("axis_time") },
          ...SERIES.map(({ label, stroke, show, scale, dash }) => ({
            label,
            stroke,
            show,
            scale,
            dash,
            width: 1.5,
          })),
        ],
        hooks: { draw: [(plot) => this.mark(plot)] },
        cursor: { drag: { x: false, y: false } },
        legend: { live: false },
      },
      [[], [], [], [], [], []],
      into,
    );
    this.picture = into.querySelector<HTMLElement>(".u-wrap")!;
    this.picture.setAttribute("role", "img");
    namesAsButtons(into);
  }

  /** Marks the spikes and lists them in the label for screen readers. */
  private mark(plot: uPlot): void {
    const shown = SERIES.map((one, i) => ({ ...one, at: i + 1 })).filter(
      ({ at }) => plot.series[at].show,
    );
    const beyond = markSpikes(
      plot,
      shown.map(({ scale, stroke, unit, at }) => {
        const { min = 0, max = 0 } = plot.scales[scale];
        return {
          x: plot.data[0],
          y: plot.data[at],
          range: { low: min, high: max },
          colour: stroke,
          unit,
        };
      }),
    );
    this.picture.setAttribute(
      "aria-label",
      beyond.length > 0
        ? t("plot_label_spikes", { spikes: beyond.slice(0, 5).join(", ") })
        : t("plot_label"),
    );
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
    // A flat line looks the same when it scrolls. So it is not drawn again, which saves the
    // battery.
    const wide = this.into.clientWidth || this.plot.width;
    if (this.flat && this.plot.width === wide && !hasForce(rows)) return;
    this.due = true;
    setTimeout(() => {
      this.due = false;
      requestAnimationFrame(() => this.draw());
    }, 50);
  }

  private draw(): void {
    const max = SHOWN_S * this.rate();
    let from = this.rows.length,
      ticks = 0;
    while (from > 0 && ticks < max) ticks += this.rows[--from].length / TICK_NUMBERS;
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
    if (this.into.clientWidth > 0 && this.plot.width !== this.into.clientWidth)
      this.plot.setSize({ width: this.into.clientWidth, height: 190 });
    this.flat = !this.rows.slice(from).some(hasForce);
    this.plot.setData(columns as uPlot.AlignedData);
  }

  clear(): void {
    this.rows = [];
    this.starts = [];
    this.count = 0;
    this.flat = false;
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
