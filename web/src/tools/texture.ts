// SPDX-License-Identifier: MIT
// The user's own picture as the texture of brushes. The studio reads the file.
import { t } from "../base/texts";
import { input, select } from "../base/dom";
import { notify } from "../base/notice";
import { write } from "../connection/messages";

/** Max file size. It equals the limit of a message [bytes]. */
const MAX_BYTES = 1_000_000;

export class Texture {
  private file: { name: string; data: Uint8Array } | null = null;
  private sent = false;

  constructor(
    private send: (message: Uint8Array) => void,
    /** Called when another picture was chosen. */
    private changed: () => void,
  ) {
    input("texture").addEventListener("change", () => void this.take());
  }

  /** Forgets what was sent, for another document or after another page held the tool. */
  begin(): void {
    this.sent = false;
  }
  /** Sends the picture if the brush has it. */
  choose(): void {
    if (select("alpha").value !== "picture" || !this.file || this.sent) return;
    this.sent = true;
    this.send(write.ChooseTexture(this.file));
  }

  private async take(): Promise<void> {
    const file = input("texture").files?.[0];
    if (!file) return;
    if (file.size > MAX_BYTES) return notify(t("texture_too_large", { file: file.name }));
    this.file = {
      name: file.name.slice(-60), // only for messages
      data: new Uint8Array(await file.arrayBuffer()),
    };
    this.sent = false;
    this.changed();
  }
}
