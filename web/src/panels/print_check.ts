// SPDX-License-Identifier: MIT
// The panel that shows printing faults. The studio colours the active body. The panel explains
// the colours and lets the user set the limits for thin walls and overhangs.
import { t } from "../base/texts";
import { element, input, put } from "../base/dom";
import { write, type PrintFaults } from "../connection/messages";

const area = (mm2: number): string =>
  mm2 >= 100 ? `${(mm2 / 100).toPrecision(3)} cm²` : `${Number(mm2.toPrecision(2))} mm²`;

export class PrintCheck {
  private checking = false;

  constructor(
    private send: (message: Uint8Array) => void,
    /** Switches off all other colourings. */
    private others: () => void,
  ) {
    input("checking").onchange = () => this.toggle(input("checking").checked);
    for (const id of ["thin-wall", "overhang"])
      input(id).addEventListener("change", () => this.ask());
  }

  /** True if the surface is shown in colours that are not its own. */
  get inColours(): boolean {
    return this.checking;
  }
  /** Ends the check for another document or another colouring. */
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
      part > 0 ? `${area(part)} (${((100 * part) / all).toPrecision(2)} %)` : t("no_faults");
    put("faults-overhang", share(overhang));
    put("faults-thin", share(thin));
    put("faults-thinnest", thinnest > 0 ? `${thinnest.toPrecision(2)} mm` : "–");
    put("faults-loose", pieces > 1 ? `${pieces - 1}` : t("no_faults"));
  }

  private ask(): void {
    const within = (id: string, low: number, high: number, otherwise: number): number => {
      const typed = Number(input(id).value);
      const value = typed >= low && typed <= high ? typed : otherwise;
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
