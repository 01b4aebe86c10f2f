// SPDX-License-Identifier: MIT
// The dialog that turns a file into a stock. The studio analyses the file, and the dialog shows the
// result and its options. The file waits at the studio until the user confirms or cancels.
import { t } from "../base/texts";
import * as THREE from "three";
import { request } from "../connection/access";
import { dialog, element, input, put, select } from "../base/dom";
import { clearNotice, notify } from "../base/notice";
import {
  ImportView,
  meshShape,
  readPicture,
  reliefShape,
  volumeShape,
  type Picture,
} from "./import_view";
import { JobDialog, type Job } from "./job_dialog";
import type { Material } from "../view/wood";
import type { Vec3 } from "../base/vec3";

interface Mesh {
  kind: "mesh";
  triangles: number;
  size_mm: Vec3; // as in the file
  area_mm2: number;
  unit_mm: number; // of the file's numbers
  unit: string;
  unit_why: string;
  longest_mm: number;
  up: string;
  front: string;
  up_why: string;
  repairs: string[];
}
interface Relief {
  kind: "relief";
  width: number;
  height: number; // height of the picture
}
interface Volume {
  kind: "volume";
  size_mm: Vec3; // of its grid
  area_mm2: number;
  labels: { label: number; name: string; volume_mm3: number; material: number }[];
}
type Shape = (Mesh | Relief | Volume) & { import: string; ray_bytes: number; free_bytes: number };
type Brought = Shape | Job;

const UNITS: [string, string, number][] = [
  ["mm", t("millimetres"), 1],
  ["cm", t("centimetres"), 10],
  ["in", t("inches"), 25.4],
  ["m", t("metres"), 1000],
];
const UPS = ["x", "-x", "y", "-y", "z", "-z"];
const ROOM = 1.2; // the lattice extends a tenth beyond the piece on each side

const along = (name: string): Vec3 => {
  const v: Vec3 = [0, 0, 0];
  v["xyz".indexOf(name.slice(-1))] = name.startsWith("-") ? -1 : 1;
  return v;
};
const named = (v: Vec3): string => UPS.find((name) => along(name).every((x, i) => x === v[i]))!;
const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const less = (v: Vec3): Vec3 => v.map((x) => (x === 0 ? 0 : -x)) as Vec3;
/** As in kibori/geometry/orientation.h. */
const usualFront = (up: string): string => (up.endsWith("y") ? "z" : "-y");
/** The rows of the rotation from the file's axes to the piece's axes. */
const rows = (up: string, front: string): [Vec3, Vec3, Vec3] => [
  cross(along(up), along(front)),
  less(along(front)),
  along(up),
];

const short = (x: number): string => String(Number(x.toPrecision(x >= 100 ? 4 : 3)));
const rounded = new Intl.NumberFormat("en", { maximumSignificantDigits: 2 });
const many = (x: number): string =>
  x >= 1e6 ? t("million", { n: (x / 1e6).toPrecision(2) }) : rounded.format(x).replace(",", " ");

export class Importer {
  private page = ""; // the studio's name for this page
  private materials: Material[] = [];
  private view: ImportView | null = null;
  private turns = 0; // counts uploads
  private reading: Promise<void> = Promise.resolve(); // the studio reads one file at a time
  private brought: Shape | null = null;
  private jobs = new JobDialog((path, about) => this.address(path, about));
  private shape: THREE.BufferGeometry | null = null;
  private picture: Picture | null = null;
  private up = "z";
  private front = "-y";
  private longest = 80; // [mm], not rounded
  // The longest side [mm] of the piece that receives the body; 0: no document is open.
  private within = 0;

  constructor() {
    const box = dialog("importing");
    select("import-up").replaceChildren(...UPS.map((name) => new Option(name.toUpperCase(), name)));
    box.querySelector<HTMLButtonElement>("button[value=no]")!.onclick = () => box.close("no");
    // The event arrives a little after the dialog was closed. By then, it may be open again.
    box.onclose = () => !box.open && box.returnValue !== "yes" && this.drop();
    box.querySelector("form")!.onsubmit = (event) => {
      event.preventDefault();
      box.close("yes");
      void this.make();
    };
    select("import-unit").onchange = () => this.chooseUnit(select("import-unit").value);
    input("import-longest").oninput = () => {
      const value = input("import-longest").valueAsNumber;
      if (!(value > 0)) return;
      this.longest = value;
      if (this.brought?.kind === "mesh") select("import-unit").value = this.unitOf(value);
      this.show();
    };
    select("import-up").onchange = () =>
      this.turnTo(select("import-up").value, usualFront(select("import-up").value));
    for (const button of element("import-turns").querySelectorAll("button"))
      button.onclick = () => this.turnAbout("XYZ".indexOf(button.value));
    for (const id of ["import-height", "import-base", "import-invert"])
      input(id).oninput = () => this.show();
    select("import-wood").onchange = () => this.showWood();
    select("import-detail").onchange = () => this.showDetail();
  }

  /** Enables imports. `page` is the studio's name for this page. */
  offer(page: string, materials: Material[]): void {
    if (page !== this.page && this.leave()) notify(t("file_lost"));
    this.page = page;
    this.materials = materials;
  }

  /** Closes the dialog. Returns whether a file was waiting. */
  leave(): boolean {
    const waited = dialog("importing").open || this.jobs.leave();
    this.turns++;
    this.brought = null;
    dialog("importing").close("yes");
    return waited;
  }

  /**
   * Uploads a file and opens the dialog. A newer file replaces one that is still being read.
   * `within` is the longest side [mm] of the piece that receives the body. 0: the file becomes a
   * document, or a milling job that may have more files: `all`.
   */
  bring(file: File, within = 0, all = [file]): Promise<void> {
    const turn = ++this.turns,
      bringing = t("reading_file", { file: file.name });
    this.within = within;
    notify(bringing);
    this.reading = this.reading.then(() => this.read(file, all, turn, bringing));
    return this.reading;
  }

  private async read(file: File, all: File[], turn: number, bringing: string): Promise<void> {
    if (turn !== this.turns) return;
    const about: Record<string, string> = { name: file.name };
    if (all.length > 1) about.files = JSON.stringify(all.map(({ name, size }) => ({ name, size })));
    try {
      const answer = await request(this.address("import", about), {
        method: "POST",
        body: all.length > 1 ? new Blob(all) : file,
      });
      if (turn !== this.turns) return;
      clearNotice(bringing);
      if (answer.status === 202) return; // the file was a document, and it is opened
      if (!answer.ok) {
        const why = await answer.text();
        return why ? notify(why) : undefined;
      }
      const brought = (await answer.json()) as Brought;
      if (brought.kind === "program") return this.jobs.open(brought);
      const look = await request(this.address("import", { import: brought.import }));
      if (!look.ok) return notify(await look.text());
      const data = await look.arrayBuffer();
      if (turn === this.turns) this.ask(brought, data, file.name);
    } catch {
      if (turn === this.turns) notify(t("file_missing", { file: file.name }));
    }
  }

  private address(path: string, about: Record<string, string>): string {
    return `/${path}?${new URLSearchParams({ page: this.page, ...about }).toString().replaceAll("+", "%20")}`;
  }

  private ask(brought: Shape, data: ArrayBuffer, name: string): void {
    this.brought = brought;
    this.shape?.dispose();
    this.shape = this.picture = null;
    put("import-title", t("import_file", { file: name }));
    input("import-name").value = name.replace(/\.[^.]*$/, "");
    for (const part of dialog("importing").querySelectorAll<HTMLElement>("[data-of], [data-for]")) {
      const { of, for: use } = part.dataset;
      part.hidden =
        (of !== undefined && !of.split(" ").includes(brought.kind)) ||
        (use !== undefined && (use === "body") !== this.within > 0);
      if (of === undefined) continue;
      // A disabled field is not validated, so hidden fields cannot block the form.
      for (const field of part.querySelectorAll("input")) field.disabled = part.hidden;
    }
    const wood = select("import-wood");
    wood.replaceChildren(...this.materials.map((m, i) => new Option(m.name, String(i))));
    this.showError("");
    if (brought.kind === "mesh") {
      this.shape = meshShape(data);
      const units = UNITS.map(
        ([unit, text, mm]) => new Option(`${text} (${short(this.inUnit(mm))} mm)`, unit),
      );
      select("import-unit").replaceChildren(...units, new Option(t("no_unit"), "fit"));
      select("import-unit").value = brought.unit;
      this.longest = brought.longest_mm;
      put("import-unit-why", brought.unit_why);
      if (this.within > 0 && this.longest > this.within) {
        this.longest = 0.9 * this.within;
        select("import-unit").value = "fit";
        put("import-unit-why", t("made_smaller"));
      }
      put("import-up-why", brought.up_why);
      [this.up, this.front] = [brought.up, brought.front];
      select("import-up").value = this.up;
    } else if (brought.kind === "volume") {
      this.shape = volumeShape(data);
      this.longest = Math.max(...brought.size_mm);
      this.askLabels(brought);
    } else {
      this.picture = readPicture(data);
      this.longest = 80;
      input("import-height").value = input("import-base").value = "5";
      input("import-invert").checked = false;
    }
    this.showLongest();
    this.reopen();
    this.show(true);
    this.showWood();
  }
  /** Asks for the material of each label. */
  private askLabels(volume: Volume): void {
    element("import-labels").replaceChildren(
      ...volume.labels.map(({ label, name, volume_mm3, material }) => {
        const row = document.createElement("label"),
          choice = document.createElement("select");
        row.className = "pair";
        row.append(`${name}, ${short(volume_mm3)} mm³ `, choice);
        choice.dataset.label = String(label);
        choice.append(...this.materials.map((m, i) => new Option(m.name, String(i))));
        choice.value = String(material);
        choice.onchange = () => this.showWood();
        return row;
      }),
    );
  }
  private labels(): HTMLSelectElement[] {
    return [...element("import-labels").querySelectorAll("select")];
  }
  private reopen(): void {
    dialog("importing").returnValue = "";
    dialog("importing").showModal();
    this.view ??= new ImportView(element<HTMLCanvasElement>("import-view"));
  }

  /** The longest side [mm] if the file's unit is `mm` millimetres. */
  private inUnit(mm: number): number {
    const { size_mm, unit_mm } = this.brought as Mesh;
    return (Math.max(...size_mm) / unit_mm) * mm;
  }
  private unitOf(longest: number): string {
    return (
      UNITS.find(([, , mm]) => Math.abs(this.inUnit(mm) - longest) <= 1e-4 * longest)?.[0] ?? "fit"
    );
  }
  private chooseUnit(name: string): void {
    const unit = UNITS.find(([known]) => known === name);
    this.longest = unit ? this.inUnit(unit[2]) : 80;
    this.showLongest();
    this.show();
  }
  private showLongest(): void {
    input("import-longest").value = short(this.longest);
  }

  private turnTo(up: string, front: string): void {
    [this.up, this.front] = [up, front];
    select("import-up").value = up;
    this.show();
  }
  private turnAbout(axis: number): void {
    const u = (axis + 1) % 3,
      v = (axis + 2) % 3,
      old = rows(this.up, this.front),
      turned = rows(this.up, this.front);
    [turned[u], turned[v]] = [less(old[v]), old[u]];
    this.turnTo(named(turned[2]), named(less(turned[1])));
  }

  /** The resulting size [mm]. */
  private size(): Vec3 {
    const brought = this.brought!;
    if (brought.kind === "mesh") {
      const scale = this.longest / Math.max(...brought.size_mm);
      return rows(this.up, this.front).map(
        (row) => scale * Math.abs(row.reduce((sum, x, i) => sum + x * brought.size_mm[i], 0)),
      ) as Vec3;
    }
    if (brought.kind === "volume") return brought.size_mm;
    const max = Math.max(brought.width, brought.height);
    return [
      (this.longest * brought.width) / max,
      (this.longest * brought.height) / max,
      input("import-height").valueAsNumber + input("import-base").valueAsNumber,
    ];
  }

  private show(again = false): void {
    if (!this.brought || !this.view) return;
    const size = this.size();
    if (!size.every((x) => x > 0 && x < Infinity)) return; // the user is still typing a number
    let apart: number;
    if (this.picture) {
      const shape = reliefShape(
        this.picture,
        size,
        input("import-base").valueAsNumber,
        input("import-invert").checked,
      );
      apart = this.view.show(shape, new THREE.Matrix4(), again);
      shape.dispose();
    } else {
      const turn = this.brought.kind === "mesh" ? rows(this.up, this.front) : rows("z", "-y");
      const [x, y, z] = turn.map((row) => row.map((entry) => entry * this.longest));
      apart = this.view.show(
        this.shape!,
        new THREE.Matrix4().set(
          x[0],
          x[1],
          x[2],
          0,
          y[0],
          y[1],
          y[2],
          0,
          z[0],
          z[1],
          z[2],
          0,
          0,
          0,
          0,
          1,
        ),
        again,
      );
    }
    put(
      "import-size",
      t("import_size", { size: size.map(short).join(" × "), apart: short(apart) }),
    );
    this.showDetail();
  }

  private showWood(): void {
    const choices = this.brought?.kind === "volume" ? this.labels() : [select("import-wood")];
    const woods = choices.map((choice) => this.materials[Number(choice.value)]);
    if (woods.every(Boolean)) this.view?.setWoods(woods);
  }

  /** Estimates the rays, triangles and memory of the chosen detail. */
  private showDetail(): void {
    if (!this.brought) return;
    const size = this.size(),
      pitch = this.longest / Number(select("import-detail").value);
    const nodes = size.map((x) => (x + (ROOM - 1) * this.longest) / pitch);
    const rays = nodes[0] * nodes[1] + nodes[1] * nodes[2] + nodes[2] * nodes[0];
    const brought = this.brought;
    const area =
      brought.kind !== "relief"
        ? brought.area_mm2 * (this.longest / Math.max(...brought.size_mm)) ** 2
        : 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    const bytes = rays * brought.ray_bytes;
    const tight =
      brought.free_bytes > 0 && bytes > brought.free_bytes ? ` ${t("import_memory")}` : "";
    // On average over all directions, a surface crosses 1.5 lattice edges per square of the pitch.
    // Each crossing becomes two triangles.
    put(
      "import-detail-out",
      t("import_detail", {
        pitch: short(pitch),
        rays: many(rays),
        triangles: many((3 * area) / pitch ** 2),
        mb: Math.ceil(bytes / 1e6),
      }) + tight,
    );
    const notes =
      brought.kind === "mesh"
        ? [...(brought.repairs.length ? brought.repairs : [t("import_sound")])]
        : [];
    if (this.within > 0) notes.push(t("import_place"));
    else
      notes.push(
        brought.kind === "mesh"
          ? t("import_left_out", { pitch: short(pitch) })
          : brought.kind === "volume"
            ? t("import_voxels", { pitch: short(pitch) })
            : t("import_pixels", {
                width: brought.width,
                height: brought.height,
                pitch: short(pitch),
              }),
      );
    element("import-notes").replaceChildren(
      ...notes.map((text) => {
        const item = document.createElement("li");
        item.textContent = text;
        return item;
      }),
    );
  }

  private showError(text: string): void {
    put("import-trouble", text);
    element("import-trouble").hidden = text === "";
  }

  private async make(): Promise<void> {
    const brought = this.brought!,
      turn = this.turns;
    const about: Record<string, string> = {
      import: brought.import,
      name: input("import-name").value.trim(),
      size: String(this.longest),
      rays: select("import-detail").value,
      material: select("import-wood").value,
    };
    if (this.within > 0) about.no_go = input("import-no-go").checked ? "1" : "0";
    if (brought.kind === "mesh") Object.assign(about, { up: this.up, front: this.front });
    else if (brought.kind === "volume")
      about.labels = this.labels()
        .map((choice) => `${choice.dataset.label}:${choice.value}`)
        .join(",");
    else
      Object.assign(about, {
        height: input("import-height").value,
        base: input("import-base").value,
        invert: input("import-invert").checked ? "1" : "0",
      });
    try {
      const answer = await request(this.address("make", about), { method: "POST" });
      if (turn !== this.turns || answer.ok) return;
      if (answer.status === 404) return notify(await answer.text());
      // The user can change the options and try again. A cancelled import needs no message.
      this.showError(await answer.text());
      this.reopen();
    } catch {
      if (turn === this.turns) notify(t("no_answer"));
    }
  }

  private drop(): void {
    const brought = this.brought;
    this.brought = null;
    if (!brought) return;
    const address = this.address("import", { import: brought.import });
    // Drop the file before the next one replaces it. If the studio has ended, the file is gone too.
    this.reading = this.reading
      .then(() => request(address, { method: "DELETE" }))
      .then(
        () => undefined,
        () => undefined,
      );
  }
}
