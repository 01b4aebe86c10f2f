// SPDX-License-Identifier: MIT
// The disc under a piece on the wheel. It shows the axis, and turns while the user works.
import * as THREE from "three";

// [rad/s]; a real wheel is two to four times as fast, which the eye cannot follow
const SPIN = 2 * Math.PI * 1.2;
const THICKNESS = 0.06; // share of the radius
const SPOKES = 6;

export class WheelHead {
  readonly group = new THREE.Group();
  private turning = false;
  private last = 0;

  constructor() {
    const disc = new THREE.Mesh(
      new THREE.CylinderGeometry(1, 1, THICKNESS, 96).rotateX(Math.PI / 2),
      new THREE.MeshStandardMaterial({ color: 0xa79f95, roughness: 0.75 }),
    );
    disc.position.z = -THICKNESS / 2;
    const line = new THREE.MeshBasicMaterial({ color: 0x6f675e });
    for (let i = 0; i < SPOKES; i++) {
      const spoke = new THREE.Mesh(new THREE.PlaneGeometry(0.22, 0.02), line);
      const angle = (2 * Math.PI * i) / SPOKES;
      spoke.position.set(0.87 * Math.cos(angle), 0.87 * Math.sin(angle), 0.002);
      spoke.rotation.z = angle;
      this.group.add(spoke);
    }
    this.group.add(disc);
    this.group.visible = false;
  }

  /** Places the disc under `box`, around the vertical axis through `middle`. */
  place(box: THREE.Box3, middle: THREE.Vector3): void {
    const reach = Math.max(
      box.max.x - middle.x,
      middle.x - box.min.x,
      box.max.y - middle.y,
      middle.y - box.min.y,
    );
    this.group.position.set(middle.x, middle.y, box.min.z);
    this.group.scale.setScalar(1.25 * reach);
  }

  /** Starts or stops it. Calls redraw() for every frame in which it turned. */
  turn(on: boolean, redraw: () => void): void {
    const begins = on && !this.turning && !matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.turning = on;
    if (!begins) return;
    this.last = performance.now();
    const step = (now: number): void => {
      this.group.rotation.z += (SPIN * Math.max(0, now - this.last)) / 1000;
      this.last = now;
      redraw();
      if (this.turning) requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
}
