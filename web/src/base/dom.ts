// SPDX-License-Identifier: MIT
// Finds the elements of index.html by their ids.

export const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;
export const input = (id: string): HTMLInputElement => element<HTMLInputElement>(id);
export const select = (id: string): HTMLSelectElement => element<HTMLSelectElement>(id);
export const dialog = (id: string): HTMLDialogElement => element<HTMLDialogElement>(id);

/** Opens a form. Its `returnValue` is then "yes", or something else if it was cancelled. */
export function ask(id: string): void {
  const box = dialog(id);
  box.returnValue = "";
  for (const button of box.querySelectorAll<HTMLButtonElement>("button[value=no]"))
    button.onclick = () => box.close();
  box.showModal();
}

/**
 * Writes a text into an element, unless it is there already. Writing it again would lay out and
 * draw the page again.
 */
export function put(id: string, text: string): void {
  const at = element(id);
  if (at.textContent !== text) at.textContent = text;
}

let saying = 0;
/**
 * Announces a text to screen readers once it no longer changes. Of many changes, only the last is
 * announced.
 */
export function announce(text: string): void {
  window.clearTimeout(saying);
  saying = window.setTimeout(() => put("announced", text), 300);
}

const READ_EVERY_MS = 200; // as often as a reader can follow a number
const numbers = new Map<string, string>();
let timer = 0;
/** Writes a number that changes continuously. Such numbers are written together. */
export function read(id: string, text: string): void {
  numbers.set(id, text);
  timer ||= window.setTimeout(() => {
    timer = 0;
    for (const [at, last] of numbers) put(at, last);
    numbers.clear();
  }, READ_EVERY_MS);
}
