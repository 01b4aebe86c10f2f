// SPDX-License-Identifier: MIT
// Plots the force of every servo tick over time, and exports it as CSV. The scale fits all but a
// few ticks: spikes are cut off and marked.
import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { robustRange, spikes, type Range } from "./robust";
import { TICK_NUMBERS } from "../connection/wire";

const rounded = new Intl.NumberFormat(undefined, { maximumSignificantDigits: 3 });

/** A curve whose spikes leave the range of a scale. */
interface Clipped {
  x: ArrayLike<number>;
  y: ArrayLike<number | null | undefined>;
  range: Range;
  colour: string;
  unit: string;
}

/**
 * Marks spikes at the edge of the plot, with their sizes if there is room. Returns all sizes.
 */
export function markSpikes(plot: uPlot, curves: Clipped[]): string[] {
  const { ctx, bbox } = plot,
    pixel = uPlot.pxRatio,
    told: [number, number][] = [];
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
    if (told.some(([a, b]) => from < b + 6 * pixel && from + wide > a - 6 * pixel)) continue;
    told.push([from, from + wide]);
    ctx.fillText(words, from, edge + (top ? 9 : -2) * pixel);
  }
  ctx.restore();
  return marks.map(({ value, curve }) => `${rounded.format(value)} ${curve.unit}`.trim());
}

/** True if any tick has a force or a moment. */
const felt = (rows: Float32Array): boolean =>
  rows.some((number, i) => {
    const at = i % TICK_NUMBERS;
    return at >= 3 && at < 9 && number !== 0;
  });

const SHOWN_S = 5;
const KEPT = 600000; // ten minutes of ticks

// Okabe and Ito's colours, which people with any colour vision can distinguish.
const SERIES = [
  {
    label: "|F|: size of the force, N",
    about: "How large the force on the hand is, in newtons: an apple weighs about one",
    stroke: "#d55e00",
    show: true,
    scale: "y",
    unit: "N",
  },
  {
    label: "Fx, N",
    about: "The force's part along x, to the right in the view from the front, in newtons",
    stroke: "#0072b2",
    show: false,
    scale: "y",
    unit: "N",
  },
  {
    label: "Fy, N",
    about: "The force's part along y, away from you in the view from the front, in newtons",
    stroke: "#009e73",
    show: false,
    scale: "y",
    unit: "N",
  },
  {
    label: "Fz, N",
    about: "The force's part along z, upwards, in newtons",
    stroke: "#cc79a7",
    show: false,
    scale: "y",
    unit: "N",
  },
  {
    label: "|M|: size of the moment, N mm",
    about: "How strongly the force wants to turn the tool about its tip, in newton millimetres",
    stroke: "#56b4e9",
    show: true,
    scale: "m",
    dash: [4, 3],
    unit: "N mm",
  },
];

/** A scale that fits its visible series. */
const scaled = (scale: string, min: number) => ({
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

function axes(): uPlot.Axis[] {
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
    { ...axis, label: "Time [s]", size: 28, labelSize: 16, labelGap: 0 },
    { ...axis, label: "Force [N]", size: 42, labelSize: 16 },
    {
      ...axis,
      label: "Moment [N mm]",
      side: 1,
      scale: "m",
      size: 42,
      labelSize: 16,
      grid: { show: false },
    },
  ];
}

/** The names of the series are buttons, so that the keyboard reaches them. */
function namesAsButtons(into: HTMLElement): void {
  const names = [...into.querySelectorAll<HTMLElement>(".u-legend .u-series > *")];
  for (const [i, name] of names.entries()) {
    name.title = i > 0 ? `${SERIES[i - 1].about}; click to show or hide` : "";
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
  /** If true, nothing is drawn. */
  still = false;
  /** Adds rows of tip, force, moment and axis, as the studio sends them. */
  private rows: Float32Array[] = [];
  private starts: number[] = [];
  private count = 0;
  private plot: uPlot;
  private picture: HTMLElement;
  private due = false;
  private flat = false; // last drawn state

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
        axes: axes(),
        series: [
          { label: "Time [s]" },
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

  /** Marks spikes, and describes them for screen readers. */
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
      `Force and moment over the last seconds${beyond.length > 0 ? `; beyond the scale: ${beyond.slice(0, 5).join(", ")}` : ""}`,
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
    // A moving flat line shows nothing new. Drawing it would only drain the battery.
    const wide = this.into.clientWidth || this.plot.width;
    if (this.flat && this.plot.width === wide && !felt(rows)) return;
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
    this.flat = !this.rows.slice(from).some(felt);
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
