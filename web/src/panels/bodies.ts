// SPDX-License-Identifier: MIT
// The panel of the document's bodies: their list and the actions on them. Two gestures work on the
// piece: a drawn line cuts a body, and a drag moves or turns it. Each gesture sends one action,
// which becomes a step of the history.
import { t } from "../base/texts";
import * as THREE from "three";
import { element, input, put, select } from "../base/dom";
import { notify } from "../base/notice";
import { MESHES } from "../connection/kinds";
import { write, type Remains } from "../connection/messages";
import { readBodies, type Body } from "../view/body";
import type { View } from "../view/view";

type Gesture = "cut" | "move" | "turn" | "mask";
const GESTURES: Gesture[] = ["cut", "move", "turn", "mask"];
const HELP: Record<Gesture, string> = {
  cut: t("help_cut"),
  move: t("help_move"),
  turn: t("help_turn"),
  mask: t("help_mask"),
};

/** A line counts as straight if it deviates at most this much from the chord [chord lengths]. */
const STRAIGHT = 0.02;
/**
 * A line closes if its ends are nearer than CLOSES_PX [pixels] and it is longer than CLOSES_TIMES
 * times CLOSES_PX.
 */
const CLOSES_PX = 16,
  CLOSES_TIMES = 5;
/** Tolerance for simplifying a drawn line [pixels]. */
const LINE_PX = 0.7;
const MIN_LINE_PX = 8;
const TURN_PER_PIXEL = 0.01; // [rad]
/** Spacing of a mask stroke's points [mask radii], and the studio's limit of their count. */
const MASK_APART = 0.2,
  MASK_PLACES = 4096;
const MASK = "Mask"; // the name that the studio gives it

const mm = (x: number): string => String(Number(x.toPrecision(2)));
const shortVolume = (mm3: number): string =>
  mm3 < 1000 ? `${mm3.toFixed(mm3 < 10 ? 2 : 0)} mm³` : `${(mm3 / 1000).toFixed(1)} cm³`;

type Point = { x: number; y: number };
const apart = (a: Point, b: Point): number => Math.hypot(a.x - b.x, a.y - b.y);
function distanceToLine(p: Point, a: Point, b: Point): number {
  const long = apart(a, b);
  return long > 0
    ? Math.abs((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x)) / long
    : apart(p, a);
}

/** Simplifies a line within the tolerance `within` (Ramer, Douglas and Peucker). */
export function fewer(line: Point[], within: number): Point[] {
  let far = 0,
    at = 0;
  for (let i = 1; i + 1 < line.length; i++) {
    const d = distanceToLine(line[i], line[0], line[line.length - 1]);
    if (d > far) [far, at] = [d, i];
  }
  if (far <= within) return line.length > 1 ? [line[0], line[line.length - 1]] : line;
  return [...fewer(line.slice(0, at + 1), within).slice(0, -1), ...fewer(line.slice(at), within)];
}

const EYE = `<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M2 10s3-5 8-5 8 5 8 5-3 5-8 5-8-5-8-5z"/><circle cx="10" cy="10" r="2.4"/></svg>`;
const LOCK = `<svg viewBox="0 0 20 20" aria-hidden="true"><rect x="4.5" y="9" width="11" height="7.5" rx="1.5"/><path d="M7 9V6.5a3 3 0 0 1 6 0V9"/></svg>`;

const NO_GO = `<svg viewBox="0 0 20 20" aria-hidden="true"><path d="M10 2.5l6.5 2.3v5c0 4-2.8 6.6-6.5 7.9-3.7-1.3-6.5-3.9-6.5-7.9v-5z"/><path d="M7 10h6"/></svg>`;

export class BodiesPanel {
  private all: Body[] = [];
  private active = 1;
  /** Other ticked bodies. An action uses them too. */
  private ticked = new Set<number>();
  private gesture: Gesture | null = null;
  private drag: {
    pointer: number;
    line: Point[];
    /** For a moved body: the plane across the view through the point where it was grabbed. */
    plane: THREE.Plane;
    from: THREE.Vector3;
    by: THREE.Matrix4;
    /** For a mask: points on the wood, and whether the stroke erases. */
    places: THREE.Vector3[];
    away: boolean;
  } | null = null;
  private remaining = false; // whether the remaining material is shown
  private drawn = element("drawn-line").querySelector("polyline")!;

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
    private send: (message: Uint8Array) => void,
    private holds: () => boolean,
    private bring: (file: File, longest: number) => void,
    /** Switches off all other colourings. */
    private otherColours: () => void,
  ) {
    const file = input("body-file");
    file.accept = MESHES;
    element("body-add").onclick = () => file.click();
    file.onchange = () => {
      const chosen = file.files?.[0],
        size = this.view.solid.boxOf(this.active).getSize(new THREE.Vector3());
      if (chosen) this.bring(chosen, Math.max(...size.toArray()));
      file.value = ""; // so that the same file can be chosen again
    };
    element("body-remains").onclick = () => this.showRemains(!this.remaining);
    for (const gesture of GESTURES)
      element(`body-${gesture}`).onclick = () =>
        this.take(this.gesture === gesture ? null : gesture);
    for (const verb of ["join", "subtract", "intersect"])
      element(`body-${verb}`).onclick = () => this.act({ verb, bodies: this.first() });
    for (const verb of ["separate", "duplicate", "bake", "remove"])
      element(`body-${verb}`).onclick = () => this.act({ verb, bodies: [this.active] });
    element("body-mirror").onclick = () => this.mirror();
    select("crumbs").onchange = () =>
      this.send(write.ChooseCrumbs({ rule: select("crumbs").selectedIndex }));
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event), { capture: true });
    canvas.addEventListener("pointerup", (event) => this.up(event), { capture: true });
    for (const end of ["pointercancel", "lostpointercapture"] as const)
      canvas.addEventListener(
        end,
        (event) => event.pointerId === this.drag?.pointer && this.drop(),
      );
  }

  /** The body that strokes change. */
  get activeBody(): number {
    return this.active;
  }
  /** Starts with another document. */
  begin(): void {
    this.take(null);
    this.all = [];
    this.ticked.clear();
    this.remaining = false;
    this.remains({ max: 0, mean: 0, volume: 0, scale: 0 });
  }

  /** Takes the list of bodies from the studio. */
  set(active: number, json: string): void {
    this.all = readBodies(json);
    this.active = active;
    for (const id of [...this.ticked])
      if (id === active || !this.all.some((body) => body.id === id)) this.ticked.delete(id);
    this.view.solid.setBodies(this.all, active);
    this.draw();
  }

  /** Makes the next body of the list the active one. */
  next(): void {
    const at = this.all.findIndex((body) => body.id === this.active);
    if (this.all.length > 1) this.choose(this.all[(at + 1) % this.all.length].id);
  }

  /** Sets the gesture of the next drag on the piece. Null: the tool works again. */
  take(gesture: Gesture | null): void {
    if (gesture && !this.holds()) return;
    if (gesture !== this.gesture) this.drop();
    if (this.gesture && element("notice").textContent === HELP[this.gesture]) notify("");
    this.gesture = gesture;
    for (const one of GESTURES)
      element(`body-${one}`).setAttribute("aria-pressed", String(one === gesture));
    if (gesture) notify(HELP[gesture]);
  }

  /** Leaves the current gesture on Escape. Returns whether there was one. */
  leaveOff(): boolean {
    if (!this.gesture) return false;
    this.take(null);
    return true;
  }

  /** Makes the pressed body the active one. Returns whether it did. */
  takeUp(x: number, y: number): boolean {
    if (this.all.length < 2) return false;
    const body = this.view.bodyAt(x, y);
    // Protected bodies (templates, masks) are never taken up, so that strokes can begin on them.
    if (body === null || body === this.active) return false;
    if (this.all.some((one) => one.id === body && one.no_go)) return false;
    this.choose(body);
    return true;
  }

  /** True if the surface is shown in colours that are not its own. */
  get inColours(): boolean {
    return this.remaining;
  }
  /** Ends this colouring, because another one begins. */
  leaveColours(): void {
    this.remaining = false;
    this.remains({ max: 0, mean: 0, volume: 0, scale: 0 });
  }
  /** Colours the active body by the remaining material, or stops that. */
  private showRemains(shown: boolean): void {
    if (shown) this.otherColours();
    this.remaining = shown;
    this.send(write.ShowRemains({ shown: shown ? 1 : 0 }));
    this.remains({ max: 0, mean: 0, volume: 0, scale: 0 });
  }
  /** Shows the studio's numbers for the remaining material. */
  remains({ max, mean, volume, scale }: Remains): void {
    const known = this.remaining && scale > 0;
    element("body-remains").setAttribute("aria-pressed", String(this.remaining));
    element("remains").hidden = !this.remaining;
    put("remains-scale", known ? `${mm(scale)} mm` : "");
    put(
      "remains-said",
      known
        ? t("remains", { max: mm(max), mean: mm(mean), volume: shortVolume(volume) })
        : t("remains_none"),
    );
  }

  private get body(): Body | undefined {
    return this.all.find((body) => body.id === this.active);
  }
  private first(): number[] {
    return [this.active, ...this.ticked];
  }
  private act(action: object): void {
    if (this.holds()) this.send(write.ActOnBodies({ action: JSON.stringify(action) }));
  }
  private choose(body: number): void {
    if (!this.holds() || body === this.active) return;
    this.send(write.ChooseBody({ body }));
    const name = this.all.find((one) => one.id === body)?.name;
    if (name) notify(t("body_active", { body: name }));
  }

  private mirror(): void {
    const middle = this.view.solid.boxOf(this.active).getCenter(new THREE.Vector3());
    const normal = [0, 0, 0];
    normal[Number(select("body-mirror-axis").value)] = 1;
    this.act({
      verb: "mirror",
      bodies: [this.active],
      cutter: { point_mm: middle.toArray(), normal },
    });
  }

  // ---- List

  private draw(): void {
    const list = element("body-list");
    const focused = (document.activeElement as HTMLElement | null)?.dataset.at;
    list.replaceChildren(...this.all.map((body) => this.row(body)));
    if (focused) list.querySelector<HTMLElement>(`[data-at="${focused}"]`)?.focus();
    put("body-count", this.all.length > 1 ? String(this.all.length) : "");
    const others = this.ticked.size > 0;
    for (const verb of ["join", "subtract", "intersect"])
      element<HTMLButtonElement>(`body-${verb}`).disabled = !others;
    element<HTMLButtonElement>("body-remove").disabled = this.all.length < 2;
    element("body-with").hidden = this.all.length < 2;
    element<HTMLButtonElement>("body-remains").disabled =
      !this.remaining && !this.all.some((body) => body.no_go && body.id !== this.active);
    element("bodies-box").dataset.active = String(this.active);
  }

  private row(body: Body): HTMLLIElement {
    const row = document.createElement("li");
    row.dataset.body = String(body.id);
    row.classList.toggle("current", body.id === this.active);
    const tick = document.createElement("input");
    tick.type = "checkbox";
    tick.checked = this.ticked.has(body.id);
    tick.disabled = body.id === this.active;
    tick.ariaLabel = t("body_tick", { body: body.name });
    tick.dataset.at = `tick ${body.id}`;
    tick.onchange = () => {
      if (tick.checked) this.ticked.add(body.id);
      else this.ticked.delete(body.id);
      this.draw();
    };
    const name = document.createElement("button");
    name.className = "name";
    name.textContent = body.name;
    name.title = body.id === this.active ? t("body_rename") : t("body_activate");
    name.ariaPressed = String(body.id === this.active);
    name.dataset.at = `name ${body.id}`;
    name.onclick = () => {
      if (body.id !== this.active) this.choose(body.id);
      else if (this.holds()) this.rename(body, name);
    };
    const volume = document.createElement("span");
    volume.className = "quiet";
    volume.textContent = shortVolume(body.volume_mm3);
    row.append(
      tick,
      name,
      volume,
      this.flag(body, "visible", EYE, t(body.visible ? "hide" : "show_body"), !body.visible),
      this.flag(body, "locked", LOCK, t(body.locked ? "unlock" : "lock"), body.locked),
      this.flag(body, "no_go", NO_GO, t(body.no_go ? "unprotect" : "protect"), body.no_go),
    );
    return row;
  }
  private flag(
    body: Body,
    which: "visible" | "locked" | "no_go",
    picture: string,
    hint: string,
    on: boolean,
  ): HTMLButtonElement {
    const button = document.createElement("button");
    button.className = `flag ${which}`;
    button.innerHTML = picture;
    button.title = hint;
    button.ariaLabel = `${hint} ${body.name}`;
    button.ariaPressed = String(on);
    button.dataset.at = `${which} ${body.id}`;
    button.onclick = () => this.act({ verb: "set", bodies: [body.id], [which]: !body[which] });
    return button;
  }
  private rename(body: Body, at: HTMLElement): void {
    const field = document.createElement("input");
    field.value = body.name;
    field.maxLength = 60;
    field.ariaLabel = t("name");
    const done = (keep: boolean): void => {
      field.onblur = null;
      const name = field.value.trim();
      field.replaceWith(at);
      if (keep && name !== "" && name !== body.name)
        this.act({ verb: "set", bodies: [body.id], name });
    };
    field.onblur = () => done(true);
    field.onkeydown = (event) => {
      event.stopPropagation();
      if (event.key === "Enter") done(true);
      if (event.key === "Escape") done(false);
    };
    at.replaceWith(field);
    field.select();
  }

  // ---- Gestures

  private down(event: PointerEvent): void {
    if (!this.gesture || event.button !== 0 || this.drag) return;
    if (this.gesture !== "mask") event.stopImmediatePropagation();
    const { clientX: x, clientY: y } = event;
    const from =
      this.view.hit(x, y)?.point ??
      this.view.solid.boxOf(this.active).getCenter(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(
      this.view.cameras.towardsEye(from),
      from,
    );
    this.drag = {
      pointer: event.pointerId,
      line: [{ x, y }],
      plane,
      from: this.on(plane, x, y) ?? from,
      by: new THREE.Matrix4(),
      places: [],
      away: event.altKey,
    };
    if (this.gesture === "mask") {
      const hit = this.view.hit(x, y);
      if (!hit) {
        this.drag = null; // a press outside the piece turns the view
        return;
      }
      this.drag.places.push(hit.point);
    }
    event.stopImmediatePropagation();
    this.view.cameras.controls.enabled = false;
    this.canvas.setPointerCapture(event.pointerId);
  }

  private move(event: PointerEvent): void {
    const { drag } = this;
    if (!drag) {
      if (this.gesture) event.stopImmediatePropagation();
      if (this.gesture === "mask" && event.buttons === 0)
        this.view.marks.showRing(this.view.hit(event.clientX, event.clientY), this.maskRadius);
      return;
    }
    if (event.pointerId !== drag.pointer) return;
    event.stopImmediatePropagation();
    const now = { x: event.clientX, y: event.clientY };
    const begin = drag.line[0];
    if (this.gesture === "mask") {
      const hit = this.view.hit(now.x, now.y);
      this.view.marks.showRing(hit, this.maskRadius);
      const last = drag.places[drag.places.length - 1];
      if (hit && hit.point.distanceTo(last) > MASK_APART * this.maskRadius) {
        drag.places.push(hit.point);
        drag.line.push(now);
        this.drawn.setAttribute("points", drag.line.map((p) => `${p.x},${p.y}`).join(" "));
      }
    } else if (this.gesture === "cut") {
      if (event.shiftKey) drag.line = [begin, now];
      else if (apart(drag.line[drag.line.length - 1], now) >= 1) drag.line.push(now);
      this.drawn.setAttribute("points", drag.line.map((p) => `${p.x},${p.y}`).join(" "));
    } else {
      if (this.gesture === "move") {
        const to = this.on(drag.plane, now.x, now.y);
        if (to) drag.by.makeTranslation(to.sub(drag.from));
      } else drag.by.copy(this.turned(now.x - begin.x, now.y - begin.y, event.shiftKey));
      this.view.showMoved(this.active, drag.by);
    }
  }

  private up(event: PointerEvent): void {
    const { drag, gesture } = this;
    if (!drag || event.pointerId !== drag.pointer) return;
    event.stopImmediatePropagation();
    this.drop();
    if (gesture === "mask") return this.mask(drag.places, drag.away);
    this.take(null);
    if (gesture === "cut") this.cut(drag.line);
    else if (!drag.by.equals(new THREE.Matrix4())) this.place(drag.by);
  }

  /** Ends or cancels a gesture. */
  private drop(): void {
    if (!this.drag) return;
    this.drag = null;
    this.drawn.setAttribute("points", "");
    this.view.cameras.controls.enabled = true;
    this.view.showMoved(this.active, null);
  }

  private get maskRadius(): number {
    return Number(input("size").value);
  }
  /** Masks or unmasks the region of a ball whose centre moves through these points. */
  private mask(places: THREE.Vector3[], away: boolean): void {
    const radius = this.maskRadius,
      own = this.body;
    const mask = this.all.find(
      (body) => body.no_go && body.name === MASK && own && body.matrix.equals(own.matrix),
    );
    if (away && !mask) return notify(t("mask_none"));
    this.act({
      verb: "protect",
      bodies: mask ? [this.active, mask.id] : [this.active],
      tool: { shape: "ball", radius },
      operation: away ? "cut" : "deposit",
      way_mm: places.slice(0, MASK_PLACES).map((p) => [p.x, p.y, p.z - radius]),
    });
  }

  private on(plane: THREE.Plane, x: number, y: number): THREE.Vector3 | null {
    return this.view.cameras.rayAt(x, y).intersectPlane(plane, new THREE.Vector3());
  }

  private turned(x: number, y: number, aboutSight: boolean): THREE.Matrix4 {
    const middle = this.view.solid.boxOf(this.active).getCenter(new THREE.Vector3());
    const back = this.view.cameras.turned;
    const [right, up, sight] = [0, 1, 2].map((i) =>
      new THREE.Vector3().setFromMatrixColumn(back, i),
    );
    const turn = aboutSight
      ? new THREE.Matrix4().makeRotationAxis(sight, -x * TURN_PER_PIXEL)
      : new THREE.Matrix4()
          .makeRotationAxis(up, x * TURN_PER_PIXEL)
          .premultiply(new THREE.Matrix4().makeRotationAxis(right, y * TURN_PER_PIXEL));
    return new THREE.Matrix4()
      .makeTranslation(middle)
      .multiply(turn)
      .multiply(new THREE.Matrix4().makeTranslation(middle.clone().negate()));
  }

  private place(by: THREE.Matrix4): void {
    if (!this.body) return;
    const to = by.clone().multiply(this.body.matrix);
    // Make the axes orthonormal again, so that errors do not accumulate over many turns.
    const [x, y, z] = [0, 1, 2].map((i) => new THREE.Vector3().setFromMatrixColumn(to, i));
    x.normalize();
    y.addScaledVector(x, -x.dot(y)).normalize();
    z.crossVectors(x, y);
    this.act({
      verb: "move",
      bodies: [this.active],
      pose: {
        tip_mm: new THREE.Vector3().setFromMatrixPosition(to).toArray(),
        axes: [x, y, z].map((axis) => axis.toArray()),
      },
    });
  }

  private cut(drawn: Point[]): void {
    const line = fewer(drawn, LINE_PX),
      first = line[0],
      last = line[line.length - 1];
    const long = line.slice(1).reduce((sum, p, i) => sum + apart(line[i], p), 0);
    if (long < MIN_LINE_PX) return notify(t("line_short"));
    const box = this.view.solid.boxOf(this.active);
    const middle = box.getCenter(new THREE.Vector3());
    const closed = apart(first, last) < CLOSES_PX && long > CLOSES_TIMES * CLOSES_PX;
    if (
      !closed &&
      drawn.every((p) => distanceToLine(p, first, last) <= STRAIGHT * apart(first, last))
    )
      return this.cutStraight(first, last, middle);
    // Place the curve at the mean depth of the wood under the line.
    const hits = line.flatMap((p) => this.view.hit(p.x, p.y)?.point ?? []);
    const deep =
      hits.length > 0 ? hits.reduce((a, b) => a.add(b)).divideScalar(hits.length) : middle;
    const along = this.view.cameras.towardsEye(deep);
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(along, deep);
    const places = (closed ? line.slice(0, -1) : line).flatMap(
      (p) => this.on(plane, p.x, p.y) ?? [],
    );
    // The part to the left of the line is cut off. So the line's direction is chosen to keep the
    // body's centre.
    const at = this.view.cameras.onScreen(middle.toArray());
    const left = (last.x - first.x) * (at.y - first.y) - (last.y - first.y) * (at.x - first.x) < 0;
    if (!closed && left) places.reverse();
    this.cutBy({
      curve_mm: places.map((p) => p.toArray()),
      along: along.toArray(),
      closed,
      smooth: false,
    });
  }

  /** Cuts by the plane of sight through both ends of the line. */
  private cutStraight(first: Point, last: Point, middle: THREE.Vector3): void {
    const rays = [first, last].map((p) => this.view.cameras.rayAt(p.x, p.y).clone());
    const across = rays[1].at(100, new THREE.Vector3()).sub(rays[0].at(100, new THREE.Vector3()));
    const normal = across.cross(rays[0].direction).normalize();
    const point = rays[0].at(1, new THREE.Vector3());
    if (normal.dot(middle.clone().sub(point)) > 0) normal.negate();
    this.cutBy({
      point_mm: middle.addScaledVector(normal, normal.dot(point.sub(middle))).toArray(),
      normal: normal.toArray(),
    });
  }
  private cutBy(cutter: object): void {
    const kerf_mm = Math.max(0, Number(input("kerf").value) || 0);
    this.act({
      verb: "cut",
      bodies: [this.active],
      cutter: kerf_mm > 0 ? { ...cutter, kerf_mm } : cutter,
    });
  }
}
