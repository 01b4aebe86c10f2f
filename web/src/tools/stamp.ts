// SPDX-License-Identifier: MIT
// The stamp that is held: letters, a picture or a mesh. The studio makes it and tells its triangles.
import { element, input, put, select } from "../base/dom";
import { notify } from "../base/notice";
import { write } from "../connection/messages";
import { setStamp } from "./tools";

/** Letters and pictures are asked for when nothing was typed or slid for so long [ms]. */
const STILL_MS = 250;
/** What a file may have, as a message may [bytes]. */
const MOST_BYTES = 1_000_000;
const ENDINGS = ["", ".png", ".stl,.ply,.obj,.off,.3mf,.glb,.gltf"];

/** How large it is [mm]: how high or wide; how deep it goes; and how long letters are. */
interface Held {
  size: number;
  depth: number;
  length: number;
}

/** As large as a stamp may be [mm]. */
const within = (mm: number): number => Math.min(1000, Math.max(0.1, mm));

export class Stamp {
  private file: { name: string; data: Uint8Array } | null = null;
  private held: Held = { size: 0, depth: 0, length: 0 };
  private sent = "";
  private timer = 0;
  private asked = false;

  constructor(
    private send: (message: Uint8Array) => void,
    /** Another distance from one place to the next. */
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

  /** How far it is from one place to the next [mm]; 0: it is pressed in once. */
  get every(): number {
    return Number(input("every").value);
  }
  private get what(): number {
    return Number(select("stamp-what").value);
  }

  /** What a size [mm] means. */
  sizeOf(size: number): string {
    return `${size.toFixed(1)} mm ${this.what === 0 ? "high" : "wide"}`;
  }

  /** Another document, or another page held the tool: what was sent is not known any more. */
  begin(): void {
    this.sent = "";
  }

  choose(held: Held): void {
    this.held = held;
    this.show();
    if (!this.asked) this.send(write.AskFonts());
    this.asked = true;
    // One that was not held before, at once: who picked it up may press already.
    if (this.sent === "") this.order();
    else this.soon();
  }
  /** Another tool is held. */
  leave(): void {
    clearTimeout(this.timer);
    this.sent = "";
  }

  /** The fonts that are installed where the studio runs. */
  showFonts(json: string): void {
    const fonts = JSON.parse(json) as string[],
      held = select("stamp-font").value;
    select("stamp-font").replaceChildren(...fonts.map((name) => new Option(name, name)));
    select("stamp-font").value = fonts.includes(held) ? held : (fonts[0] ?? "");
  }
  /** How many the studio has made, for tests. */
  made = 0;
  /** Its triangles. */
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
    put("every-out", every > 0 ? `${every.toFixed(0)} mm` : "0 mm, once");
  }
  private async take(): Promise<void> {
    const file = input("stamp-file").files?.[0];
    if (!file) return;
    if (file.size > MOST_BYTES) {
      notify(`${file.name} has more than a megabyte; a stamp's file must be smaller.`);
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
        name: file?.name.slice(-60) ?? "", // of which the ending matters
        data: what === 0 ? new Uint8Array() : file!.data,
      }),
    );
  }
}
