// SPDX-License-Identifier: MIT
// The search field over tools and brushes. Enter takes the first match.
import { element, input } from "../base/dom";

export class Palette {
  private field = input("find");

  constructor() {
    this.field.addEventListener("input", () => this.show());
    this.field.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.clear();
      else if (event.key === "Enter") this.take();
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  focus(): void {
    this.field.focus();
    this.field.select();
  }

  private get buttons(): HTMLElement[] {
    return [...element("choices").querySelectorAll<HTMLElement>(".icons label")];
  }
  private show(): void {
    const wanted = this.field.value.trim().toLowerCase();
    const { buttons } = this;
    for (const button of buttons)
      button.hidden = !`${button.title} ${button.textContent}`.toLowerCase().includes(wanted);
    for (const id of ["shapes", "brushes"])
      element(id).hidden = !element(id).querySelector("label:not([hidden])");
    element("found-none").hidden = buttons.some((button) => !button.hidden);
  }
  private clear(): void {
    this.field.value = "";
    this.show();
    element("view").focus();
  }
  private take(): void {
    const first = this.buttons.find((button) => !button.hidden)?.querySelector("input");
    if (first && !first.closest("label")!.classList.contains("lit")) first.click();
    this.clear();
  }
}
