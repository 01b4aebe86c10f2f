// SPDX-License-Identifier: MIT
// The cameras: a perspective and a parallel one. This file moves them and converts points of the
// window to the world. Z is up. Lengths are in mm.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Vec3 } from "../base/vec3";

/** The pixels at each edge of the window that panels cover. */
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

/** Converts between our z-up frame and three's spherical coordinates, which are y-up. */
const asUp = (v: THREE.Vector3): THREE.Vector3 => v.set(v.x, v.z, -v.y);
const zUp = (v: THREE.Vector3): THREE.Vector3 => v.set(v.x, -v.z, v.y);

export class Cameras {
  readonly controls: OrbitControls;
  current: THREE.PerspectiveCamera | THREE.OrthographicCamera;
  /** True if anything was framed. */
  framed = false;
  /** The size of a picture that is being taken. Null: the canvas has the window's size. */
  size: Size | null = null;
  private perspective = new THREE.PerspectiveCamera(FIELD, 1, 1, 5000);
  private parallel = new THREE.OrthographicCamera(-1, 1, 1, -1, 1, 5000);
  private ray = new THREE.Raycaster();
  private covered = NOTHING;
  private radius = 0; // of the framed sphere
  // The free area's width divided by its height, at most 1. FIELD spans this share of the area's
  // height.
  private share = 1;
  private half = 1; // half of the free area's shorter side at zoom 1 in the parallel camera [mm]
  private turning = 0; // counts camera turns, to cancel older ones

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

  /** The point about which the view turns. */
  get target(): THREE.Vector3 {
    return this.controls.target;
  }
  get eye(): Vec3 {
    return this.current.position.toArray() as Vec3;
  }
  /** The size of the drawing, in pixels of the window. */
  get drawn(): Size {
    return this.size ?? { width: this.canvas.clientWidth, height: this.canvas.clientHeight };
  }

  // ---- Points of the window

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
  /** The width of one window pixel at a position [mm]. */
  perPixel(at: THREE.Vector3): number {
    const r = this.canvas.getBoundingClientRect(),
      seen = at.clone().project(this.current),
      nextPixel = seen.clone();
    nextPixel.x += 2 / r.width;
    return seen.unproject(this.current).distanceTo(nextPixel.unproject(this.current));
  }
  /** Where the window shows a position. */
  onScreen(place: Vec3): { x: number; y: number } {
    const r = this.canvas.getBoundingClientRect();
    this.current.updateMatrixWorld();
    const at = new THREE.Vector3(...place).project(this.current);
    return { x: r.left + ((1 + at.x) / 2) * r.width, y: r.top + ((1 - at.y) / 2) * r.height };
  }
  /** The transform from the world to points of the window, in homogeneous coordinates. */
  get toScreen(): THREE.Matrix4 {
    const { left, top, width, height } = this.canvas.getBoundingClientRect(),
      { current } = this;
    current.updateMatrixWorld();
    // prettier-ignore
    return new THREE.Matrix4(
      width / 2, 0, 0, left + width / 2,
      0, -height / 2, 0, top + height / 2,
      0, 0, 1, 0,
      0, 0, 0, 1,
    )
      .multiply(current.projectionMatrix)
      .multiply(current.matrixWorldInverse);
  }
  /** The direction from a point towards the eye. */
  towardsEye(point: THREE.Vector3): THREE.Vector3 {
    if (this.orthographic)
      return new THREE.Vector3(0, 0, 1).applyQuaternion(this.current.quaternion);
    return this.current.position.clone().sub(point).normalize();
  }
  /** The direction of a pen with these tilts from upright on the screen [degrees]. */
  alongPen(tiltX: number, tiltY: number): THREE.Vector3 {
    const tangent = (degrees: number): number =>
      Math.tan((Math.max(-80, Math.min(80, degrees)) * Math.PI) / 180);
    return new THREE.Vector3(tangent(tiltX), -tangent(tiltY), 1)
      .normalize()
      .applyQuaternion(this.current.quaternion);
  }
  /** The camera's rotation. Its columns are the camera's right, up and backward in the world. */
  get turned(): THREE.Matrix4 {
    this.current.updateMatrixWorld();
    return new THREE.Matrix4().extractRotation(this.current.matrixWorld);
  }

  // ---- Camera position

  /** Shows a whole sphere from a direction. */
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

  /** Puts the eye and the point about which the view turns to these positions [mm]. */
  place(eye: Vec3, target: Vec3): void {
    this.turning++;
    this.current.position.fromArray(eye);
    this.target.fromArray(target);
    this.controls.update();
    this.redraw();
  }

  get orthographic(): boolean {
    return this.current === this.parallel;
  }
  /** Switches the projection. Objects in the centre keep their size on the screen. */
  set orthographic(on: boolean) {
    if (on === this.orthographic) return;
    this.turning++;
    const direction = this.current.position.clone().sub(this.target),
      half = Math.tan(HALF_FIELD);
    let far = direction.length() || 1;
    if (on) {
      this.half = half * this.share * far;
      this.parallel.zoom = 1;
      // Move back if the eye was close. Otherwise parts of the solid would be behind the camera.
      far = Math.max(far, 4 * this.radius);
    } else far = this.half / this.share / this.parallel.zoom / half;
    this.current = on ? this.parallel : this.perspective;
    this.current.position.copy(this.target).addScaledVector(direction.normalize(), far);
    this.controls.object = this.current;
    this.fit();
    this.controls.update();
    this.redraw();
  }

  /**
   * Turns to this view direction at the same distance. The turn is animated unless the user prefers
   * reduced motion.
   */
  turnTo(from: Vec3): void {
    const turn = ++this.turning,
      start = performance.now();
    const begin = new THREE.Spherical().setFromVector3(
      asUp(this.current.position.clone().sub(this.target)),
    );
    const end = new THREE.Spherical().setFromVector3(asUp(new THREE.Vector3(...from)));
    end.phi = Math.min(Math.PI - 0.001, Math.max(0.001, end.phi));
    // For views from above and below: the side that was nearest to the viewer stays at the bottom
    // of the picture.
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
      this.current.position.copy(zUp(new THREE.Vector3().setFromSpherical(now))).add(this.target);
      this.controls.update();
      this.redraw();
      if (share < 1) requestAnimationFrame(step);
    };
    step();
  }

  /**
   * Moves the camera once around the upright axis in `count` steps. Calls draw() at each step until
   * it returns false. Then restores the camera.
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

  /** Fits the solid into the area that these insets leave free. */
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

  /** Centres the solid in the free area. */
  fit(): void {
    const { width: w, height: h } = this.drawn;
    const { left, right, top, bottom } = this.size ? NOTHING : this.covered;
    const wide = w - left - right,
      high = h - top - bottom;
    if (wide <= 0 || high <= 0) return;
    // If the free area becomes narrower for its height, move back so that everything stays visible.
    // A picture of another shape is temporary, so the camera stays.
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
      // The parallel camera covers the whole window, so that the solid follows a pointer exactly.
      parallel.top = (this.half * h) / Math.min(wide, high);
      parallel.right = (this.half * w) / Math.min(wide, high);
      parallel.bottom = -parallel.top;
      parallel.left = -parallel.right;
      parallel.setViewOffset(w, h, (right - left) / 2, (bottom - top) / 2, w, h);
    } else perspective.setViewOffset(wide, high, -left, -top, w, h);
    // The perspective camera uses the canvas's height.
    this.controls.panSpeed = this.orthographic ? 1 : h / high;
  }
}
