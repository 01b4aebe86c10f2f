// SPDX-License-Identifier: MIT
// Draws the frames. The solid is drawn into its own image, completely or only where it has changed.
// Moving parts are drawn over it. Slow machines draw fewer pixels while the camera moves.
import * as THREE from "three";
import type { Cameras } from "./cameras";
import { Coarse } from "./coarse";
import { SolidImage, type Shades } from "./shading";
import type { Solid } from "./solid";

const REST_MS = 350; // idle time after which a slow machine draws at full quality
const ROUGH = 0.4; // resolution factor while the camera moves on a slow machine
/** Opacity of the solid while its inside is shown. */
const GHOST = 0.3;

/** True if the browser draws without a graphics card. */
function drawnBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2");
  const about = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = probe && about ? String(probe.getParameter(about.UNMASKED_RENDERER_WEBGL)) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** The frustum of `part` of a camera's picture of w by h pixels. */
function frustumOf(camera: THREE.Camera, part: THREE.Box2, w: number, h: number): THREE.Frustum {
  const size = part.getSize(new THREE.Vector2()),
    middle = part.getCenter(new THREE.Vector2());
  const sx = w / size.x,
    sy = h / size.y;
  // prettier-ignore
  const lens = new THREE.Matrix4().set(
    sx, 0, 0, -sx * ((2 * middle.x) / w - 1),
    0, sy, 0, -sy * ((2 * middle.y) / h - 1),
    0, 0, 1, 0,
    0, 0, 0, 1);
  lens.multiply(camera.projectionMatrix).multiply(camera.matrixWorldInverse);
  return new THREE.Frustum().setFromProjectionMatrix(lens);
}

export class Painter {
  readonly renderer: THREE.WebGLRenderer;
  readonly shades: Shades = { hollows: true, cavity: 0.5, toned: true, reach: 1, section: null };
  /** Stops all drawing. For measurements. */
  still = false;
  /** The number of drawn frames. */
  frames = 0;
  /** True if the solid is transparent. */
  ghostly = false;
  /** True if drawing is slow: fewer pixels while the camera moves, and shadows only at rest. */
  slow = drawnBySoftware();
  /** Called before a frame, when the camera is in its place. */
  beforeSolid: () => void = () => undefined;
  /** Called when the camera has moved. */
  onCamera: () => void = () => undefined;
  private coarse = new Coarse(); // the chunks for rough images
  // Drawn pixels per window pixel; lower where drawing is slow.
  private ratio = Math.min(this.slow ? 1 : 2, window.devicePixelRatio);
  private began = 0; // start and end time of the last frame [ms]
  private ended = 0;
  private late = 0; // consecutive frames that took long
  private resting = 0; // a timer
  private requested = false; // a frame is requested
  private best: SolidImage;
  private rough: SolidImage;
  private image: SolidImage; // the image that shows the current solid
  // The camera of the last drawn solid.
  private seen = { camera: new THREE.Matrix4(), lens: new THREE.Matrix4() };
  private stale = true; // the whole solid must be drawn

  constructor(
    private canvas: HTMLCanvasElement,
    /** `scene` holds the solid and its light. `over` holds the moving parts. */
    private scene: THREE.Scene,
    private over: THREE.Scene,
    private solid: Solid,
    private cameras: Cameras,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, alpha: true });
    this.renderer.autoClear = false;
    this.renderer.localClippingEnabled = true;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = this.slow ? THREE.PCFShadowMap : THREE.PCFSoftShadowMap;
    // Shadows change with the solid and the light, not with the camera.
    this.renderer.shadowMap.autoUpdate = false;
    this.best = new SolidImage(this.renderer, {
      samples: this.slow ? 0 : 4,
      smoothed: this.slow,
      every: this.slow ? 2 : 1,
    });
    this.rough = new SolidImage(this.renderer, { samples: 0, smoothed: false, every: 2 });
    this.image = this.best;
    scene.add(this.coarse.group);
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  /** True if the solid is shown at full quality. */
  get settled(): boolean {
    return (
      !this.requested &&
      !this.stale &&
      this.solid.changed.length === 0 &&
      this.image === this.best &&
      !(this.slow && this.solid.shadowsStale)
    );
  }

  /** Starts with another document. */
  begin(): void {
    this.coarse.follow(this.solid.shown, this.solid.lattice);
    this.redrawSolid();
  }

  /** Requests a frame after moving parts, the camera or chunks have changed. */
  redraw(): void {
    if (this.requested || this.still || this.cameras.size) return;
    this.requested = true;
    const requested = performance.now();
    requestAnimationFrame(() => {
      this.requested = false;
      if (this.cameras.size) return;
      const now = performance.now();
      this.adapt(requested, now);
      this.began = now;
      this.render(!this.slow);
      this.ended = performance.now();
      if (this.slow && (this.image !== this.best || this.solid.shadowsStale)) this.refineAtRest();
    });
  }
  /** Requests a frame that draws the whole solid again. */
  redrawSolid(): void {
    this.stale = true;
    this.redraw();
  }

  /** Reduces the resolution if frames take long. */
  private adapt(requested: number, now: number): void {
    const took = now - this.began;
    // The time between two frames is the time that a frame takes, but only if each is requested
    // right after the previous one.
    this.late = requested - this.ended < 25 && took > 60 && took < 400 ? this.late + 1 : 0;
    if (this.late < 4) return;
    this.late = 0;
    if (this.ratio > 0.75) this.ratio = Math.max(0.75, 0.8 * this.ratio);
    else this.slow = true;
  }
  private refineAtRest(): void {
    window.clearTimeout(this.resting);
    const rest = (): void => {
      // A stroke is drawn into one image from its beginning to its end. Before it, a rough image is
      // drawn again at full quality.
      if ((this.solid.inStroke && this.image === this.best) || this.still || this.cameras.size)
        this.resting = window.setTimeout(rest, REST_MS);
      else this.render(true);
    };
    this.resting = window.setTimeout(rest, REST_MS);
  }

  /** Draws a frame. `whole`: at full quality and with current shadows. */
  render(whole: boolean): void {
    const { cameras, solid } = this,
      ratio = cameras.size ? 1 : this.ratio;
    const w = Math.floor(cameras.drawn.width * ratio),
      h = Math.floor(cameras.drawn.height * ratio);
    if (w === 0 || h === 0) return;
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.renderer.setPixelRatio(1);
      this.renderer.setSize(w, h, false);
      this.stale = true;
    }
    cameras.fit();
    const camera = cameras.current;
    camera.updateMatrixWorld();
    this.beforeSolid();
    const turned =
      !this.seen.camera.equals(camera.matrixWorld) ||
      !this.seen.lens.equals(camera.projectionMatrix);
    // On a slow machine, shadows do not change during a stroke.
    const shadows = solid.shadowsStale && whole;
    if (shadows) {
      this.renderer.shadowMap.needsUpdate = true;
      solid.shadowsStale = false;
    }
    if (turned || this.stale || shadows || (whole && this.image !== this.best)) {
      this.image = whole ? this.best : this.rough;
      const share = whole ? 1 : ROUGH;
      this.image.setSize(Math.ceil(w * share), Math.ceil(h * share));
      if (!whole) this.coarse.follow(solid.shown, solid.lattice);
      this.coarse.group.visible = !whole;
      solid.chunks.visible = whole;
      this.image.draw(this.scene, camera, this.shades, null);
      this.coarse.group.visible = false;
      solid.chunks.visible = true;
    } else if (solid.changed.length > 0) this.drawChanged(w, h);
    this.stale = false;
    solid.changed = [];
    this.seen.camera.copy(camera.matrixWorld);
    this.seen.lens.copy(camera.projectionMatrix);
    this.image.show(this.ghostly ? GHOST : 1);
    this.renderer.render(this.over, camera);
    this.frames++;
    if (turned) this.onCamera();
  }

  /** Draws the part of the image that shows changed chunks. */
  private drawChanged(width: number, height: number): void {
    const { solid, shades } = this,
      camera = this.cameras.current,
      share = this.image === this.best ? 1 : ROUGH,
      w = width * share,
      h = height * share;
    const part = this.changedPart(w, h);
    if (!part) return this.image.draw(this.scene, camera, shades, null);
    part.expandByScalar(3);
    part.intersect(new THREE.Box2(new THREE.Vector2(), new THREE.Vector2(w, h)));
    if (part.isEmpty()) return;
    // Draw only chunks that may be visible there.
    const frustum = frustumOf(camera, part, w, h);
    for (const mesh of solid.shown.values())
      mesh.visible = frustum.intersectsSphere(mesh.geometry.boundingSphere!);
    this.image.draw(this.scene, camera, shades, part);
    for (const mesh of solid.shown.values()) mesh.visible = true;
  }
  /** The bounds of all changes in an image of w by h pixels. Null if a change is behind the eye. */
  private changedPart(w: number, h: number): THREE.Box2 | null {
    const camera = this.cameras.current,
      part = new THREE.Box2(),
      at = new THREE.Vector3();
    for (const { center, radius } of this.solid.changed)
      for (let corner = 0; corner < 8; corner++) {
        at.set(
          corner & 1 ? radius : -radius,
          corner & 2 ? radius : -radius,
          corner & 4 ? radius : -radius,
        );
        at.add(center).applyMatrix4(camera.matrixWorldInverse);
        // Points behind the eye have no position in the window.
        if (!this.cameras.orthographic && at.z > -camera.near) return null;
        at.applyMatrix4(camera.projectionMatrix);
        part.expandByPoint(new THREE.Vector2(((1 + at.x) / 2) * w, ((1 + at.y) / 2) * h));
      }
    return part;
  }
}
