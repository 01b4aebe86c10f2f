// SPDX-License-Identifier: MIT
// Marks around the solid: symmetry planes and axis, the plane from which depth is measured, the
// ring under the pointer, and the grid on the ground. Lengths are in mm.
import * as THREE from "three";
import type { Hit } from "./pick";

const BLUE = 0x0072b2;
/** Colours of the ring. They are distinct for colour-blind users. */
const RING = { usual: BLUE, inverts: 0xd55e00, smooths: 0x009e73 };
/** Opacity of the disc inside the ring, at the places where the brush has its full effect. */
const FULL = 0.45;
const RINGS = 10,
  SEGMENTS = 48;
const UP = new THREE.Vector3(0, 0, 1);

/** A rectangle through the middle of a box, normal to an axis and as large as the box. */
function frameAcross(axis: number, box: THREE.Box3): THREE.LineLoop {
  const half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5),
    [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
  const corners = [
    [-1, -1],
    [1, -1],
    [1, 1],
    [-1, 1],
  ].map(([a, b]) =>
    new THREE.Vector3()
      .setComponent(u, a * half.getComponent(u))
      .setComponent(v, b * half.getComponent(v)),
  );
  const frame = new THREE.LineLoop(
    new THREE.BufferGeometry().setFromPoints(corners),
    new THREE.LineBasicMaterial({ color: BLUE }),
  );
  box.getCenter(frame.position);
  frame.visible = false;
  return frame;
}

/** As falloff_weight in kibori/reshape/brush.h, at a distance in radii. */
const WEIGHTS = [
  (d: number): number => (1 - d * d) ** 2,
  (d: number): number => 1 - d,
  (): number => 1,
];

/** A disc of radius 1 whose opacity is the weight of a brush. */
function discOf(falloff: number, color: THREE.Color): THREE.BufferGeometry {
  const disc = new THREE.RingGeometry(0, 1, SEGMENTS, RINGS),
    place = disc.getAttribute("position");
  const colors = new Float32Array(4 * place.count);
  for (let i = 0; i < place.count; i++) {
    const weight = WEIGHTS[falloff](Math.min(1, Math.hypot(place.getX(i), place.getY(i))));
    colors.set([color.r, color.g, color.b, FULL * weight], 4 * i);
  }
  disc.setAttribute("color", new THREE.BufferAttribute(colors, 4));
  return disc;
}

export class Marks {
  readonly group = new THREE.Group();
  private piece = new THREE.Box3(); // the lattice's box
  private radius = 0; // of the framed sphere
  private grid: THREE.GridHelper | null = null;
  private planes = new THREE.Group();
  private level = new THREE.Mesh(
    new THREE.PlaneGeometry(1, 1),
    new THREE.MeshBasicMaterial({
      color: BLUE,
      transparent: true,
      opacity: 0.14,
      side: THREE.DoubleSide,
      depthWrite: false,
    }),
  );
  private ring = new THREE.Mesh(
    new THREE.RingGeometry(0.94, 1, 64),
    new THREE.MeshBasicMaterial({
      color: BLUE,
      side: THREE.DoubleSide,
      depthTest: false,
      transparent: true,
    }),
  );
  private disc = new THREE.Mesh(
    new THREE.BufferGeometry(),
    new THREE.MeshBasicMaterial({
      vertexColors: true,
      side: THREE.DoubleSide,
      depthTest: false,
      depthWrite: false,
      transparent: true,
    }),
  );
  private style = "";
  private folds = new THREE.LineSegments(
    new THREE.BufferGeometry(),
    new THREE.LineBasicMaterial({
      color: BLUE,
      depthTest: false,
      transparent: true,
      opacity: 0.35,
    }),
  );

  constructor(private redraw: () => void) {
    this.level.visible = this.ring.visible = false;
    this.ring.renderOrder = 2;
    this.ring.add(this.disc);
    this.group.add(this.planes, this.level, this.ring, this.folds);
  }

  /** Starts with another document. */
  begin(piece: THREE.Box3): void {
    this.piece.copy(piece);
    this.ring.visible = false;
    for (const frame of this.planes.children as THREE.LineLoop[]) {
      frame.geometry.dispose();
      (frame.material as THREE.Material).dispose();
    }
    this.planes.clear();
    for (const axis of [0, 1, 2]) this.planes.add(frameAcross(axis, piece));
  }

  /** Puts a grid below the framed part. Its lines are 1, 10, 100 ... mm apart. */
  frame(box: THREE.Box3, { center, radius: r }: THREE.Sphere): void {
    this.radius = r;
    if (this.grid) this.group.remove(this.grid);
    this.grid?.dispose();
    const apart = 10 ** Math.max(0, Math.round(Math.log10(r) - 0.7));
    const half = Math.ceil((1.6 * r) / apart) * apart;
    this.grid = new THREE.GridHelper(2 * half, (2 * half) / apart, 0x8a7a68, 0xb9aca0);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(
      Math.round(center.x / apart) * apart,
      Math.round(center.y / apart) * apart,
      box.min.z - 0.001 * r,
    );
    (this.grid.material as THREE.Material).transparent = true;
    (this.grid.material as THREE.Material).opacity = 0.45;
    this.group.add(this.grid);
  }

  /**
   * Shows the symmetry planes (bits 1 normal to x, 2 to y, 4 to z) as frames. Shows the rotation
   * axis and the start of each of `fold` parts.
   */
  showSymmetry(planes: number, fold: number, axis: number): void {
    this.planes.children.forEach((frame, i) => (frame.visible = ((planes >> i) & 1) === 1));
    this.folds.geometry.dispose();
    const points: THREE.Vector3[] = [];
    if (fold > 1) {
      const middle = this.piece.getCenter(new THREE.Vector3()),
        half = this.piece.getSize(new THREE.Vector3()).multiplyScalar(0.5);
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3],
        reach = Math.hypot(half.getComponent(u), half.getComponent(v));
      const at = (along: number, turn: number, out: number): THREE.Vector3 =>
        new THREE.Vector3()
          .setComponent(axis, along * half.getComponent(axis))
          .setComponent(u, out * Math.cos(turn))
          .setComponent(v, out * Math.sin(turn))
          .add(middle);
      points.push(at(-1.2, 0, 0), at(1.2, 0, 0));
      for (let i = 0; i < fold; i++) {
        const turn = (2 * Math.PI * i) / fold;
        points.push(at(1, turn, 0), at(1, turn, reach));
      }
    }
    this.folds.geometry = new THREE.BufferGeometry().setFromPoints(points);
    this.redraw();
  }

  /** Shows the plane for depth. Null: none. */
  showPlane(plane: Hit | null): void {
    this.level.visible = plane !== null;
    if (plane) {
      this.level.position.copy(plane.point);
      this.level.quaternion.setFromUnitVectors(UP, plane.normal);
      this.level.scale.setScalar(this.radius || 20);
    }
    this.redraw();
  }

  /**
   * Sets how the ring looks: its colour, and the falloff of the brush that it shows (0 smooth, 1
   * linear, 2 constant). Null: a tool has none.
   */
  styleRing(kind: keyof typeof RING, falloff: number | null): void {
    const style = `${kind} ${falloff}`;
    if (style === this.style) return;
    this.style = style;
    this.ring.material.color.set(RING[kind]);
    this.disc.visible = falloff !== null;
    if (falloff === null) return;
    this.disc.geometry.dispose();
    this.disc.geometry = discOf(falloff, this.ring.material.color);
  }
  /** Shows a ring on the wood. Null: none. */
  showRing(at: Hit | null, radius: number): void {
    this.ring.visible = at !== null;
    if (at) {
      this.ring.position.copy(at.point).addScaledVector(at.normal, 0.05);
      this.ring.quaternion.setFromUnitVectors(UP, at.normal);
      this.ring.scale.setScalar(radius);
    }
    this.redraw();
  }
}
