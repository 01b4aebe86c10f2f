// SPDX-License-Identifier: MIT
// The check for printing. The studio colours the active body. This panel explains the colours and
// sets the limits for thin walls and overhanging faces.
import { element, input, put } from "../base/dom";
import { write, type PrintFaults } from "../connection/messages";

const area = (mm2: number): string =>
  mm2 >= 100 ? `${(mm2 / 100).toPrecision(3)} cm²` : `${Number(mm2.toPrecision(2))} mm²`;

export class PrintCheck {
  private checking = false;

  constructor(
    private send: (message: Uint8Array) => void,
    /** Ends the check when another display of colours begins, or none. */
    private others: () => void,
  ) {
    input("checking").onchange = () => this.toggle(input("checking").checked);
    for (const id of ["thin-wall", "overhang"])
      input(id).addEventListener("change", () => this.ask());
  }

  /** True if the surface is shown in false colours. */
  get inColours(): boolean {
    return this.checking;
  }
  /** Resets for another document or another display of colours. */
  leave(): void {
    if (!this.checking) return;
    this.checking = false;
    this.draw();
  }
  toggle(on = !this.checking): void {
    this.checking = on;
    if (on) this.others();
    this.ask();
    this.draw();
  }
  /** Shows the numbers. */
  show({ overhang, thin, area: all, thinnest, pieces }: PrintFaults): void {
    const share = (part: number): string =>
      part > 0 ? `${area(part)} (${((100 * part) / all).toPrecision(2)} %)` : "none";
    put("faults-overhang", share(overhang));
    put("faults-thin", share(thin));
    put("faults-thinnest", thinnest > 0 ? `${thinnest.toPrecision(2)} mm` : "–");
    put("faults-loose", pieces > 1 ? `${pieces - 1}` : "none");
  }

  private ask(): void {
    const within = (id: string, low: number, high: number, otherwise: number): number => {
      const said = Number(input(id).value);
      const value = said >= low && said <= high ? said : otherwise;
      input(id).value = String(value);
      return value;
    };
    this.send(
      write.ShowFaults({
        shown: this.checking ? 1 : 0,
        wall: within("thin-wall", 0.01, 1000, 1),
        overhang: within("overhang", 0, 90, 45),
      }),
    );
  }
  private draw(): void {
    input("checking").checked = this.checking;
    element("faults").hidden = !this.checking;
    for (const id of ["overhang", "thin", "thinnest", "loose"]) put(`faults-${id}`, "–");
  }
}
