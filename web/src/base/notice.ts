// SPDX-License-Identifier: MIT
// The line of text that reports to the person what happened.
import { element } from "./dom";

/** trouble: read out at once to who listens to the page. */
export function notify(text: string, forSeconds = 8, trouble = false): void {
  const box = element("notice");
  box.setAttribute("role", trouble ? "alert" : "status");
  box.textContent = text;
  if (forSeconds < Infinity) setTimeout(() => clearNotice(text), 1000 * forSeconds);
}

/** Removes the notice if it still says this. */
export function clearNotice(text: string): void {
  const box = element("notice");
  if (box.textContent === text) box.textContent = "";
}
