// SPDX-License-Identifier: MIT
// Makes a slider row with a number that can be typed. Screen readers read its name and unit. For
// sizes, equal distances on the slider are equal ratios. The slider keeps its id and its value, so
// other parts of the page can use it like any slider.
import { t } from "../base/texts";
/**
 * The meaning of a slider's value. "linear": the shown number. "ratio": the same, on a slider of
 * equal ratios. "exponent": the logarithm of the shown number.
 */
export type Scale = "linear" | "ratio" | "exponent";

const VALUE = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value")!;
const WRONG_MS = 8000; // how long an error about typed text is shown

/** The number as text, without insignificant digits. */
const written = (x: number): string => String(Number(x.toFixed(Math.abs(x) < 1 ? 3 : 2)));

class NumberRow {
  private typed = document.createElement("input");
  private unit = document.createElement("span");
  private more = document.createElement("span");
  private wrong = document.createElement("p");
  private ratio: HTMLInputElement | null = null;
  private sliding = false;
  private timer = 0;

  /**
   * `label` contains a name, an output and a slider. Other parts write the output: a number, its
   * unit, and after a comma its meaning.
   */
  constructor(
    label: HTMLLabelElement,
    private slider: HTMLInputElement,
    private scale: Scale,
  ) {
    const { typed, unit, more, wrong } = this;
    const row = document.createElement("div"),
      name = document.createElement("label"),
      shown = label.querySelector("output")!;
    row.className = label.className;
    row.id = label.id;
    row.title = label.title;
    row.hidden = label.hidden;
    while (label.firstChild !== shown) name.append(label.firstChild!);
    name.id = `${slider.id}-label`;
    typed.type = "number";
    typed.step = "any";
    typed.id = name.htmlFor = `${slider.id}-typed`;
    typed.setAttribute("aria-describedby", (unit.id = `${slider.id}-unit`));
    slider.setAttribute("aria-labelledby", name.id);
    shown.classList.add("heard");
    shown.setAttribute("aria-live", "off");
    unit.className = "unit";
    more.className = "more";
    wrong.className = "wrong";
    wrong.setAttribute("role", "alert");
    row.append(name, typed, unit, slider, more, shown, wrong);
    if (scale === "ratio") row.insertBefore(this.byRatio(name.id), more);
    label.replaceWith(row);

    // Key actions and messages set the slider's value without an event.
    Object.defineProperty(slider, "value", {
      get: () => VALUE.get!.call(slider) as string,
      set: (value: string) => {
        VALUE.set!.call(slider, value);
        this.show();
      },
    });
    slider.addEventListener("input", () => this.show());
    new MutationObserver(() => this.show()).observe(slider, { attributeFilter: ["min", "max"] });
    new MutationObserver(() => this.explain(shown.textContent ?? "")).observe(shown, {
      childList: true,
      characterData: true,
      subtree: true,
    });
    typed.addEventListener("change", () => this.take(name.textContent!.trim()));
    typed.addEventListener("keydown", (event) => event.key === "Escape" && this.show());
    this.explain(shown.textContent ?? "");
    this.show();
  }

  /**
   * A slider on which equal distances are equal ratios. The original slider keeps the value and is
   * hidden.
   */
  private byRatio(labelledBy: string): HTMLInputElement {
    const { slider } = this,
      ratio = (this.ratio = document.createElement("input"));
    ratio.type = "range";
    ratio.min = "0";
    ratio.max = "1";
    ratio.step = "any";
    ratio.setAttribute("aria-labelledby", labelledBy);
    slider.step = "0.01";
    slider.tabIndex = -1;
    slider.classList.add("unseen");
    slider.setAttribute("aria-hidden", "true");
    const put = (kind: string): void => {
      const low = Number(slider.min),
        value = low * (Number(slider.max) / low) ** Number(VALUE.get!.call(ratio));
      const fine = value < 2 ? 0.05 : value < 10 ? 0.1 : value < 50 ? 0.5 : 1;
      this.sliding = true;
      slider.value = String(Math.round(value / fine) * fine);
      slider.dispatchEvent(new Event(kind, { bubbles: true }));
      this.sliding = false;
    };
    ratio.addEventListener("input", () => put("input"));
    ratio.addEventListener("change", () => put("change"));
    return ratio;
  }

  private number(of: string): number {
    return this.scale === "exponent" ? 10 ** Number(of) : Number(of);
  }

  private show(): void {
    const { slider, typed, ratio } = this,
      now = this.number(slider.value);
    typed.min = written(this.number(slider.min));
    typed.max = written(this.number(slider.max));
    typed.value = written(now);
    if (!ratio || this.sliding) return;
    const low = Number(slider.min);
    ratio.value = String(Math.log(now / low) / Math.log(Number(slider.max) / low));
  }

  /** Splits "4.0 mm, Ks 0.25/mm" into the unit and the explanation. */
  private explain(shown: string): void {
    const [first, ...rest] = shown.split(", "),
      unit = /^[-\d.]+\s*(.*)$/.exec(first)?.[1] ?? "";
    this.unit.textContent = unit;
    this.more.textContent = rest.join(", ");
    for (const at of [this.slider, this.ratio]) at?.setAttribute("aria-valuetext", shown);
  }

  private take(name: string): void {
    const { slider, typed, wrong } = this,
      wanted = typed.valueAsNumber,
      unit = this.unit.textContent;
    const low = Number(typed.min),
      high = Number(typed.max),
      fits = wanted >= low && wanted <= high;
    window.clearTimeout(this.timer);
    wrong.textContent = fits
      ? ""
      : t("number_limits", {
          name,
          low,
          high,
          unit: unit ?? "",
          now: written(this.number(slider.value)),
        });
    this.timer = window.setTimeout(() => (wrong.textContent = ""), WRONG_MS);
    if (!fits) return this.show();
    if (written(this.number(slider.value)) === written(wanted)) return;
    slider.value = String(this.scale === "exponent" ? Math.log10(wanted) : wanted);
    for (const kind of ["input", "change"])
      slider.dispatchEvent(new Event(kind, { bubbles: true }));
  }
}

/** Gives every slider of the page a number row. `scales` lists the nonlinear ones by id. */
export function makeNumberRows(scales: Record<string, Scale>): void {
  for (const label of document.querySelectorAll<HTMLLabelElement>("label.row")) {
    const slider = label.querySelector<HTMLInputElement>("input[type=range]");
    if (slider) new NumberRow(label, slider, scales[slider.id] ?? "linear");
  }
}
