// SPDX-License-Identifier: MIT
// The plot of force and power over the time of a milling job, with the shown moment. A click goes to
// its time.
import uPlot from "uplot";
import { request } from "../connection/access";
import { t } from "../base/texts";
import { forceAxes, scaled } from "../forces/plot";

const PARTS = 600; // of the time; the studio sends the largest force of each
const AGAIN_MS = 700; // while the job is computed
const HEIGHT = 170;
// Okabe and Ito's colours, as in the plot of a hand's force.
const FORCE = "#d55e00",
  POWER = "#0072b2";

interface Curve {
  seconds: number;
  force: number[];
  power: number[];
}

export class JobCurve {
  private plot: uPlot;
  private now = document.createElement("div");
  private time = 0;
  private turn = 0;
  private fetched = -1; // time that the curve covers [s]
  private asking = false;

  constructor(
    private into: HTMLElement,
    go: (seconds: number) => void,
  ) {
    this.now.className = "now";
    this.plot = new uPlot(
      {
        width: 320,
        height: HEIGHT,
        scales: { x: { time: false }, y: scaled("y", 1), m: scaled("m", 1) },
        axes: forceAxes(t("axis_power")),
        series: [
          { label: t("axis_time") },
          { label: t("plot_job_force"), stroke: FORCE, scale: "y", width: 1.5 },
          { label: t("plot_job_power"), stroke: POWER, scale: "m", width: 1.5, dash: [4, 3] },
        ],
        cursor: { drag: { x: false, y: false }, y: false },
        legend: { live: false },
      },
      [[], [], []],
      into,
    );
    const picture = into.querySelector<HTMLElement>(".u-wrap")!;
    picture.setAttribute("role", "img");
    picture.setAttribute("aria-label", t("plot_job_label"));
    this.plot.over.append(this.now);
    this.plot.over.addEventListener("click", (event) =>
      go(Math.max(0, this.plot.posToVal(event.offsetX, "x"))),
    );
    new ResizeObserver(() => this.fit()).observe(into);
    this.begin();
  }

  begin(): void {
    this.turn++;
    this.fetched = -1;
    this.asking = false;
    this.plot.setData([[], [], []]);
    this.now.hidden = true;
  }

  /** Moves the mark of the shown time, and fetches the curve if more of the job is computed. */
  show(time: number, computed: number): void {
    this.time = time;
    if (computed !== this.fetched && computed > 0 && !this.asking) void this.ask(computed);
    this.mark();
  }

  private fit(): void {
    const wide = this.into.clientWidth;
    if (wide > 0 && wide !== this.plot.width) this.plot.setSize({ width: wide, height: HEIGHT });
    this.mark();
  }

  private mark(): void {
    this.now.hidden = this.fetched <= 0;
    if (this.fetched > 0)
      this.now.style.transform = `translateX(${this.plot.valToPos(this.time, "x")}px)`;
  }

  private async ask(computed: number): Promise<void> {
    const { turn } = this;
    this.asking = true;
    try {
      const answer = await request(`/curve?parts=${PARTS}`);
      const curve = answer.ok ? ((await answer.json()) as Curve) : null;
      if (turn !== this.turn) return;
      if (curve) {
        const times = curve.force.map((_, i) => ((i + 0.5) * curve.seconds) / PARTS);
        this.plot.setData([times, curve.force, curve.power]);
        this.fetched = computed;
        this.mark();
      }
    } catch {
      // The next report asks again.
    }
    setTimeout(() => {
      if (turn === this.turn) this.asking = false;
    }, AGAIN_MS);
  }
}
