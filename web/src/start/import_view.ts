// SPDX-License-Identifier: MIT
// A preview of the stock that a file becomes, in its final position, on a floor with a grid in mm.
// Z is up, lengths are mm.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import type { Vec3 } from "../base/vec3";
import { Wood, type Material } from "../view/wood";

const CREASE = (35 * Math.PI) / 180; // edges sharper than this are drawn sharp

/**
 * A mesh from the studio. Its longest side is 1, and the lower corner of its bounds is the origin.
 */
export const meshShape = (data: ArrayBuffer): THREE.BufferGeometry =>
  toCreasedNormals(sentShape(data), CREASE);

/** The same for a labelled volume. "kind" of a vertex is the index of its label. */
export function volumeShape(data: ArrayBuffer): THREE.BufferGeometry {
  const [vertices, triangles] = new Uint32Array(data, 0, 2);
  const kinds = new Uint32Array(data, 8 + 12 * (vertices + triangles), vertices);
  const shape = sentShape(data).setAttribute(
    "kind",
    new THREE.BufferAttribute(Float32Array.from(kinds), 1),
  );
  return toCreasedNormals(shape, CREASE);
}

function sentShape(data: ArrayBuffer): THREE.BufferGeometry {
  const [vertices, triangles] = new Uint32Array(data, 0, 2);
  const shape = new THREE.BufferGeometry();
  shape.setAttribute(
    "position",
    new THREE.BufferAttribute(new Float32Array(data, 8, 3 * vertices), 3),
  );
  shape.setIndex(
    new THREE.BufferAttribute(new Uint32Array(data, 8 + 12 * vertices, 3 * triangles), 1),
  );
  return shape;
}

export interface Picture {
  width: number;
  height: number;
  pixels: Float32Array; // rows from the top, 0 to 1
}
export function readPicture(data: ArrayBuffer): Picture {
  const [width, height] = new Uint32Array(data, 0, 2);
  return { width, height, pixels: new Float32Array(data, 8, width * height) };
}

/** A relief of this size [mm], closed like the stock that is made from it. */
export function reliefShape(
  picture: Picture,
  size: Vec3,
  base: number,
  invert: boolean,
): THREE.BufferGeometry {
  const { width: w, height: h, pixels } = picture;
  const at: number[] = [],
    corners: number[] = [];
  for (const floor of [false, true])
    for (let y = 0; y < h; y++)
      for (let x = 0; x < w; x++) {
        const grey = pixels[(h - 1 - y) * w + x];
        at.push(
          (x / (w - 1)) * size[0],
          (y / (h - 1)) * size[1],
          floor ? 0 : base + (size[2] - base) * (invert ? 1 - grey : grey),
        );
      }
  const quad = (a: number, b: number, c: number, d: number): number =>
    corners.push(a, b, c, a, c, d);
  const top = (x: number, y: number): number => y * w + x,
    below = (x: number, y: number): number => w * h + top(x, y);
  for (let y = 0; y + 1 < h; y++)
    for (let x = 0; x + 1 < w; x++) {
      quad(top(x, y), top(x + 1, y), top(x + 1, y + 1), top(x, y + 1));
      quad(below(x, y), below(x, y + 1), below(x + 1, y + 1), below(x + 1, y));
    }
  for (let x = 0; x + 1 < w; x++) {
    quad(below(x, 0), below(x + 1, 0), top(x + 1, 0), top(x, 0));
    quad(below(x + 1, h - 1), below(x, h - 1), top(x, h - 1), top(x + 1, h - 1));
  }
  for (let y = 0; y + 1 < h; y++) {
    quad(below(0, y + 1), below(0, y), top(0, y), top(0, y + 1));
    quad(below(w - 1, y), below(w - 1, y + 1), top(w - 1, y + 1), top(w - 1, y));
  }
  const shape = new THREE.BufferGeometry();
  shape.setAttribute("position", new THREE.Float32BufferAttribute(at, 3));
  shape.setIndex(corners);
  return toCreasedNormals(shape, CREASE);
}

export class ImportView {
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(35, 1, 1, 1000);
  private controls: OrbitControls;
  private wood = new Wood();
  private piece = new THREE.Mesh(new THREE.BufferGeometry(), this.wood.material);
  private sun = new THREE.DirectionalLight(0xfff8ee, 2.3);
  private grid: THREE.GridHelper | null = null;
  private axes = new THREE.AxesHelper(1).setColors(0xd55e00, 0x009e73, 0x0072b2);
  private drawn = true;

  constructor(private canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.wood.material.side = THREE.DoubleSide; // faces of a foreign mesh may be inside out
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = false;
    this.controls.addEventListener("change", () => this.redraw());
    this.scene.add(
      this.piece,
      this.axes,
      this.sun,
      this.sun.target,
      new THREE.HemisphereLight(0xf6f8ff, 0xc4bbb0, 1.75),
    );
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  /** Sets the material of each kind. */
  setWoods(woods: Material[]): void {
    this.wood.setKinds(woods);
    this.redraw();
  }

  /**
   * Shows a shape, rotated and scaled, on the floor. The next call disposes of it. Returns the
   * distance between two grid lines [mm].
   */
  show(shape: THREE.BufferGeometry, turn: THREE.Matrix4, again: boolean): number {
    this.piece.geometry.dispose();
    const piece = shape.clone().applyMatrix4(turn);
    piece.computeBoundingBox();
    const box = piece.boundingBox!,
      size = box.getSize(new THREE.Vector3());
    const middle = box.getCenter(new THREE.Vector3());
    piece.translate(-middle.x, -middle.y, -box.min.z);
    if (!piece.hasAttribute("kind"))
      piece.setAttribute(
        "kind",
        new THREE.BufferAttribute(new Float32Array(piece.attributes.position.count), 1),
      );
    piece.setAttribute(
      "paint",
      new THREE.BufferAttribute(new Uint8Array(4 * piece.attributes.position.count), 4, true),
    );
    piece.computeBoundingSphere();
    this.piece.geometry = piece;
    const longest = Math.max(size.x, size.y, size.z),
      r = 0.5 * size.length();
    this.wood.place(new THREE.Vector3(-0.5 * size.x, -0.5 * size.y, 0), size);
    const target = new THREE.Vector3(0, 0, 0.5 * size.z);
    const from = again
      ? new THREE.Vector3(-0.55, -1, 0.6)
      : this.camera.position.clone().sub(this.controls.target);
    const far =
      (1.08 * r) / Math.sin((this.camera.fov * Math.PI) / 360) / Math.min(1, this.aspect());
    this.camera.position.copy(target).addScaledVector(from.normalize(), far);
    this.camera.near = far / 100;
    this.camera.far = far * 10;
    this.controls.target.copy(target);
    this.controls.update();
    this.sun.position.copy(target).add(new THREE.Vector3(-0.7, -0.45, 1.6).multiplyScalar(3 * r));
    this.sun.target.position.copy(target);
    const apart = 10 ** Math.round(Math.log10(r) - 0.7);
    this.floor(apart, Math.ceil((1.3 * Math.max(size.x, size.y)) / 2 / apart + 1) * apart);
    this.axes.scale.setScalar(0.25 * longest);
    this.axes.position.set(-0.5 * size.x - 0.05 * longest, -0.5 * size.y - 0.05 * longest, 0);
    this.redraw();
    return apart;
  }

  private floor(apart: number, half: number): void {
    if (this.grid) this.scene.remove(this.grid);
    this.grid?.dispose();
    this.grid = new THREE.GridHelper(2 * half, Math.round((2 * half) / apart), 0x8a7a68, 0xb9aca0);
    this.grid.rotation.x = Math.PI / 2;
    (this.grid.material as THREE.Material).transparent = true;
    (this.grid.material as THREE.Material).opacity = 0.6;
    this.scene.add(this.grid);
  }

  private aspect(): number {
    return this.canvas.clientHeight > 0 ? this.canvas.clientWidth / this.canvas.clientHeight : 1;
  }
  private redraw(): void {
    if (!this.drawn) return;
    this.drawn = false;
    requestAnimationFrame(() => {
      this.drawn = true;
      const wide = this.canvas.clientWidth,
        high = this.canvas.clientHeight;
      if (wide === 0 || high === 0) return; // the dialog is closed
      this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
      this.renderer.setSize(wide, high, false);
      this.camera.aspect = wide / high;
      this.camera.updateProjectionMatrix();
      this.renderer.render(this.scene, this.camera);
    });
  }
}
