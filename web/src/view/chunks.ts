// SPDX-License-Identifier: MIT
// Unpacks and packs the surface chunks of the studio. See Chunks in protocol/messages.json.
import * as THREE from "three";

/** Cells along each side of a chunk. */
export const CELLS = 16;
const STEPS = 2048;

export interface Lattice {
  origin: [number, number, number];
  pitch: number;
}

/** The corner of the first cell of a chunk. */
export function cornerOf(place: string, { origin, pitch }: Lattice): number[] {
  return place.split(",").map((p, i) => origin[i] + (CELLS * Number(p) - 1) * pitch);
}

/**
 * Calls use(place, geometry) for each chunk. The geometry is null if nothing is left of it. `pose`
 * is the lattice's transform to the world; null: identity.
 */
export function unpack(
  data: Uint8Array,
  lattice: Lattice,
  pose: THREE.Matrix4 | null,
  use: (place: string, made: THREE.BufferGeometry | null) => void,
): void {
  const view = new DataView(data.buffer, data.byteOffset, data.byteLength);
  let at = 0;
  const u16 = (): number => {
    at += 2;
    return view.getUint16(at - 2, true);
  };
  const i16 = (): number => {
    at += 2;
    return view.getInt16(at - 2, true);
  };
  const step = lattice.pitch / STEPS;
  while (at < data.byteLength) {
    const place = [i16(), i16(), i16()];
    const vertices = view.getUint32(at, true);
    const triangles = view.getUint32(at + 4, true);
    const isPainted = view.getUint16(at + 8, true) !== 0;
    at += 10;
    const position = new Float32Array(3 * vertices);
    const normal = new Int8Array(3 * vertices);
    const kind = new Uint8Array(vertices);
    const from = place.map((p, i) => lattice.origin[i] + (CELLS * p - 1) * lattice.pitch);
    for (let v = 0; v < vertices; v++) {
      for (let i = 0; i < 3; i++) position[3 * v + i] = from[i] + step * u16();
      for (let i = 0; i < 3; i++) normal[3 * v + i] = view.getInt8(at + i);
      kind[v] = view.getUint8(at + 3);
      at += 4;
    }
    const index = new Uint16Array(3 * triangles);
    for (let i = 0; i < index.length; i++) index[i] = u16();
    // Red, green, blue, and the mask: see Chunks in messages.ts.
    const paint = new Uint8Array(4 * vertices);
    if (isPainted) {
      paint.set(data.subarray(at, at + paint.length));
      at += paint.length;
    }
    if (triangles === 0) {
      use(place.join(), null);
      continue;
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(position, 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(normal, 3, true));
    geometry.setAttribute("kind", new THREE.BufferAttribute(kind, 1));
    geometry.setAttribute("paint", new THREE.BufferAttribute(paint, 4, true));
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    if (pose) geometry.applyMatrix4(pose);
    geometry.computeBoundingSphere();
    use(place.join(), geometry);
  }
}

/** Packs one body's chunks in the studio's format, sorted by place. */
export function pack(chunks: Map<string, THREE.BufferGeometry>, lattice: Lattice): Uint8Array {
  const placed = [...chunks].map(([name, geometry]) => ({
    place: name.split(",", 3).map(Number),
    geometry,
  }));
  placed.sort(
    (a, b) => a.place[0] - b.place[0] || a.place[1] - b.place[1] || a.place[2] - b.place[2],
  );
  const painted = (geometry: THREE.BufferGeometry): boolean =>
    geometry.attributes.paint.array.some((byte) => byte !== 0);
  const size = placed.reduce(
    (sum, { geometry }) =>
      sum +
      16 +
      (painted(geometry) ? 14 : 10) * geometry.attributes.position.count +
      2 * geometry.index!.count,
    0,
  );
  const bytes = new Uint8Array(size);
  const view = new DataView(bytes.buffer);
  let at = 0;
  const u16 = (value: number): void => {
    view.setUint16(at, value, true);
    at += 2;
  };
  for (const { place, geometry } of placed) {
    const { position, normal, kind, paint } = geometry.attributes;
    const from = place.map((p, i) => lattice.origin[i] + (CELLS * p - 1) * lattice.pitch);
    place.forEach(u16);
    view.setUint32(at, position.count, true);
    view.setUint32(at + 4, geometry.index!.count / 3, true);
    view.setUint16(at + 8, painted(geometry) ? 1 : 0, true);
    at += 10;
    for (let v = 0; v < position.count; v++) {
      for (let i = 0; i < 3; i++)
        u16(Math.round(((position.array[3 * v + i] - from[i]) * STEPS) / lattice.pitch));
      for (let i = 0; i < 3; i++) view.setInt8(at + i, normal.array[3 * v + i]);
      view.setUint8(at + 3, kind.array[v]);
      at += 4;
    }
    for (const corner of geometry.index!.array) u16(corner);
    if (!painted(geometry)) continue;
    bytes.set(paint.array as Uint8Array, at);
    at += paint.array.length;
  }
  return bytes;
}
