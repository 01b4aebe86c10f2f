// SPDX-License-Identifier: MIT
// Access to the elements of index.html by their ids, and functions that write text into them.

export const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;
export const input = (id: string): HTMLInputElement => element<HTMLInputElement>(id);
export const select = (id: string): HTMLSelectElement => element<HTMLSelectElement>(id);
export const dialog = (id: string): HTMLDialogElement => element<HTMLDialogElement>(id);

/** Opens a form. Its `returnValue` is "yes" if the user confirms, and empty if the user cancels. */
export function ask(id: string): void {
  const box = dialog(id);
  box.returnValue = "";
  for (const button of box.querySelectorAll<HTMLButtonElement>("button[value=no]"))
    button.onclick = () => box.close();
  box.showModal();
}

/**
 * Writes a text into an element. An unchanged text is not written again, because writing makes the
 * browser lay out and draw the page again.
 */
export function put(id: string, text: string): void {
  const at = element(id);
  if (at.textContent !== text) at.textContent = text;
}

let announcement = 0;
/** Announces a text to screen readers after 300 ms. A newer text replaces a pending one. */
export function announce(text: string): void {
  window.clearTimeout(announcement);
  announcement = window.setTimeout(() => put("announced", text), 300);
}

const READ_EVERY_MS = 200; // 5 Hz; an eye cannot follow a number that changes faster
const numbers = new Map<string, string>();
let timer = 0;
/**
 * Shows a number that changes all the time. All such numbers are written together, every
 * READ_EVERY_MS.
 */
export function read(id: string, text: string): void {
  numbers.set(id, text);
  timer ||= window.setTimeout(() => {
    timer = 0;
    for (const [at, last] of numbers) put(at, last);
    numbers.clear();
  }, READ_EVERY_MS);
}
