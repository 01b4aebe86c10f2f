// SPDX-License-Identifier: MIT
// From where one looks: a camera in perspective and a parallel one, how they are turned, and what a
// point of the window means in the world. Z is up, lengths are mm.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Vec3 } from "../base/vec3";

/** The pixels at each edge of the window that something covers. */
export interface Insets {
  left: number;
  right: number;
  top: number;
  bottom: number;
}
export interface Size {
  width: number;
  height: number;
}

const NOTHING: Insets = { left: 0, right: 0, top: 0, bottom: 0 };
const FIELD = 35; // of view [degrees]
const HALF_FIELD = (FIELD * Math.PI) / 360; // [rad]
const TURN_MS = 260;

/** Z is up here; three's spherical coordinates have Y up. */
const asUp = (v: THREE.Vector3): THREE.Vector3 => v.set(v.x, v.z, -v.y);
const asStands = (v: THREE.Vector3): THREE.Vector3 => v.set(v.x, -v.z, v.y);

export class Cameras {
  readonly controls: OrbitControls;
  current: THREE.PerspectiveCamera | THREE.OrthographicCamera;
  /** Whether anything was framed. */
  framed = false;
  /** Of the picture that is taken; null: the canvas has the window's. */
  size: Size | null = null;
  private perspective = new THREE.PerspectiveCamera(FIELD, 1, 1, 5000);
  private parallel = new THREE.OrthographicCamera(-1, 1, 1, -1, 1, 5000);
  private ray = new THREE.Raycaster();
  private covered = NOTHING;
  private radius = 0; // of what was framed
  private share = 1; // of the height, that the free area's breadth is, at most 1: what FIELD is the angle of, by its height
  private half = 1; // of the free area's shorter side, as parallel shows it without zoom [mm]
  private turning = 0; // counts turns of the camera to a view

  constructor(
    private canvas: HTMLCanvasElement,
    private redraw: () => void,
  ) {
    this.current = this.perspective;
    for (const camera of [this.perspective, this.parallel]) camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.current, canvas);
    this.controls.mouseButtons = {
      LEFT: THREE.MOUSE.ROTATE,
      MIDDLE: THREE.MOUSE.ROTATE,
      RIGHT: THREE.MOUSE.ROTATE,
    };
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("start", () => this.turning++);
    this.controls.addEventListener("change", () => this.redraw());
  }

  /** What the view turns about. */
  get target(): THREE.Vector3 {
    return this.controls.target;
  }
  get eye(): Vec3 {
    return this.current.position.toArray() as Vec3;
  }
  /** The size of what is drawn into, in pixels of the window. */
  get drawn(): Size {
    return this.size ?? { width: this.canvas.clientWidth, height: this.canvas.clientHeight };
  }

  // ---- What a point of the window means

  /** The line of sight through a point of the window. */
  rayAt(x: number, y: number): THREE.Ray {
    const r = this.canvas.getBoundingClientRect();
    this.current.updateMatrixWorld();
    this.ray.setFromCamera(
      new THREE.Vector2((2 * (x - r.left)) / r.width - 1, 1 - (2 * (y - r.top)) / r.height),
      this.current,
    );
    return this.ray.ray;
  }
  /** How many mm a pixel of the window is wide at a place. */
  perPixel(at: THREE.Vector3): number {
    const r = this.canvas.getBoundingClientRect(),
      seen = at.clone().project(this.current),
      beside = seen.clone();
    beside.x += 2 / r.width;
    return seen.unproject(this.current).distanceTo(beside.unproject(this.current));
  }
  /** Where the window shows a place. */
  onScreen(place: Vec3): { x: number; y: number } {
    const r = this.canvas.getBoundingClientRect();
    this.current.updateMatrixWorld();
    const at = new THREE.Vector3(...place).project(this.current);
    return { x: r.left + ((1 + at.x) / 2) * r.width, y: r.top + ((1 - at.y) / 2) * r.height };
  }
  /** From a point towards the eye. */
  towardsEye(point: THREE.Vector3): THREE.Vector3 {
    if (this.orthographic)
      return new THREE.Vector3(0, 0, 1).applyQuaternion(this.current.quaternion);
    return this.current.position.clone().sub(point).normalize();
  }
  /** Along a pen that is tilted so from upright on the screen [degrees]. */
  alongPen(tiltX: number, tiltY: number): THREE.Vector3 {
    const tangent = (degrees: number): number =>
      Math.tan((Math.max(-80, Math.min(80, degrees)) * Math.PI) / 180);
    return new THREE.Vector3(tangent(tiltX), -tangent(tiltY), 1)
      .normalize()
      .applyQuaternion(this.current.quaternion);
  }
  /** From the world's frame into the camera's: columns are the camera's right, up and backward. */
  get turned(): THREE.Matrix4 {
    this.current.updateMatrixWorld();
    return new THREE.Matrix4().extractRotation(this.current.matrixWorld);
  }

  // ---- Where the camera is

  /** Shows all of a sphere, seen from this direction. */
  frame({ center, radius }: THREE.Sphere, from: THREE.Vector3): void {
    this.turning++;
    this.fit();
    this.radius = radius;
    const far = (1.15 * radius) / Math.sin(HALF_FIELD) / this.share;
    for (const camera of [this.perspective, this.parallel]) {
      camera.position.copy(center).addScaledVector(from.clone().normalize(), far);
      camera.near = far / 200;
      camera.far = far * 20;
    }
    this.parallel.zoom = 1;
    this.half = far * this.share * Math.tan(HALF_FIELD);
    this.target.copy(center);
    this.fit();
    this.controls.update();
    this.framed = true;
  }

  get orthographic(): boolean {
    return this.current === this.parallel;
  }
  /** What is in the middle keeps its size. */
  set orthographic(on: boolean) {
    if (on === this.orthographic) return;
    this.turning++;
    const way = this.current.position.clone().sub(this.target),
      half = Math.tan(HALF_FIELD);
    let far = way.length() || 1;
    if (on) {
      this.half = half * this.share * far;
      this.parallel.zoom = 1;
      // However near the eye was: what lies behind it would not be seen.
      far = Math.max(far, 4 * this.radius);
    } else far = this.half / this.share / this.parallel.zoom / half;
    this.current = on ? this.parallel : this.perspective;
    this.current.position.copy(this.target).addScaledVector(way.normalize(), far);
    this.controls.object = this.current;
    this.fit();
    this.controls.update();
    this.redraw();
  }

  /**
   * Looks at the middle from there, as far away as before; turned there in a moment, unless the
   * person wants no motion.
   */
  turnTo(from: Vec3): void {
    const turn = ++this.turning,
      start = performance.now();
    const begin = new THREE.Spherical().setFromVector3(
      asUp(this.current.position.clone().sub(this.target)),
    );
    const end = new THREE.Spherical().setFromVector3(asUp(new THREE.Vector3(...from)));
    end.phi = Math.min(Math.PI - 0.001, Math.max(0.001, end.phi));
    // From above and below, the side that is nearer is kept in front.
    if (Math.abs(from[2]) > 0 && from[0] === 0 && from[1] === 0)
      end.theta = Math.round(begin.theta / (Math.PI / 2)) * (Math.PI / 2);
    const around =
      THREE.MathUtils.euclideanModulo(end.theta - begin.theta + Math.PI, 2 * Math.PI) - Math.PI;
    const lasts = matchMedia("(prefers-reduced-motion: reduce)").matches ? 0 : TURN_MS;
    const step = (): void => {
      if (turn !== this.turning) return;
      const share = lasts === 0 ? 1 : Math.min(1, (performance.now() - start) / lasts),
        smooth = share * share * (3 - 2 * share);
      const now = new THREE.Spherical(
        begin.radius,
        begin.phi + smooth * (end.phi - begin.phi),
        begin.theta + smooth * around,
      );
      this.current.position
        .copy(asStands(new THREE.Vector3().setFromSpherical(now)))
        .add(this.target);
      this.controls.update();
      this.redraw();
      if (share < 1) requestAnimationFrame(step);
    };
    step();
  }

  /**
   * Once around the upright axis in `count` places; draw() is called at each until it says false.
   * Then the camera is where it was.
   */
  async aroundOnce(count: number, draw: (index: number) => Promise<boolean>): Promise<void> {
    const about = this.target.clone(),
      from = this.current.position.clone().sub(about);
    this.turning++;
    try {
      for (let i = 0, wanted = true; i < count && wanted; i++) {
        this.current.position
          .copy(from)
          .applyAxisAngle(new THREE.Vector3(0, 0, 1), (2 * Math.PI * i) / count)
          .add(about);
        this.current.lookAt(about);
        wanted = await draw(i);
      }
    } finally {
      this.current.position.copy(from).add(about);
      this.controls.update();
    }
  }

  /** The solid is shown in what these leave free. */
  cover(insets: Insets): void {
    const { left, right, top, bottom } = this.covered;
    if (
      insets.left === left &&
      insets.right === right &&
      insets.top === top &&
      insets.bottom === bottom
    )
      return;
    this.covered = insets;
    this.fit();
    this.redraw();
  }

  /** The solid in the middle of what is not covered. */
  fit(): void {
    const { width: w, height: h } = this.drawn;
    const { left, right, top, bottom } = this.size ? NOTHING : this.covered;
    const wide = w - left - right,
      high = h - top - bottom;
    if (wide <= 0 || high <= 0) return;
    // A turn of the wrist, or a sheet, that leaves less breadth for the height: what was all shown
    // still is. A picture of another shape is for a moment only: there the camera stays where it
    // is.
    const share = Math.min(1, wide / high),
      { perspective, parallel } = this;
    perspective.zoom = this.size ? share / this.share : 1;
    if (!this.size) {
      if (this.framed && !this.orthographic && share !== this.share)
        perspective.position
          .sub(this.target)
          .multiplyScalar(this.share / share)
          .add(this.target);
      this.share = share;
    }
    if (this.orthographic) {
      // Of all the window, so that the solid moves as far as a pointer that moves it.
      parallel.top = (this.half * h) / Math.min(wide, high);
      parallel.right = (this.half * w) / Math.min(wide, high);
      parallel.bottom = -parallel.top;
      parallel.left = -parallel.right;
      parallel.setViewOffset(w, h, (right - left) / 2, (bottom - top) / 2, w, h);
    } else perspective.setViewOffset(wide, high, -left, -top, w, h);
    this.controls.panSpeed = this.orthographic ? 1 : h / high; // in perspective it reckons with the canvas's height
  }
}
