// SPDX-License-Identifier: MIT
// The dialog for a milling job whose files do not state everything: its stock, its tool, its pitch.
import { t } from "../base/texts";
import { request } from "../connection/access";
import { dialog, element, input, put, select } from "../base/dom";
import { notify } from "../base/notice";

/** What the studio knows about the files. `stock`: six numbers of a block that fits, or none. */
export interface Job {
  kind: "program";
  import: string;
  name: string;
  programs: string[];
  asks: { stock: boolean; tool: boolean; pitch: boolean };
  stock: number[];
  longest_mm: number; // of a stock that is known
  diameter_mm: number;
  materials: string[];
  material: string;
}

const CORNERS = ["x0", "y0", "z0", "x1", "y1", "z1"];
const CELLS = 256; // of the longest side, as 'kibori mill' has it
const FINEST = 1024; // cells that the page can show

export class JobDialog {
  private job: Job | null = null;
  private pitched = false; // the user has stated the pitch

  /** `address` makes the address of a request of this page. */
  constructor(private address: (path: string, about: Record<string, string>) => string) {
    const box = dialog("milling-job");
    box.querySelector<HTMLButtonElement>("button[value=no]")!.onclick = () => box.close("no");
    box.onclose = () => !box.open && box.returnValue !== "yes" && this.drop();
    box.querySelector("form")!.onsubmit = (event) => {
      event.preventDefault();
      if (!this.sound()) return;
      box.close("yes");
      void this.make(this.chosen());
    };
    for (const id of CORNERS) input(`job-${id}`).oninput = () => this.suggestPitch();
    input("job-pitch").oninput = () => (this.pitched = true);
  }

  /** Closes the dialog. Returns whether a job was waiting. */
  leave(): boolean {
    const waited = dialog("milling-job").open;
    this.job = null;
    dialog("milling-job").close("yes");
    return waited;
  }

  /** Begins a job, and asks before if the files leave something open. */
  open(job: Job): void {
    this.job = job;
    this.pitched = false;
    const { stock, tool, pitch } = job.asks;
    if (!stock && !tool && !pitch) return void this.make({});
    put("milling-job-title", t("job_title", { name: job.programs[0] }));
    for (const part of dialog("milling-job").querySelectorAll<HTMLElement>("[data-asks]")) {
      part.hidden = !part.dataset.asks!.split(" ").some((one) => job.asks[one as "stock"]);
      for (const field of part.querySelectorAll("input")) field.disabled = part.hidden;
    }
    CORNERS.forEach((id, i) => (input(`job-${id}`).value = String(job.stock[i] ?? 0)));
    input("job-diameter").value = String(job.diameter_mm);
    select("job-material").replaceChildren(
      ...job.materials.map((name) => new Option(name, name, name === job.material)),
    );
    select("job-material").value = job.material;
    this.suggestPitch();
    this.showError("");
    this.reopen();
  }

  private corners(): number[] {
    return CORNERS.map((id) => input(`job-${id}`).valueAsNumber);
  }
  private longest(): number {
    if (!this.job?.asks.stock) return this.job?.longest_mm ?? 0;
    const at = this.corners();
    return Math.max(...[0, 1, 2].map((axis) => at[axis + 3] - at[axis]));
  }
  private suggestPitch(): void {
    const longest = this.longest();
    if (this.pitched || !(longest > 0)) return;
    input("job-pitch").value = String(Number((longest / CELLS).toPrecision(2)));
  }

  /** True if the numbers make a job. Otherwise the dialog says what to change. */
  private sound(): boolean {
    const at = this.corners(),
      pitch = input("job-pitch").valueAsNumber;
    const wrong = [0, 1, 2].findIndex((axis) => !(at[axis] < at[axis + 3]));
    if (this.job?.asks.stock && wrong >= 0) {
      this.showError(t("job_corners", { axis: "xyz"[wrong] }));
      return false;
    }
    const finest = this.longest() / FINEST;
    if (pitch < finest) {
      this.showError(t("job_too_fine", { pitch: finest.toPrecision(2) }));
      return false;
    }
    return true;
  }

  private chosen(): Record<string, string> {
    const { asks } = this.job!;
    const about: Record<string, string> = {
      pitch: input("job-pitch").value,
      material: select("job-material").value,
    };
    if (asks.stock) for (const id of CORNERS) about[id] = input(`job-${id}`).value;
    if (asks.tool) {
      about.diameter = input("job-diameter").value;
      about.ball = select("job-shape").value === "ball" ? "1" : "0";
    }
    return about;
  }

  private reopen(): void {
    dialog("milling-job").returnValue = "";
    if (!dialog("milling-job").open) dialog("milling-job").showModal();
  }
  private showError(text: string): void {
    put("milling-job-trouble", text);
    element("milling-job-trouble").hidden = text === "";
  }

  private async make(about: Record<string, string>): Promise<void> {
    const job = this.job!;
    try {
      const answer = await request(this.address("make", { import: job.import, ...about }), {
        method: "POST",
      });
      if (this.job !== job || answer.ok) return;
      const why = await answer.text();
      if (answer.status === 404 || Object.keys(about).length === 0) return notify(why);
      this.showError(why);
      this.reopen();
    } catch {
      if (this.job === job) notify(t("no_answer"));
    }
  }

  private drop(): void {
    const job = this.job;
    this.job = null;
    if (job)
      void request(this.address("import", { import: job.import }), { method: "DELETE" }).catch(
        () => undefined,
      );
  }
}
