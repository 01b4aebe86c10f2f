// SPDX-License-Identifier: MIT
// The stamp: letters, a picture or a mesh. The studio makes it and sends its triangles.
import { t } from "../base/texts";
import { element, input, put, select } from "../base/dom";
import { notify } from "../base/notice";
import { MESHES } from "../connection/kinds";
import { write } from "../connection/messages";
import { setStamp } from "./tools";

/** The page requests letters and pictures after this time without input [ms]. */
const STILL_MS = 250;
/** Max file size. It equals the limit of a message [bytes]. */
const MAX_BYTES = 1_000_000;
const ENDINGS = ["", ".png", MESHES];

/** Size [mm]: height or width, pressing depth, and length of letters. */
interface Held {
  size: number;
  depth: number;
  length: number;
}

/** Limits a stamp's size [mm]. */
const within = (mm: number): number => Math.min(1000, Math.max(0.1, mm));

export class Stamp {
  private file: { name: string; data: Uint8Array } | null = null;
  private held: Held = { size: 0, depth: 0, length: 0 };
  private sent = "";
  private timer = 0;
  private requested = false;

  constructor(
    private send: (message: Uint8Array) => void,
    /** Called when the spacing changes. */
    private changed: () => void,
  ) {
    select("stamp-what").addEventListener("change", () => {
      this.file = null;
      input("stamp-file").value = "";
      this.changed();
    });
    for (const id of ["stamp-text", "stamp-dark"])
      input(id).addEventListener("input", () => this.soon());
    select("stamp-font").addEventListener("change", () => this.soon());
    input("stamp-file").addEventListener("change", () => void this.take());
    input("every").addEventListener("input", () => {
      this.show();
      this.changed();
    });
    this.show();
  }

  /** Spacing of the stamp along a stroke [mm]. 0: it is pressed in once. */
  get every(): number {
    return Number(input("every").value);
  }
  private get what(): number {
    return Number(select("stamp-what").value);
  }

  /** The meaning of a size [mm] as text. */
  sizeOf(size: number): string {
    return t(this.what === 0 ? "stamp_high" : "stamp_wide", { size: size.toFixed(1) });
  }

  /** Forgets what was sent, for another document or after another page held the tool. */
  begin(): void {
    this.sent = "";
  }

  choose(held: Held): void {
    this.held = held;
    this.show();
    if (!this.requested) this.send(write.AskFonts());
    this.requested = true;
    // A newly held stamp is sent at once, because the user may press immediately.
    if (this.sent === "") this.order();
    else this.soon();
  }
  /** The user holds another tool. */
  leave(): void {
    clearTimeout(this.timer);
    this.sent = "";
  }

  /** Shows the fonts that are installed on the studio's machine. */
  showFonts(json: string): void {
    const fonts = JSON.parse(json) as string[],
      held = select("stamp-font").value;
    select("stamp-font").replaceChildren(...fonts.map((name) => new Option(name, name)));
    select("stamp-font").value = fonts.includes(held) ? held : (fonts[0] ?? "");
  }
  /** How many stamps the studio has made. For tests. */
  made = 0;
  /** Shows the stamp's triangles. */
  showShape(vertices: Uint8Array, triangles: Uint8Array): void {
    this.made++;
    setStamp(new Float32Array(vertices.slice().buffer), new Uint32Array(triangles.slice().buffer));
  }

  private show(): void {
    const { what, every } = this;
    element("stamp-letters").hidden = what !== 0;
    element("stamp-files").hidden = what === 0;
    element("stamp-darks").hidden = what !== 1;
    input("stamp-file").accept = ENDINGS[what];
    put("every-out", every > 0 ? `${every.toFixed(0)} mm` : t("stamp_once"));
  }
  private async take(): Promise<void> {
    const file = input("stamp-file").files?.[0];
    if (!file) return;
    if (file.size > MAX_BYTES) {
      notify(t("stamp_too_large", { file: file.name }));
      return;
    }
    this.file = { name: file.name, data: new Uint8Array(await file.arrayBuffer()) };
    this.sent = "";
    this.soon();
  }
  private soon(): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.order(), STILL_MS);
  }
  private order(): void {
    const { what, file } = this,
      { size } = this.held,
      depth = what === 1 ? this.held.depth : this.held.length,
      text = input("stamp-text").value,
      font = select("stamp-font").value,
      dark = input("stamp-dark").checked ? 1 : 0;
    if (what === 0 ? text.trim() === "" : file === null) return;
    const ordered = [what, size, depth, text, font, dark, file?.name].join("\n");
    if (ordered === this.sent) return;
    this.sent = ordered;
    this.send(
      write.ChooseStamp({
        what,
        text: what === 0 ? text : "",
        font,
        size: within(size),
        depth: within(depth),
        invert: dark,
        name: file?.name.slice(-60) ?? "", // only the extension matters
        data: what === 0 ? new Uint8Array() : file!.data,
      }),
    );
  }
}
