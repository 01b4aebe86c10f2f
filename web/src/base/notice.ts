// SPDX-License-Identifier: MIT
// The line of text that reports to the user what happened.
import { element } from "./dom";

/**
 * Shows a notice for `forSeconds` seconds. A screen reader reads it at once if `urgent` is set.
 */
export function notify(text: string, forSeconds = 8, urgent = false): void {
  const box = element("notice");
  box.setAttribute("role", urgent ? "alert" : "status");
  box.textContent = text;
  if (forSeconds < Infinity) setTimeout(() => clearNotice(text), 1000 * forSeconds);
}

/** Removes the notice if it still shows this text. */
export function clearNotice(text: string): void {
  const box = element("notice");
  if (box.textContent === text) box.textContent = "";
}
