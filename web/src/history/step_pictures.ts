// SPDX-License-Identifier: MIT
// Takes a small picture of each new step once the view is at rest, for the history and the
// document. One camera takes them all.
import { write } from "../connection/messages";
import type { View } from "../view/view";
import type { History } from "./history";

const WAIT_MS = 600;
const TRIES = 20;
const WIDTH = 128,
  HEIGHT = 96; // [pixels]
const MAX_BYTES = 65536; // limit of the studio

export class StepPictures {
  private step = 0; // the current step

  constructor(
    private view: View,
    private history: History,
    private send: (message: Uint8Array) => void,
    /**
     * True if the view shows the piece unchanged and at rest; true if this page may store pictures.
     */
    private when: { rests: () => boolean; may: () => boolean },
  ) {}

  /** The current step has changed; 0: there is none. */
  goTo(step: number): void {
    this.step = step;
    if (step !== 0) this.soon(step);
  }

  private soon(step: number, tries = TRIES): void {
    setTimeout(async () => {
      if (step !== this.step || !this.when.may() || !this.history.wants(step) || tries === 0)
        return;
      if (!this.when.rests()) return this.soon(step, tries - 1);
      const png = await this.view.thumbnail(WIDTH, HEIGHT);
      if (!png || step !== this.step) return;
      this.history.setPicture(step, png);
      const bytes = new Uint8Array(await png.arrayBuffer());
      if (bytes.length <= MAX_BYTES) this.send(write.KeepThumbnail({ step, png: bytes }));
    }, WAIT_MS);
  }
}
