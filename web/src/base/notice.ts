// SPDX-License-Identifier: MIT
// The line of text that reports events to the user.
import { element } from "./dom";

/** `trouble`: screen readers announce it at once. */
export function notify(text: string, forSeconds = 8, trouble = false): void {
  const box = element("notice");
  box.setAttribute("role", trouble ? "alert" : "status");
  box.textContent = text;
  if (forSeconds < Infinity) setTimeout(() => clearNotice(text), 1000 * forSeconds);
}

/** Removes the notice if it still shows this text. */
export function clearNotice(text: string): void {
  const box = element("notice");
  if (box.textContent === text) box.textContent = "";
}
