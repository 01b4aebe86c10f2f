// SPDX-License-Identifier: MIT
// The surfaces of the bodies, in the chunks that the studio sends. This file shows them, marks
// protected bodies, and finds where rays meet them. Lengths are in mm.
import * as THREE from "three";
import type { Body } from "./body";
import { pack, unpack, type Lattice } from "./chunks";
import { HiddenParts } from "./hidden_parts";
import { firstHit, type Hit } from "./pick";
import type { Wood } from "./wood";

/** The layer of objects that thumbnails show. */
export const PICTURED = 1;

// Protected bodies are drawn twice. Where two bodies share a face, neither may hide the other.
const blue = (how: THREE.MeshBasicMaterialParameters): THREE.MeshBasicMaterial =>
  new THREE.MeshBasicMaterial({
    color: 0x0072b2,
    transparent: true,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: -4,
    polygonOffsetUnits: -64,
    ...how,
  });
/** For the parts of the body that something hides. */
const VEIL = blue({ opacity: 0.3, depthFunc: THREE.GreaterDepth });
/** For the visible parts of the body. */
const SKIN = blue({ opacity: 0.35 });

const UPRIGHT = new THREE.Matrix4();
/** The name of a shown chunk. */
const nameOf = (place: string, body: number): string => `${place},${body}`;
const bodyOf = (name: string): number => Number(name.slice(name.lastIndexOf(",") + 1));
const boundsOf = (mesh: THREE.Mesh): THREE.Box3 =>
  new THREE.Box3().setFromBufferAttribute(
    mesh.geometry.attributes.position as THREE.BufferAttribute,
  );

export class Solid {
  readonly chunks = new THREE.Group();
  /** The protected bodies, drawn over everything. */
  readonly veils = new THREE.Group();
  /** By place and body. See nameOf. */
  readonly shown = new Map<string, THREE.Mesh>();
  lattice: Lattice = { origin: [0, 0, 0], pitch: 1 };
  /** The active body. */
  active = 1;
  /** The parts that the user has hidden. After a change, call markHidden(). */
  readonly hidden = new HiddenParts();
  /** True if all chunks have arrived. */
  whole = false;
  /** The spheres of chunks that have changed since the last frame. */
  changed: THREE.Sphere[] = [];
  /** True if the light or a shadow caster has changed since the shadows were drawn. */
  shadowsStale = false;
  private poses = new Map<number, THREE.Matrix4>(); // of visible bodies
  private noGo = new Set<number>(); // protected bodies
  // The chunks as they were when the stroke began. Depth is measured from them: if it were measured
  // from the new surface, the tool would go deeper and deeper. Null: there was no chunk.
  private before: Map<string, THREE.Mesh | null> | null = null;

  constructor(
    private wood: Wood,
    private redraw: () => void,
  ) {
    this.chunks.matrixWorldAutoUpdate = false;
  }

  /** Starts with another document. */
  begin(lattice: Lattice): void {
    for (const mesh of this.shown.values()) mesh.geometry.dispose();
    this.shown.clear();
    this.chunks.clear();
    this.poses.clear();
    this.active = 1;
    this.lattice = lattice;
    this.whole = false;
    this.endStroke();
    this.hidden.clear();
    this.markHidden();
  }

  /** Removes chunks of bodies that are gone, hidden or moved. */
  setBodies(bodies: Body[], active: number): void {
    const poses = new Map(bodies.filter((b) => b.visible).map((b) => [b.id, b.matrix]));
    for (const [id, pose] of this.poses)
      if (!poses.get(id)?.equals(pose))
        for (const name of [...this.shown.keys()]) if (bodyOf(name) === id) this.drop(name);
    this.poses = poses;
    this.active = active;
    this.noGo = new Set(bodies.filter((b) => b.no_go).map((b) => b.id));
    this.veil();
    this.redraw();
  }

  /** Takes a frame of a body's chunks. */
  take(data: Uint8Array, body: number): void {
    const pose = this.poses.get(body);
    if (!pose) return; // it was hidden meanwhile
    const turned = !pose.equals(UPRIGHT);
    this.whole = false;
    unpack(data, this.lattice, turned ? pose : null, (place, made) => {
      const name = nameOf(place, body);
      this.drop(name);
      if (!made) return;
      if (this.hidden.any) this.hidden.mark(made);
      const mesh = new THREE.Mesh(made, this.wood.material);
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.matrixAutoUpdate = false;
      mesh.userData.turned = turned;
      mesh.layers.enable(PICTURED);
      this.changed.push(made.boundingSphere!);
      this.shown.set(name, mesh);
      this.chunks.add(mesh);
    });
    this.shadowsStale = true;
    if (this.noGo.has(body)) this.veil();
    this.redraw();
  }
  /** Draws protected bodies in blue, visible through everything in front of them. */
  private veil(): void {
    this.veils.clear();
    for (const [name, { geometry, matrix }] of this.shown) {
      if (!this.noGo.has(bodyOf(name))) continue;
      for (const material of [VEIL, SKIN]) {
        const mesh = new THREE.Mesh(geometry, material);
        mesh.matrixAutoUpdate = mesh.frustumCulled = false;
        mesh.matrix.copy(matrix);
        this.veils.add(mesh);
      }
    }
  }
  private drop(name: string): void {
    const old = this.shown.get(name);
    if (!old && this.before && !this.before.has(name)) this.before.set(name, null);
    if (!old) return;
    this.chunks.remove(old);
    this.changed.push(old.geometry.boundingSphere!);
    if (this.before && !this.before.has(name)) this.before.set(name, old);
    else if (this.before?.get(name) !== old) old.geometry.dispose();
    this.shown.delete(name);
    this.shadowsStale = true;
  }

  /** Gives all chunks the chosen wood's material, or another one. */
  dress(material: THREE.Material = this.wood.material): void {
    for (const mesh of this.shown.values()) mesh.material = material;
  }
  /** Shows a body displaced by a motion. Null: at its own position. */
  showMoved(body: number, by: THREE.Matrix4 | null): void {
    for (const [name, mesh] of this.shown)
      if (bodyOf(name) === body) {
        mesh.matrix.copy(by ?? UPRIGHT);
        mesh.matrixWorld.copy(by ?? UPRIGHT);
        // The chunk's bounds do not include the displacement.
        mesh.frustumCulled = by === null;
      }
    this.veil();
    this.shadowsStale = true;
  }

  /** Marks the hidden parts of all chunks. */
  markHidden(): void {
    if (this.hidden.any)
      for (const mesh of [...this.shown.values(), ...(this.before?.values() ?? [])])
        if (mesh) this.hidden.mark(mesh.geometry);
    this.wood.hidesParts = this.hidden.any;
  }

  /** Keeps the current surface, so that hit() can use it during the stroke. */
  beginStroke(): void {
    this.before = new Map();
  }
  endStroke(): void {
    if (!this.before) return;
    for (const [place, mesh] of this.before)
      if (mesh && this.shown.get(place) !== mesh) mesh.geometry.dispose();
    this.before = null;
    this.redraw();
  }
  get inStroke(): boolean {
    return this.before !== null;
  }

  /** The number of triangles of all bodies that are shown. */
  get triangles(): number {
    let count = 0;
    for (const mesh of this.shown.values()) count += mesh.geometry.index!.count / 3;
    return count;
  }
  /** The chunks of the active body in the studio's format, sorted by place. */
  surface(): Uint8Array {
    return pack(
      new Map(
        [...this.shown]
          .filter(([name]) => bodyOf(name) === this.active)
          .map(([name, mesh]) => [name, mesh.geometry]),
      ),
      this.lattice,
    );
  }
  /** The bounds of everything that is shown, or of one body. */
  boxOf(body: number | null): THREE.Box3 {
    const box = new THREE.Box3();
    for (const [name, mesh] of this.shown)
      if (body === null || bodyOf(name) === body) box.union(boundsOf(mesh));
    return box;
  }

  /** Where a ray first meets a body, before the current stroke if `began` is set, else now. */
  hit(ray: THREE.Ray, section: THREE.Plane | null, began: boolean, body: number): Hit | null {
    const before = began ? this.before : null;
    const surface: THREE.BufferGeometry[] = [];
    for (const [name, mesh] of this.shown)
      if (bodyOf(name) === body && !before?.has(name)) surface.push(mesh.geometry);
    if (before)
      for (const [name, mesh] of before)
        if (mesh && bodyOf(name) === body) surface.push(mesh.geometry);
    return firstHit(surface, ray, section, {
      masked: this.wood.hidesMasked,
      parts: this.hidden.any,
    });
  }
  /** The first body that a ray meets. Null: none. */
  bodyAt(ray: THREE.Ray, section: THREE.Plane | null): number | null {
    let nearest = Infinity,
      body: number | null = null;
    for (const id of this.poses.keys()) {
      const far = this.hit(ray, section, false, id)?.point.distanceTo(ray.origin) ?? Infinity;
      if (far < nearest) [nearest, body] = [far, id];
    }
    return body;
  }
  /**
   * The thickness of the wood [mm] under a point of its surface, normal to the surface. The search
   * starts `under` [mm] below it. Null: unknown.
   */
  thickness(at: Hit, under: number): number | null {
    const inward = at.normal.clone().negate(),
      from = at.point.clone().addScaledVector(inward, under);
    const other = this.hit(new THREE.Ray(from, inward), null, false, this.active);
    return other && other.point.distanceTo(at.point);
  }
}
