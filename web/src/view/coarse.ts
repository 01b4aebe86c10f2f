// SPDX-License-Identifier: MIT
// The solid with fewer triangles, for machines without a graphics card while the camera moves. In
// each chunk, one vertex replaces its neighbours. Vertices at the chunk's edge stay, because the
// next chunk has them too. So no cracks open.
import * as THREE from "three";
import { CELLS, cornerOf, type Lattice } from "./chunks";

const WIDE = 3; // cells along each side of the cube that is drawn as one vertex
// such cubes along each side of a chunk, including cells shared with neighbours
const PLACES = Math.ceil((CELLS + 1) / WIDE);

/**
 * `corner`: corner of the chunk's first cell. `pitch`: side of a cell [mm]. For a rotated chunk,
 * both are those of its bounding box. The attributes are those of `fine`.
 */
function coarser(
  fine: THREE.BufferGeometry,
  corner: number[],
  pitch: number,
): THREE.BufferGeometry {
  const position = fine.attributes.position.array,
    index = fine.index!.array;
  // the vertex that replaces each vertex
  const stands = new Uint16Array(fine.attributes.position.count);
  const first = new Int32Array(PLACES ** 3).fill(-1);
  // Around an interior vertex, each neighbour is once the next corner and once the previous one.
  const open = new Int32Array(stands.length);
  for (let i = 0; i < index.length; i += 3)
    for (let k = 0; k < 3; k++)
      open[index[i + k]] += index[i + ((k + 1) % 3)] - index[i + ((k + 2) % 3)];
  for (let v = 0; v < stands.length; v++) {
    if (open[v] !== 0) {
      stands[v] = v;
      continue;
    }
    let place = 0;
    for (let i = 0; i < 3; i++) {
      const cell = (position[3 * v + i] - corner[i]) / pitch;
      place = place * PLACES + Math.min(PLACES - 1, Math.max(0, Math.floor(cell / WIDE)));
    }
    if (first[place] < 0) first[place] = v;
    stands[v] = first[place];
  }
  const corners: number[] = [];
  for (let i = 0; i < index.length; i += 3) {
    const a = stands[index[i]],
      b = stands[index[i + 1]],
      c = stands[index[i + 2]];
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
  private made = new Map<THREE.Mesh, THREE.Mesh>(); // by visible chunk

  constructor() {
    this.group.visible = this.group.matrixWorldAutoUpdate = false;
  }

  /** Makes the coarse chunks. Reuses those of unchanged chunks. */
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
    }
    for (const mesh of gone) {
      const coarse = this.made.get(mesh)!;
      this.group.remove(coarse);
      coarse.geometry.dispose();
      this.made.delete(mesh);
    }
  }
}
