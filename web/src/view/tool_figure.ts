// SPDX-License-Identifier: MIT
// Draws the tool over the solid, with an arrow for the wood's force on it.
import * as THREE from "three";
import { toolSurface, type HeldTool } from "../tools/tools";
import type { Vec3 } from "../base/vec3";

const STEEL = 0xb8bcc2,
  RED = 0xc62828,
  FORCE = 0xd55e00;
const OPACITY = 0.75,
  GHOSTLY = 0.4;

export class ToolFigure {
  readonly group = new THREE.Group();
  private body = new THREE.Group();
  private arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, FORCE);
  private held = ""; // the drawn tool as JSON
  private reported = ""; // the last reported pose and force as text
  private red = false;
  private ghostly = false;

  constructor(private changed: () => void) {
    this.group.add(this.body, this.arrow);
    this.hide();
  }

  hide(): void {
    this.body.visible = this.arrow.visible = false;
    this.reported = "";
  }

  /** Sets the tool. Null: no tool that can be drawn. */
  set(tool: HeldTool | null): void {
    const reported = JSON.stringify(tool);
    if (reported === this.held) return;
    this.held = reported;
    for (const mesh of this.meshes) {
      mesh.geometry.dispose();
      mesh.material.dispose();
    }
    this.body.clear();
    if (tool) {
      const steel = new THREE.MeshStandardMaterial({
        color: this.red ? RED : STEEL,
        roughness: 0.3,
        metalness: 0.6,
        transparent: true,
      });
      this.body.add(new THREE.Mesh(toolSurface(tool), steel));
      this.fade();
    }
    this.changed();
  }

  /** Sets tip, axis, side direction and force [N]. Null: the position is unknown. */
  place(tip: Vec3 | null, axis: Vec3, side: Vec3, force: Vec3): void {
    const reported = tip ? [...tip, ...axis, ...side, ...force].join() : "";
    if (reported === this.reported) return;
    this.reported = reported;
    this.changed();
    this.body.visible = tip !== null;
    this.arrow.visible = false;
    if (!tip) return;
    this.body.position.set(...tip);
    const x = new THREE.Vector3(...side),
      z = new THREE.Vector3(...axis);
    this.body.quaternion.setFromRotationMatrix(
      new THREE.Matrix4().makeBasis(x, z.clone().cross(x), z),
    );
    const f = new THREE.Vector3(...force);
    const n = f.length();
    this.arrow.visible = n > 0.01;
    if (!this.arrow.visible) return;
    this.arrow.position.set(...tip);
    this.arrow.setDirection(f.divideScalar(n));
    this.arrow.setLength(Math.min(40, 6 + 12 * Math.log1p(n)), 3, 1.6);
  }

  /** True if the tool is more transparent than usual. */
  set ghost(on: boolean) {
    this.ghostly = on;
    this.fade();
  }
  /** True if the tool cannot work at its position. Only a change is drawn. */
  set blocked(now: boolean) {
    if (now === this.red) return;
    this.red = now;
    for (const mesh of this.meshes) mesh.material.color.set(now ? RED : STEEL);
    this.changed();
  }
  /** Half of the drawn tool's width [mm]. 0: no tool is drawn. */
  get width(): number {
    let wide = 0;
    for (const { geometry } of this.meshes) {
      if (!geometry.boundingBox) geometry.computeBoundingBox();
      const { min, max } = geometry.boundingBox!;
      wide = Math.max(wide, max.x, max.y, -min.x, -min.y);
    }
    return wide;
  }

  private get meshes(): THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>[] {
    return this.body.children as THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>[];
  }
  private fade(): void {
    for (const { material } of this.meshes) {
      material.opacity = this.ghostly ? GHOSTLY : OPACITY;
      material.depthWrite = !this.ghostly;
    }
  }
}
