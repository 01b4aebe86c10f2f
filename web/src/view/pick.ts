// SPDX-License-Identifier: MIT
// Finds where a ray first meets the chunks of a surface. It tests chunks by their bounds, nearest
// first, and stops at the first hit.
import * as THREE from "three";

export interface Hit {
  point: THREE.Vector3;
  normal: THREE.Vector3;
}

/** The first hit of a ray between `near` and `far` [multiples of its direction]. */
interface Met {
  at: number;
  geometry: THREE.BufferGeometry;
  corners: [number, number, number];
  u: number;
  v: number;
  leaves: boolean; // the ray leaves the solid there
}

// Tolerance at the sides of triangles. Two neighbours compute their common side with different
// rounding, but a ray at this side must hit one of them.
const SLACK = 1e-9;

/** What rays pass through: what is masked, and the parts that the user has hidden. */
export interface Passes {
  masked: boolean;
  parts: boolean;
}

/** The mask at a point of a triangle, 0 to 1. The fourth byte of the paint holds it (color.h). */
function maskAt(geometry: THREE.BufferGeometry, corners: number[], u: number, v: number): number {
  const paint = geometry.attributes.paint.array;
  const [a, b, c] = corners.map((corner) => {
    const high = paint[4 * corner + 3];
    return (high > 127 ? 255 - high : high) / 127;
  });
  return (1 - u - v) * a + u * b + v * c;
}

/** How far a point of a triangle is within hidden parts: see hidden_parts.ts. */
function hiddenAt(geometry: THREE.BufferGeometry, corners: number[], u: number, v: number): number {
  const [a, b, c] = corners.map((corner) => geometry.attributes.hidden.array[corner]);
  return (1 - u - v) * a + u * b + v * c;
}

function meet(
  geometry: THREE.BufferGeometry,
  ray: THREE.Ray,
  near: number,
  far: number,
  passes: Passes,
): Met | null {
  const p = geometry.attributes.position.array,
    index = geometry.index!.array;
  const { x: ox, y: oy, z: oz } = ray.origin,
    { x: dx, y: dy, z: dz } = ray.direction;
  let met: Met | null = null;
  for (let i = 0; i < index.length; i += 3) {
    const a = 3 * index[i],
      b = 3 * index[i + 1],
      c = 3 * index[i + 2];
    const e1x = p[b] - p[a],
      e1y = p[b + 1] - p[a + 1],
      e1z = p[b + 2] - p[a + 2];
    const e2x = p[c] - p[a],
      e2y = p[c + 1] - p[a + 1],
      e2z = p[c + 2] - p[a + 2];
    const hx = dy * e2z - dz * e2y,
      hy = dz * e2x - dx * e2z,
      hz = dx * e2y - dy * e2x;
    const det = e1x * hx + e1y * hy + e1z * hz; // positive if the ray enters the solid
    if (det === 0) continue;
    const sx = ox - p[a],
      sy = oy - p[a + 1],
      sz = oz - p[a + 2];
    const u = (sx * hx + sy * hy + sz * hz) / det;
    if (u < -SLACK || u > 1 + SLACK) continue;
    const qx = sy * e1z - sz * e1y,
      qy = sz * e1x - sx * e1z,
      qz = sx * e1y - sy * e1x;
    const v = (dx * qx + dy * qy + dz * qz) / det;
    if (v < -SLACK || u + v > 1 + SLACK) continue;
    const at = (e2x * qx + e2y * qy + e2z * qz) / det;
    if (at < near || at >= far) continue;
    const corners: [number, number, number] = [index[i], index[i + 1], index[i + 2]];
    if (passes.masked && maskAt(geometry, corners, u, v) > 0.5) continue;
    if (passes.parts && hiddenAt(geometry, corners, u, v) > 0) continue;
    far = at;
    met = { at, geometry, corners, u, v, leaves: det < 0 };
  }
  return met;
}

/**
 * The first hit of a ray, or null. A section removes everything on its normal's negative side. The
 * cut counts as a face.
 */
export function firstHit(
  surface: Iterable<THREE.BufferGeometry>,
  ray: THREE.Ray,
  section: THREE.Plane | null,
  passes: Passes,
): Hit | null {
  let near = 0,
    far = Infinity;
  if (section) {
    const height = section.distanceToPoint(ray.origin),
      climb = section.normal.dot(ray.direction);
    if (height < 0 && climb <= 0) return null;
    if (height < 0) near = -height / climb;
    else if (climb < 0) far = -height / climb;
  }
  const { origin: o, direction: d } = ray;
  const candidates: { from: number; geometry: THREE.BufferGeometry }[] = [];
  for (const geometry of surface) {
    const { center: c, radius } = geometry.boundingSphere!;
    const x = c.x - o.x,
      y = c.y - o.y,
      z = c.z - o.z,
      along = x * d.x + y * d.y + z * d.z;
    const aside = x * x + y * y + z * z - along * along,
      half = radius * radius - aside;
    if (half < 0) continue;
    const reach = Math.sqrt(half);
    if (along + reach >= near && along - reach < far)
      candidates.push({ from: along - reach, geometry });
  }
  candidates.sort((a, b) => a.from - b.from);
  let met: Met | null = null;
  for (const { from, geometry } of candidates) {
    if (from >= far) break;
    const nearer = meet(geometry, ray, near, far, passes);
    if (nearer) far = (met = nearer).at;
  }
  if (!met) return null;
  // The first hit leaves the solid, so the ray entered through the section.
  if (section && near > 0 && met.leaves)
    return { point: ray.at(near, new THREE.Vector3()), normal: section.normal.clone().negate() };
  const normals = met.geometry.attributes.normal,
    weights = [1 - met.u - met.v, met.u, met.v];
  const normal = new THREE.Vector3();
  met.corners.forEach((corner, k) =>
    normal.add(new THREE.Vector3().fromBufferAttribute(normals, corner).multiplyScalar(weights[k])),
  );
  normal.normalize();
  if (normal.dot(d) > 0) normal.negate();
  return { point: ray.at(met.at, new THREE.Vector3()), normal };
}
