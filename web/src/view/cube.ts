// SPDX-License-Identifier: MIT
// The view cube. It turns with the camera. Its faces, edges and corners are buttons for views. The
// Tab key stops once at the cube. Then the arrow keys select the next view, 45 degrees further.
import { t } from "../base/texts";
import type * as THREE from "three";
import type { Vec3 } from "../base/vec3";

const FACES: { name: string; normal: Vec3; right: Vec3; up: Vec3 }[] = [
  { name: t("face_front"), normal: [0, -1, 0], right: [1, 0, 0], up: [0, 0, 1] },
  { name: t("face_right"), normal: [1, 0, 0], right: [0, 1, 0], up: [0, 0, 1] },
  { name: t("face_back"), normal: [0, 1, 0], right: [-1, 0, 0], up: [0, 0, 1] },
  { name: t("face_left"), normal: [-1, 0, 0], right: [0, -1, 0], up: [0, 0, 1] },
  { name: t("face_top"), normal: [0, 0, 1], right: [1, 0, 0], up: [0, 1, 0] },
  { name: t("face_bottom"), normal: [0, 0, -1], right: [1, 0, 0], up: [0, -1, 0] },
];
const HALF = 30; // half of its side [px]

const nameOf = (from: Vec3): string =>
  [
    [t("face_bottom"), "", t("face_top")][from[2] + 1],
    [t("face_front"), "", t("face_back")][from[1] + 1],
    [t("face_left"), "", t("face_right")][from[0] + 1],
  ]
    .filter(Boolean)
    .join(" ");

export class ViewCube {
  private body = document.createElement("div");
  // The buttons that the keyboard reaches, by view direction.
  private buttons = new Map<string, HTMLButtonElement>();
  private at: Vec3 = [0, -1, 0]; // the view that the keyboard has selected

  constructor(
    into: HTMLElement,
    private go: (from: Vec3) => void,
  ) {
    this.body.className = "cube-body";
    for (const face of FACES) this.body.append(this.face(face));
    into.append(this.body);
    into.addEventListener("keydown", (event) => this.key(event));
    this.reach(this.at);
  }

  /** Follows the camera. The columns are the camera's right, up and backward. */
  turn(camera: THREE.Matrix4): void {
    // CSS has y down. The world's x, -z, y are the cube's axes.
    const m = camera.elements,
      row = (k: number): number[] => [m[4 * k], m[4 * k + 1], m[4 * k + 2]];
    const [r, u, b] = [row(0), row(1), row(2)];
    this.body.style.transform = `matrix3d(${[0, 1, 2].map((axis) => [r[axis], -u[axis], b[axis], 0].map((x) => x.toFixed(5)).join()).join()},0,0,0,1)`;
  }

  private face({ name, normal, right, up }: (typeof FACES)[number]): HTMLElement {
    const face = document.createElement("div");
    face.className = "cube-face";
    // x to the right, y down, z outward.
    face.style.transform = `matrix3d(${right.join()},0,${up.map((x) => -x).join()},0,${normal.join()},0,${normal.map((x) => HALF * x).join()},1)`;
    for (let row = 1; row >= -1; row--)
      for (let column = -1; column <= 1; column++) {
        const from = normal.map((n, i) => n + column * right[i] + row * up[i]) as Vec3,
          key = from.join(),
          button = document.createElement("button");
        button.type = "button";
        button.tabIndex = -1;
        if (row === 0 && column === 0) button.textContent = name;
        button.title = t("cube_view", { from: nameOf(from) });
        // Edges and corners are on several faces. One button of each is enough for screen readers.
        if (this.buttons.has(key)) button.ariaHidden = "true";
        else this.buttons.set(key, button);
        button.ariaLabel = button.title;
        button.onclick = () => {
          this.reach(from);
          this.go(from);
        };
        face.append(button);
      }
    return face;
  }

  /** Makes a button the one that Tab reaches. */
  private reach(from: Vec3): void {
    this.buttons.get(this.at.join())!.tabIndex = -1;
    this.at = from;
    this.buttons.get(from.join())!.tabIndex = 0;
  }

  private key(event: KeyboardEvent): void {
    const around = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0,
      up = { ArrowUp: 1, ArrowDown: -1 }[event.key] ?? 0;
    if (around === 0 && up === 0) return;
    event.preventDefault();
    event.stopPropagation();
    const [x, y, z] = this.at;
    let to: Vec3;
    if (x === 0 && y === 0) {
      // From the top or bottom face, the arrow leads to the edge at the front.
      if (up === 0 || up === z) return;
      to = [0, -1, z];
    } else if (up !== 0 && z === up) to = [0, 0, up];
    else if (up !== 0) to = [x, y, z + up];
    else {
      const turn = (Math.atan2(y, x) * 4) / Math.PI + around,
        angle = (turn * Math.PI) / 4;
      to = [Math.round(Math.cos(angle)), Math.round(Math.sin(angle)), z];
    }
    this.reach(to);
    this.buttons.get(to.join())!.focus();
    this.go(to);
  }
}
