// SPDX-License-Identifier: MIT
// Measuring. The first click on the wood measures its thickness, the second the distance from the
// first, the third the angle at the second. Also shows the mass and the centre of gravity during
// carving.
import * as THREE from "three";
import { element, input, put } from "../base/dom";
import type { Hit } from "../view/pick";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";

const COLOUR = 0xb3261e,
  CENTRE = 0x2c6fbb;
/** Size of a mark, as a share of the piece's size. */
const MARK = 1 / 160;

const mm = (value: number): string => `${value.toFixed(2)} mm`;

export class Measure {
  private points: THREE.Vector3[] = [];
  private drawn = new THREE.Group();
  private centre = new THREE.Vector3();
  private weighs = false; // there is material

  constructor(
    canvas: HTMLCanvasElement,
    private view: View,
    /** Asks the studio for the mass of the piece. */
    private ask: () => void,
  ) {
    view.showAid(this.drawn);
    input("measuring").onchange = () => this.choose();
    canvas.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    canvas.addEventListener("pointermove", (event) => this.move(event), { capture: true });
  }

  get active(): boolean {
    return input("measuring").checked;
  }
  toggle(): void {
    input("measuring").checked = !this.active;
    this.choose();
  }
  /** Ends measuring on Escape. Returns false if it is off. */
  leaveOff(): boolean {
    if (!this.active) return false;
    this.toggle();
    return true;
  }
  /** The piece has changed. */
  changed(): void {
    if (this.active) this.ask();
  }
  /** Resets for another document. */
  begin(): void {
    this.points = [];
    this.weighs = false;
    this.choose();
  }

  /** Shows the mass [g] (0: unknown) and the centre of gravity [mm]. */
  weigh(volume: number, mass: number, centre: Vec3): void {
    this.weighs = volume > 0;
    this.centre.set(...centre);
    put("measure-mass", mass > 0 ? `${mass.toPrecision(4)} g` : "not known");
    put("measure-centre", volume > 0 ? centre.map((x) => x.toFixed(2)).join("  ") : "–");
    if (this.active) this.draw();
  }

  private choose(): void {
    element("measures").hidden = !this.active;
    if (!this.active) this.points = [];
    this.changed();
    this.tell(null);
    this.draw();
  }

  private down(event: PointerEvent): void {
    if (!this.active || event.button !== 0) return;
    const hit = this.view.hit(event.clientX, event.clientY);
    if (!hit) return; // not on the piece: the view turns
    event.stopImmediatePropagation();
    if (this.points.length >= 3) this.points = [];
    this.points.push(hit.point.clone());
    this.tell(hit);
    this.draw();
  }
  private move(event: PointerEvent): void {
    if (!this.active || event.buttons !== 0) return;
    event.stopImmediatePropagation();
    this.tell(this.view.hit(event.clientX, event.clientY));
  }

  /** The numbers. The place under the pointer replaces a missing click. */
  private tell(over: Hit | null): void {
    const all = [...this.points];
    if (over && all.length < 3 && !all[all.length - 1]?.equals(over.point)) all.push(over.point);
    const thick = over && this.view.thickness(over);
    put("measure-wall", thick ? mm(thick) : "–");
    const last = all.length - 1;
    put("measure-distance", last > 0 ? mm(all[last].distanceTo(all[last - 1])) : "–");
    const [a, b, c] = all;
    const angle = c ? a.clone().sub(b).angleTo(c.clone().sub(b)) : NaN;
    put("measure-angle", c ? `${((angle * 180) / Math.PI).toFixed(1)}°` : "–");
  }

  private draw(): void {
    for (const thing of this.drawn.children) (thing as THREE.Mesh).geometry.dispose();
    this.drawn.clear();
    if (this.active) {
      const size = MARK * this.view.pieceSize;
      const mark = (at: THREE.Vector3, color: number): void => {
        const ball = new THREE.Mesh(
          new THREE.SphereGeometry(size, 16, 12),
          new THREE.MeshBasicMaterial({ color, depthTest: false, transparent: true }),
        );
        ball.position.copy(at);
        this.drawn.add(ball);
      };
      for (const point of this.points) mark(point, COLOUR);
      if (this.weighs) mark(this.centre, CENTRE);
      if (this.points.length > 1)
        this.drawn.add(
          new THREE.Line(
            new THREE.BufferGeometry().setFromPoints(this.points),
            new THREE.LineBasicMaterial({ color: COLOUR, depthTest: false, transparent: true }),
          ),
        );
    }
    this.view.redraw();
  }
}
