// SPDX-License-Identifier: MIT
// Parts of the piece that the user has hidden from view: what lies behind outlines on the screen.
// An outline hides everything along the lines of sight through it, in the view in which it was
// drawn. Only the view changes; the piece stays.
//
// Each vertex gets its signed distance from the outlines in the attribute `hidden`: positive for
// what is hidden. The shader and the picking interpolate it, so an outline stays sharp within
// triangles.
import * as THREE from "three";

export interface ScreenPoint {
  x: number;
  y: number;
}

interface Outline {
  /** From the world to pixels of the window. */
  toScreen: THREE.Matrix4;
  corners: ScreenPoint[];
  bounds: THREE.Box2;
  /** True if everything outside is hidden instead. */
  outside: boolean;
}

/** The distance of what is behind the eye [pixels]. No line of sight reaches it. */
const BEHIND = -1e4;

/** The distance of a point from an outline [pixels], positive inside. */
function depthIn({ corners, bounds }: Outline, x: number, y: number): number {
  const far = Math.max(bounds.min.x - x, x - bounds.max.x, bounds.min.y - y, y - bounds.max.y);
  // Next to the outline's own box the exact distance matters; further away only its sign.
  if (far > 100) return -far;
  let inside = false,
    nearest = Infinity;
  for (let i = 0, j = corners.length - 1; i < corners.length; j = i++) {
    const a = corners[i],
      b = corners[j],
      dx = b.x - a.x,
      dy = b.y - a.y;
    if (a.y > y !== b.y > y && x < a.x + ((y - a.y) / dy) * dx) inside = !inside;
    const share = Math.min(
      1,
      Math.max(0, ((x - a.x) * dx + (y - a.y) * dy) / (dx * dx + dy * dy || 1)),
    );
    nearest = Math.min(nearest, (x - a.x - share * dx) ** 2 + (y - a.y - share * dy) ** 2);
  }
  return (inside ? 1 : -1) * Math.sqrt(nearest);
}

export class HiddenParts {
  private outlines: Outline[] = [];

  get any(): boolean {
    return this.outlines.length > 0;
  }
  add(toScreen: THREE.Matrix4, corners: ScreenPoint[], outside: boolean): void {
    const bounds = new THREE.Box2().setFromPoints(corners.map((p) => new THREE.Vector2(p.x, p.y)));
    this.outlines.push({ toScreen, corners, bounds, outside });
  }
  clear(): void {
    this.outlines = [];
  }

  /** Sets the attribute `hidden` of a chunk whose positions are in the world. */
  mark(chunk: THREE.BufferGeometry): void {
    const { position } = chunk.attributes,
      at = new THREE.Vector4();
    if (!chunk.attributes.hidden)
      chunk.setAttribute("hidden", new THREE.BufferAttribute(new Float32Array(position.count), 1));
    const { hidden } = chunk.attributes;
    for (let i = 0; i < position.count; i++) {
      let deepest = BEHIND;
      for (const outline of this.outlines) {
        at.set(position.getX(i), position.getY(i), position.getZ(i), 1);
        at.applyMatrix4(outline.toScreen);
        const depth = at.w > 0 ? depthIn(outline, at.x / at.w, at.y / at.w) : BEHIND;
        deepest = Math.max(deepest, outline.outside ? -depth : depth);
      }
      hidden.setX(i, deepest);
    }
    hidden.needsUpdate = true;
  }
}
