// SPDX-License-Identifier: MIT
// Carves the piece again with more or less detail, into a new document: every stroke of its history
// with another pitch. The panel estimates triangles and memory before.
import { t } from "../base/texts";
import { element, put, select } from "../base/dom";
import { write } from "../connection/messages";

const MB = 1e6;

export class Detail {
  private pitch = 1; // of the open document [mm]
  private memory = 0; // [bytes]; 0: unknown
  private document = "";
  /** What to ask for once the open document is closed. */
  private waits: { document: string; pitch: number } | null = null;

  constructor(
    private parts: {
      send: (message: Uint8Array) => void;
      /** The number of triangles of the piece. */
      triangles: () => number;
      /** Asks the studio for the memory. remember() receives the answer. */
      ask: () => void;
      /** Whether this page may close the document. */
      may: () => boolean;
    },
  ) {
    element("detail-box").addEventListener("toggle", () => this.show());
    select("detail-factor").addEventListener("change", () => this.show());
    element("detail-again").onclick = () => {
      if (!parts.may()) return;
      this.waits = { document: this.document, pitch: this.wanted() };
      parts.send(write.Leave());
    };
  }

  /** A document is open. */
  begin(document: string, pitch: number, mayChange: boolean): void {
    this.document = document;
    this.pitch = pitch;
    this.memory = 0;
    this.waits = null;
    element<HTMLButtonElement>("detail-again").disabled = !mayChange;
    this.show();
  }
  /** The document is closed. */
  closed(): void {
    if (this.waits) this.parts.send(write.ChangeDetail(this.waits));
    this.waits = null;
  }
  /** The piece has changed. */
  changed(): void {
    this.show(false);
  }
  remember(memory: number): void {
    this.memory = memory;
    this.show(false);
  }

  private wanted(): number {
    return this.pitch / Number(select("detail-factor").value);
  }
  /** Numbers of triangles and bytes grow with the area in cells. */
  private show(asks = true): void {
    if (!element<HTMLDetailsElement>("detail-box").open) return;
    if (asks) this.parts.ask();
    const now = this.parts.triangles(),
      factor = Number(select("detail-factor").value) ** 2;
    const line = (pitch: number, share: number): string =>
      t("detail_line", {
        pitch: pitch.toPrecision(3),
        triangles: Math.round(now * share).toLocaleString(),
        memory: this.memory > 0 ? Math.ceil((this.memory * share) / MB).toLocaleString() : "–",
      });
    put("detail-now", line(this.pitch, 1));
    put("detail-then", line(this.wanted(), factor));
  }
}
