// SPDX-License-Identifier: MIT
// The dialog that exports the piece as a file.
import { ask, dialog, input, select } from "../base/dom";
import { save } from "../base/files";
import { notify } from "../base/notice";
import { request } from "../connection/access";

async function exportAs(title: string, format: string, tolerance: string): Promise<void> {
  try {
    const answer = await request(`/export?format=${format}&tolerance=${tolerance}`);
    if (answer.ok) save(`${title}.${format}`, await answer.blob());
    else notify(await answer.text(), 8, true);
  } catch {
    notify("The file did not arrive; is 'kibori studio' still running?", 8, true);
  }
}

export const askExport = (): void => ask("exporting");

/** `title`: the file's name without its ending. */
export function listenForExport(title: () => string): void {
  dialog("exporting").onclose = () => {
    if (dialog("exporting").returnValue === "yes")
      void exportAs(title(), select("format").value, input("tolerance").value || "0");
  };
}
