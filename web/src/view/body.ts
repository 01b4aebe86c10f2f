// SPDX-License-Identifier: MIT
// A body of the document, as the studio reports it.
import * as THREE from "three";

export interface Body {
  id: number;
  name: string;
  /** Maps its lattice into the world. */
  matrix: THREE.Matrix4;
  visible: boolean;
  locked: boolean;
  no_go: boolean;
  volume_mm3: number;
}

/** Reads the list of the message Bodies. */
export const readBodies = (json: string): Body[] =>
  (JSON.parse(json) as (Omit<Body, "matrix"> & { pose: number[] })[]).map(
    ({ pose: p, ...body }) => ({
      ...body,
      // prettier-ignore
      matrix: new THREE.Matrix4().set(
        p[3], p[6], p[9], p[0],
        p[4], p[7], p[10], p[1],
        p[5], p[8], p[11], p[2],
        0, 0, 0, 1),
    }),
  );
