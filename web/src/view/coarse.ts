// SPDX-License-Identifier: MIT
// A solid with fewer triangles, for machines without a graphics card while the camera moves. In
// each chunk, one vertex replaces the vertices near it. Vertices at a chunk's edge stay, because
// the neighbouring chunk has them, too. So there is no gap between chunks.
import * as THREE from "three";
import { CELLS, cornerOf, type Lattice } from "./chunks";

const WIDE = 3; // cells along each side that one vertex replaces
// Number of replacing vertices along each side. A chunk also has vertices in the last cell of the
// chunk before it.
const PLACES = Math.ceil((CELLS + 1) / WIDE);

/**
 * Makes a coarser chunk. `corner` is the corner of its first cell and `pitch` a cell's side [mm].
 * For a rotated chunk they describe its bounding box. The attributes are shared with `fine`.
 */
function coarser(
  fine: THREE.BufferGeometry,
  corner: number[],
  pitch: number,
): THREE.BufferGeometry {
  const position = fine.attributes.position.array,
    index = fine.index!.array;
  // For each vertex the vertex that replaces it.
  const same = new Uint16Array(fine.attributes.position.count);
  const first = new Int32Array(PLACES ** 3).fill(-1);
  // If triangles surround a vertex, each neighbour occurs once as the next and once as the previous
  // vertex. Then `open` is 0.
  const open = new Int32Array(same.length);
  for (let i = 0; i < index.length; i += 3)
    for (let k = 0; k < 3; k++)
      open[index[i + k]] += index[i + ((k + 1) % 3)] - index[i + ((k + 2) % 3)];
  for (let v = 0; v < same.length; v++) {
    if (open[v] !== 0) {
      same[v] = v;
      continue;
    }
    let place = 0;
    for (let i = 0; i < 3; i++) {
      const cell = (position[3 * v + i] - corner[i]) / pitch;
      place = place * PLACES + Math.min(PLACES - 1, Math.max(0, Math.floor(cell / WIDE)));
    }
    if (first[place] < 0) first[place] = v;
    same[v] = first[place];
  }
  const corners: number[] = [];
  for (let i = 0; i < index.length; i += 3) {
    const a = same[index[i]],
      b = same[index[i + 1]],
      c = same[index[i + 2]];
    if (a !== b && b !== c && c !== a) corners.push(a, b, c);
  }
  const made = new THREE.BufferGeometry();
  for (const [name, attribute] of Object.entries(fine.attributes))
    made.setAttribute(name, attribute);
  made.setIndex(new THREE.BufferAttribute(new Uint16Array(corners), 1));
  made.boundingSphere = fine.boundingSphere;
  return made;
}

function aroundTurned(geometry: THREE.BufferGeometry): [number[], number] {
  geometry.computeBoundingBox();
  const { min, max } = geometry.boundingBox!;
  const longest = Math.max(max.x - min.x, max.y - min.y, max.z - min.z);
  return [min.toArray(), longest / (PLACES * WIDE) || 1];
}

export class Coarse {
  readonly group = new THREE.Group();
  private made = new Map<THREE.Mesh, THREE.Mesh>(); // by the shown chunk

  constructor() {
    this.group.visible = this.group.matrixWorldAutoUpdate = false;
  }

  /** Makes coarse meshes for these chunks. Reuses those that exist. */
  follow(chunks: Map<string, THREE.Mesh>, lattice: Lattice): void {
    const gone = new Set(this.made.keys());
    for (const [place, mesh] of chunks) {
      gone.delete(mesh);
      let coarse = this.made.get(mesh);
      if (!coarse) {
        coarse = new THREE.Mesh(
          mesh.userData.turned
            ? coarser(mesh.geometry, ...aroundTurned(mesh.geometry))
            : coarser(mesh.geometry, cornerOf(place, lattice), lattice.pitch),
        );
        coarse.receiveShadow = true;
        coarse.matrixAutoUpdate = false;
        this.made.set(mesh, coarse);
        this.group.add(coarse);
      }
      coarse.material = mesh.material;
      // Set only after the user has hidden something.
      const { hidden } = mesh.geometry.attributes;
      if (hidden) coarse.geometry.setAttribute("hidden", hidden);
    }
    for (const mesh of gone) {
      const coarse = this.made.get(mesh)!;
      this.group.remove(coarse);
      coarse.geometry.dispose();
      this.made.delete(mesh);
    }
  }
}
