// SPDX-License-Identifier: MIT
// Draws frames. The solid is drawn into a separate image, completely or only where it has changed.
// Moving objects are drawn over it. If drawing is slow, it draws fewer pixels while the camera
// moves.
import * as THREE from "three";
import type { Cameras } from "./cameras";
import { Coarse } from "./coarse";
import { SolidImage, type Shades } from "./shading";
import type { Solid } from "./solid";

const REST_MS = 350; // time without a change after which a slow machine draws at full quality
const ROUGH = 0.4; // drawn pixels per pixel while the camera moves, if drawing is slow
/** Opacity of the solid while its inside is shown. */
const GHOST = 0.3;

/** True if there is no graphics card. */
function drawnBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2");
  const about = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = probe && about ? String(probe.getParameter(about.UNMASKED_RENDERER_WEBGL)) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

/** The frustum of `part` of a camera's picture, which has w by h pixels. */
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
  /** If true, nothing is drawn. */
  still = false;
  /** Number of drawn frames. */
  frames = 0;
  /** The solid is transparent. */
  ghostly = false;
  /** True: fewer pixels while the camera moves, and shadows only at rest. */
  slow = drawnBySoftware();
  /** Called when the camera has moved. */
  onCamera: () => void = () => undefined;
  private coarse = new Coarse(); // the chunks of low-quality images
  // drawn pixels per pixel; lower if drawing is slow
  private ratio = Math.min(this.slow ? 1 : 2, window.devicePixelRatio);
  private began = 0; // start and end of the last frame
  private ended = 0;
  private late = 0; // number of consecutive slow frames
  private resting = 0; // a timer
  private asked = false; // a frame is requested
  private best: SolidImage;
  private rough: SolidImage;
  private image: SolidImage; // the image that shows the current solid
  // camera of the last image
  private seen = { camera: new THREE.Matrix4(), lens: new THREE.Matrix4() };
  private stale = true; // the whole solid must be drawn

  constructor(
    private canvas: HTMLCanvasElement,
    /** The solid with its light, and the objects that move over it. */
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
    // Shadows are drawn again when their objects change, not when the camera moves.
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
      !this.asked &&
      !this.stale &&
      this.solid.changed.length === 0 &&
      this.image === this.best &&
      !(this.slow && this.solid.shadowsStale)
    );
  }

  /** Resets for another document. */
  begin(): void {
    this.coarse.follow(this.solid.shown, this.solid.lattice);
    this.redrawSolid();
  }

  /** Draws a frame: a moving object, the camera or chunks have changed. */
  redraw(): void {
    if (this.asked || this.still || this.cameras.size) return;
    this.asked = true;
    const asked = performance.now();
    requestAnimationFrame(() => {
      this.asked = false;
      if (this.cameras.size) return;
      const now = performance.now();
      this.adapt(asked, now);
      this.began = now;
      this.render(!this.slow);
      this.ended = performance.now();
      if (this.slow && (this.image !== this.best || this.solid.shadowsStale)) this.refineAtRest();
    });
  }
  /** Draws the whole solid again, because its look has changed. */
  redrawSolid(): void {
    this.stale = true;
    this.redraw();
  }

  /** Draws fewer pixels if frames are slow. */
  private adapt(asked: number, now: number): void {
    const took = now - this.began;
    // The time between two frames measures their cost only if the second was requested right after
    // the first.
    this.late = asked - this.ended < 25 && took > 60 && took < 400 ? this.late + 1 : 0;
    if (this.late < 4) return;
    this.late = 0;
    if (this.ratio > 0.75) this.ratio = Math.max(0.75, 0.8 * this.ratio);
    else this.slow = true;
  }
  private refineAtRest(): void {
    window.clearTimeout(this.resting);
    const rest = (): void => {
      // A stroke is drawn into the image that it began with. A low-quality image is first drawn at
      // full quality.
      if ((this.solid.inStroke && this.image === this.best) || this.still || this.cameras.size)
        this.resting = window.setTimeout(rest, REST_MS);
      else this.render(true);
    };
    this.resting = window.setTimeout(rest, REST_MS);
  }

  /** `whole`: draws the solid at full quality, with current shadows. */
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
    const turned =
      !this.seen.camera.equals(camera.matrixWorld) ||
      !this.seen.lens.equals(camera.projectionMatrix);
    // During a stroke on a slow machine, shadows do not change.
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

  /** Draws the part of the image with the changed chunks. */
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
    // Only chunks that may be visible there are passed to the renderer.
    const frustum = frustumOf(camera, part, w, h);
    for (const mesh of solid.shown.values())
      mesh.visible = frustum.intersectsSphere(mesh.geometry.boundingSphere!);
    this.image.draw(this.scene, camera, shades, part);
    for (const mesh of solid.shown.values()) mesh.visible = true;
  }
  /**
   * The rectangle around all changes, in an image of w by h pixels; null: a part of them is behind
   * the eye.
   */
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
        // A point behind the eye has no position in the window.
        if (!this.cameras.orthographic && at.z > -camera.near) return null;
        at.applyMatrix4(camera.projectionMatrix);
        part.expandByPoint(new THREE.Vector2(((1 + at.x) / 2) * w, ((1 + at.y) / 2) * h));
      }
    return part;
  }
}
