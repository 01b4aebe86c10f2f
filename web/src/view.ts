// SPDX-License-Identifier: MIT
// The solid, the tool and the light. Z is up, lengths are mm.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { pack, unpack, type Lattice } from "./chunks";
import { Coarse } from "./coarse";
import type { Insets } from "./layout";
import type { Body } from "./bodies";
import { firstHit, type Hit } from "./pick";
import { SolidImage, type Shades } from "./shading";
import { Thumbnails } from "./thumbnails";
import { ToolFigure } from "./tool_figure";
import type { HeldTool } from "./tools";
import { WheelHead } from "./wheel_head";
import type { Vec3 } from "./wire";
import { Wood, type Shading } from "./wood";

export type { Hit } from "./pick";

/** Whether there is no graphics card to draw with. */
function drawnBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2");
  const about = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = probe && about ? String(probe.getParameter(about.UNMASKED_RENDERER_WEBGL)) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

const PICTURED = 1; // the layer of what thumbnails show
/** Where one looks from when a document is opened. */
const HOME = new THREE.Vector3(-0.55, -1, 0.75);
const NOTHING: Insets = { left: 0, right: 0, top: 0, bottom: 0 };
const FIELD = 35; // of view [degrees]
const REST_MS = 350; // without a change, after which a slow machine draws as well as it can
const ROUGH = 0.4; // pixels a pixel, where drawing is slow and the camera moves
const TURN_MS = 260;
/** Of the solid, where what is inside is shown. */
const GHOST = 0.3;
/** Of what is hidden, drawn over it; where two bodies have one face, neither hides the other. */
const VEIL = new THREE.MeshBasicMaterial({
  color: 0x0072b2,
  transparent: true,
  opacity: 0.3,
  depthFunc: THREE.GreaterDepth,
  depthWrite: false,
  polygonOffset: true,
  polygonOffsetFactor: -4,
  polygonOffsetUnits: -64,
});

/** Of what is no-go, where it is seen. */
const SKIN = new THREE.MeshBasicMaterial({
  color: 0x0072b2,
  transparent: true,
  opacity: 0.35,
  depthWrite: false,
  polygonOffset: true,
  polygonOffsetFactor: -4,
  polygonOffsetUnits: -64,
});

/** What a picture is of. Background: a colour of CSS; null for transparent. */
export interface Capture {
  width: number;
  height: number;
  background: string | null;
}

export class View {
  readonly controls: OrbitControls;
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene(); // the solid and its light
  private over = new THREE.Scene(); // what moves over it
  private perspective = new THREE.PerspectiveCamera(FIELD, 1, 1, 5000);
  private parallel = new THREE.OrthographicCamera(-1, 1, 1, -1, 1, 5000);
  private camera: THREE.PerspectiveCamera | THREE.OrthographicCamera = this.perspective;
  private chunks = new THREE.Group();
  private noGo = new Set<number>(); // bodies
  private veils = new THREE.Group(); // and what shows them
  /** By place and body: see nameOf. */
  private shown = new Map<string, THREE.Mesh>();
  private poses = new Map<number, THREE.Matrix4>(); // of bodies that are shown
  private active = 1;
  private lattice: Lattice = { origin: [0, 0, 0], pitch: 1 };
  private coarse = new Coarse(); // the chunks, for rough images
  // What a chunk was when the stroke began: depth is taken from there, so that the tool does not
  // sink by itself. null: there was none.
  private before: Map<string, THREE.Mesh | null> | null = null;
  readonly wood = new Wood();
  private tool = new ToolFigure(() => this.redraw());
  private secondTool = new ToolFigure(() => this.redraw());
  private wheel = new WheelHead();
  private ring: THREE.Mesh;
  private sun = new THREE.DirectionalLight(0xfff8ee, 2.3);
  private sunFrom = new THREE.Vector3();
  private grid: THREE.GridHelper | null = null;
  private ray = new THREE.Raycaster();
  private box = new THREE.Box3(); // of the solid, as it was framed
  private piece = new THREE.Box3(); // what the solid is cut from
  private framed = false;
  private ratio = Math.min(2, window.devicePixelRatio); // pixels a pixel; fewer where drawing is slow
  private began = 0; // the last frame, and when it was drawn
  private ended = 0;
  private late = 0; // frames that took long, one right after the other
  private share = 1; // of the height, that the free area's breadth is, at most 1: what FIELD is the angle of, by its height
  private half = 1; // of the free area's shorter side, as parallel shows it without zoom [mm]
  private slow: boolean; // while the camera moves there are fewer pixels, and shadows are drawn anew at rest
  /** Nothing is drawn. */
  still = false;
  /** How many frames were drawn. */
  frames = 0;
  private covered = NOTHING;
  private thumbnails: Thumbnails;
  private resting = 0;
  private drawn = false;
  private planes = new THREE.Group();
  private level = new THREE.Mesh(
    new THREE.PlaneGeometry(1, 1),
    new THREE.MeshBasicMaterial({
      color: 0x0072b2,
      transparent: true,
      opacity: 0.14,
      side: THREE.DoubleSide,
      depthWrite: false,
    }),
  );
  private shades: Shades = { hollows: true, cavity: 0.5, toned: true, reach: 1, section: null };
  private best: SolidImage;
  private rough: SolidImage;
  private image: SolidImage; // the one that shows the solid as it is
  private seen = { camera: new THREE.Matrix4(), lens: new THREE.Matrix4() }; // how the solid was drawn last
  private stale = true; // the solid is to be drawn, all of it
  private changed: THREE.Sphere[] = []; // or only what is there
  private turning = 0; // counts turns of the camera to a view
  /** Called when the camera stands elsewhere. */
  onCamera: () => void = () => undefined;

  constructor(private canvas: HTMLCanvasElement) {
    this.slow = drawnBySoftware();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false, alpha: true });
    this.renderer.autoClear = false;
    this.renderer.localClippingEnabled = true;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = this.slow ? THREE.PCFShadowMap : THREE.PCFSoftShadowMap;
    if (this.slow) this.ratio = Math.min(1, this.ratio);
    // Shadows are drawn anew when what throws them changes, not when the camera moves.
    this.renderer.shadowMap.autoUpdate = false;
    this.best = new SolidImage(this.renderer, {
      samples: this.slow ? 0 : 4,
      smoothed: this.slow,
      every: this.slow ? 2 : 1,
    });
    this.rough = new SolidImage(this.renderer, { samples: 0, smoothed: false, every: 2 });
    this.image = this.best;
    for (const camera of [this.perspective, this.parallel]) camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.mouseButtons = {
      LEFT: THREE.MOUSE.ROTATE,
      MIDDLE: THREE.MOUSE.ROTATE,
      RIGHT: THREE.MOUSE.ROTATE,
    };
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("start", () => this.turning++);
    this.controls.addEventListener("change", () => this.redraw());
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.setScalar(this.slow ? 1024 : 2048);
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.15;
    const ringShape = new THREE.RingGeometry(0.94, 1, 64);
    this.ring = new THREE.Mesh(
      ringShape,
      new THREE.MeshBasicMaterial({
        color: 0x0072b2,
        side: THREE.DoubleSide,
        depthTest: false,
        transparent: true,
      }),
    );
    this.ring.visible = false;
    this.ring.renderOrder = 2;
    this.chunks.matrixWorldAutoUpdate = false;
    const sky = new THREE.HemisphereLight(0xf6f8ff, 0xc4bbb0, 1.75);
    this.scene.add(this.chunks, this.coarse.group, this.sun, this.sun.target, sky);
    const lamp = new THREE.DirectionalLight(0xffffff, 2.4);
    lamp.position.set(-0.7, -0.45, 1.6);
    this.level.visible = false;
    sky.layers.enable(PICTURED);
    this.over.add(
      this.veils,
      this.planes,
      this.level,
      this.tool.group,
      this.secondTool.group,
      this.wheel.group,
      this.ring,
      this.aids,
      lamp,
      new THREE.HemisphereLight(0xffffff, 0xb5a48f, 1.7),
    );
    this.aids.add(this.folds);
    this.thumbnails = new Thumbnails(this.scene, this.sun, PICTURED);
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  /** again: of the document that is shown; it is looked at from where it was. */
  begin(lattice: Lattice, nodes: Vec3, again = false): void {
    const before = this.lattice;
    const same =
      again &&
      lattice.pitch === before.pitch &&
      lattice.origin.every((x, i) => x === before.origin[i]);
    for (const mesh of this.shown.values()) mesh.geometry.dispose();
    this.shown.clear();
    this.chunks.clear();
    this.poses.clear();
    this.active = 1;
    this.lattice = lattice;
    this.coarse.follow(this.shown, lattice);
    this.endStroke();
    this.framed &&= same;
    this.whole = false;
    this.ring.visible = false;
    this.tool.hide();
    this.secondTool.hide();
    this.showWheel(false, false);
    const size = nodes.map((n) => n * lattice.pitch);
    for (const frame of this.planes.children as THREE.LineLoop[]) {
      frame.geometry.dispose();
      (frame.material as THREE.Material).dispose();
    }
    this.planes.clear();
    for (let i = 0; i < 3; i++) {
      const [u, v] = [size[(i + 1) % 3], size[(i + 2) % 3]];
      const frame = new THREE.LineLoop(
        new THREE.BufferGeometry().setFromPoints(
          [
            [-u, -v],
            [u, -v],
            [u, v],
            [-u, v],
          ].map(([a, b]) =>
            new THREE.Vector3().setComponent((i + 1) % 3, a / 2).setComponent((i + 2) % 3, b / 2),
          ),
        ),
        new THREE.LineBasicMaterial({ color: 0x0072b2 }),
      );
      frame.position.set(
        ...(lattice.origin.map((o, k) => o + (lattice.pitch * nodes[k]) / 2) as Vec3),
      );
      frame.visible = false;
      this.planes.add(frame);
    }
    this.piece.min.set(...lattice.origin);
    this.piece.max.copy(this.piece.min).add(new THREE.Vector3(...(size as Vec3)));
    this.thumbnails.place(this.piece, HOME);
    this.wood.place(this.piece.min, this.piece.getSize(new THREE.Vector3()));
    this.redrawSolid();
  }

  /** Which bodies there are: chunks of those that are gone, hidden or moved are no more. */
  setBodies(bodies: Body[], active: number): void {
    const poses = new Map(bodies.filter((b) => b.visible).map((b) => [b.id, b.matrix]));
    for (const [id, pose] of this.poses)
      if (!poses.get(id)?.equals(pose))
        for (const name of [...this.shown.keys()]) if (bodyOf(name) === id) this.drop(name);
    this.poses = poses;
    this.active = active;
    this.noGo = new Set(bodies.filter((b) => b.no_go).map((b) => b.id));
    this.veil();
    this.redraw();
  }

  /** Takes a frame of chunks of a body in. */
  take(data: Uint8Array, body: number): void {
    const pose = this.poses.get(body);
    if (!pose) return; // it is hidden since
    const turned = !pose.equals(UPRIGHT);
    this.whole = false;
    unpack(data, this.lattice, turned ? pose : null, (place, made) => {
      const name = nameOf(place, body);
      this.drop(name);
      if (!made) return;
      const mesh = new THREE.Mesh(made, this.wood.material);
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.matrixAutoUpdate = false;
      mesh.userData.turned = turned;
      mesh.layers.enable(PICTURED);
      this.changed.push(made.boundingSphere!);
      this.shown.set(name, mesh);
      this.chunks.add(mesh);
    });
    this.moved = true;
    if (this.noGo.has(body)) this.veil();
    this.redraw();
  }
  /** What is no-go is blue, and seen through all that is before it. */
  private veil(): void {
    this.veils.clear();
    for (const [name, { geometry, matrix }] of this.shown) {
      if (!this.noGo.has(bodyOf(name))) continue;
      for (const material of [VEIL, SKIN]) {
        const mesh = new THREE.Mesh(geometry, material);
        mesh.matrixAutoUpdate = mesh.frustumCulled = false;
        mesh.matrix.copy(matrix);
        this.veils.add(mesh);
      }
    }
  }
  private drop(name: string): void {
    const old = this.shown.get(name);
    if (!old && this.before && !this.before.has(name)) this.before.set(name, null);
    if (!old) return;
    this.chunks.remove(old);
    this.changed.push(old.geometry.boundingSphere!);
    if (this.before && !this.before.has(name)) this.before.set(name, old);
    else if (this.before?.get(name) !== old) old.geometry.dispose();
    this.shown.delete(name);
    this.moved = true;
  }
  private moved = false; // what throws shadows has changed since they were drawn

  /** All chunks are there. */
  complete(): void {
    this.whole = true;
    if (!this.framed) this.frame();
  }
  /** Whether all of the solid is shown that there is. */
  whole = false;
  /** Whether it is shown as well as it can be. */
  get settled(): boolean {
    return (
      !this.drawn &&
      !this.stale &&
      this.changed.length === 0 &&
      this.image === this.best &&
      !(this.slow && this.moved)
    );
  }

  /** The chunks of the body that is worked on, as they were sent, by their places. */
  surface(): Uint8Array {
    return pack(
      new Map(
        [...this.shown]
          .filter(([name]) => bodyOf(name) === this.active)
          .map(([name, mesh]) => [name, mesh.geometry]),
      ),
      this.lattice,
    );
  }
  /** Around what is shown of a body. */
  boxOf(body: number): THREE.Box3 {
    const box = new THREE.Box3();
    for (const [name, mesh] of this.shown)
      if (bodyOf(name) === body)
        box.union(
          new THREE.Box3().setFromBufferAttribute(
            mesh.geometry.attributes.position as THREE.BufferAttribute,
          ),
        );
    return box;
  }
  /** Shows a body as if it stood elsewhere, by so much; null: where it does. */
  showMoved(body: number, by: THREE.Matrix4 | null): void {
    for (const [name, mesh] of this.shown)
      if (bodyOf(name) === body) {
        mesh.matrix.copy(by ?? UPRIGHT);
        mesh.matrixWorld.copy(by ?? UPRIGHT);
        // Where it then is, is not known to bounds made before.
        mesh.frustumCulled = by === null;
      }
    this.veil();
    this.moved = true;
    this.redrawSolid();
  }

  frame(from = HOME): void {
    this.box.makeEmpty();
    for (const mesh of this.shown.values())
      this.box.union(
        new THREE.Box3().setFromBufferAttribute(
          mesh.geometry.attributes.position as THREE.BufferAttribute,
        ),
      );
    if (this.box.isEmpty()) return;
    this.turning++;
    this.fit();
    const sphere = this.box.getBoundingSphere(new THREE.Sphere());
    const r = sphere.radius;
    const far = (1.15 * r) / Math.sin((FIELD * Math.PI) / 360) / this.share;
    for (const camera of [this.perspective, this.parallel]) {
      camera.position.copy(sphere.center).addScaledVector(from.clone().normalize(), far);
      camera.near = far / 200;
      camera.far = far * 20;
    }
    this.parallel.zoom = 1;
    this.half = far * this.share * Math.tan((FIELD * Math.PI) / 360);
    this.controls.target.copy(sphere.center);
    this.fit();
    this.controls.update();
    this.light();
    if (this.grid) this.over.remove(this.grid);
    this.grid?.dispose();
    // Lines 1, 10, 100 ... mm apart.
    const apart = 10 ** Math.max(0, Math.round(Math.log10(r) - 0.7));
    const half = Math.ceil((1.6 * r) / apart) * apart;
    this.grid = new THREE.GridHelper(2 * half, (2 * half) / apart, 0x8a7a68, 0xb9aca0);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(
      Math.round(sphere.center.x / apart) * apart,
      Math.round(sphere.center.y / apart) * apart,
      this.box.min.z - 0.001 * r,
    );
    (this.grid.material as THREE.Material).transparent = true;
    (this.grid.material as THREE.Material).opacity = 0.45;
    this.over.add(this.grid);
    this.shades.reach = 0.07 * r;
    this.framed = true;
    this.redrawSolid();
  }

  /** The sun, where it is to shine from, on all of the solid. */
  private light(): void {
    if (this.box.isEmpty()) return;
    const { center, radius: r } = this.box.getBoundingSphere(new THREE.Sphere());
    this.sun.position.copy(center).addScaledVector(this.sunFrom, 5.4 * r);
    this.sun.target.position.copy(center);
    const shadow = this.sun.shadow.camera;
    shadow.left = shadow.bottom = -1.2 * r;
    shadow.right = shadow.top = 1.2 * r;
    shadow.near = r;
    shadow.far = 9 * r;
    shadow.updateProjectionMatrix();
    this.moved = true;
  }

  beginStroke(): void {
    this.before = new Map();
  }
  endStroke(): void {
    if (!this.before) return;
    for (const [place, mesh] of this.before)
      if (mesh && this.shown.get(place) !== mesh) mesh.geometry.dispose();
    this.before = null;
    this.redraw();
  }

  /** The line of sight through a point of the window. */
  rayAt(x: number, y: number): THREE.Ray {
    const r = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    this.ray.setFromCamera(
      new THREE.Vector2((2 * (x - r.left)) / r.width - 1, 1 - (2 * (y - r.top)) / r.height),
      this.camera,
    );
    return this.ray.ray;
  }
  /** How many mm a pixel of the window is wide at a place. */
  perPixel(at: THREE.Vector3): number {
    const r = this.canvas.getBoundingClientRect(),
      seen = at.clone().project(this.camera),
      beside = seen.clone();
    beside.x += 2 / r.width;
    return seen.unproject(this.camera).distanceTo(beside.unproject(this.camera));
  }
  /** What the view turns about. */
  /** The middle of the piece, and how long it is [mm]. */
  get middle(): THREE.Vector3 {
    return this.piece.isEmpty() ? new THREE.Vector3() : this.piece.getCenter(new THREE.Vector3());
  }
  get pieceSize(): number {
    return this.piece.isEmpty() ? 1 : this.piece.getSize(new THREE.Vector3()).length();
  }
  get target(): THREE.Vector3 {
    return this.controls.target;
  }

  /**
   * Where a point of the window meets the surface: as it was before the stroke that is being made,
   * or as it is. Of the body that is worked on, or of another.
   */
  hit(x: number, y: number, began = true, body = this.active): Hit | null {
    const ray = this.rayAt(x, y),
      before = began ? this.before : null;
    const surface: THREE.BufferGeometry[] = [];
    for (const [name, mesh] of this.shown)
      if (bodyOf(name) === body && !before?.has(name)) surface.push(mesh.geometry);
    if (before)
      for (const [name, mesh] of before)
        if (mesh && bodyOf(name) === body) surface.push(mesh.geometry);
    return firstHit(surface, ray, this.shades.section);
  }
  /** How thick the wood is under a place of its surface, square to that [mm]; null: not known. */
  thickness(at: Hit): number | null {
    const inward = at.normal.clone().negate(),
      from = at.point.clone().addScaledVector(inward, 1e-4 * this.pieceSize);
    const surface = [...this.shown]
      .filter(([name]) => bodyOf(name) === this.active)
      .map(([, mesh]) => mesh.geometry);
    const other = firstHit(surface, new THREE.Ray(from, inward), null);
    return other && other.point.distanceTo(at.point);
  }
  /** The body that a point of the window shows; null: none. */
  bodyAt(x: number, y: number): number | null {
    const eye = this.rayAt(x, y).origin.clone();
    let nearest = Infinity,
      body: number | null = null;
    for (const id of this.poses.keys()) {
      const far = this.hit(x, y, false, id)?.point.distanceTo(eye) ?? Infinity;
      if (far < nearest) [nearest, body] = [far, id];
    }
    return body;
  }
  /** Where the window shows a place. */
  onScreen(place: Vec3): { x: number; y: number } {
    const r = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    const at = new THREE.Vector3(...place).project(this.camera);
    return { x: r.left + ((1 + at.x) / 2) * r.width, y: r.top + ((1 - at.y) / 2) * r.height };
  }

  /** The tool as it is; null: none that can be drawn. */
  setTool(tool: HeldTool | null): void {
    this.tool.set(tool);
  }
  setSecondTool(tool: HeldTool | null): void {
    this.secondTool.set(tool);
  }

  /** Whether solid and tool are seen through, as what showAid() adds lies within them. */
  set ghost(on: boolean) {
    this.ghostly = this.tool.ghost = this.secondTool.ghost = on;
    this.redraw();
  }
  private ghostly = false;
  /** Half as wide as the tool that is drawn [mm]; 0: none is. */
  get toolWidth(): number {
    return this.tool.width;
  }
  /** Something that explains the solid; pictures and films leave it out. */
  showAid(thing: THREE.Object3D): void {
    this.aids.add(thing);
    this.redraw();
  }
  private aids = new THREE.Group();

  /**
   * So many pixels at each edge are covered by something: the rest is what the solid is shown in.
   */
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

  /**
   * Frames around the planes of symmetry (bits 1 normal to x, 2 to y, 4 to z); the axis that all
   * goes around, and where each of so many parts begins.
   */
  showSymmetry(planes: number, fold: number, axis: number): void {
    this.planes.children.forEach((frame, i) => (frame.visible = ((planes >> i) & 1) === 1));
    this.folds.geometry.dispose();
    const points: THREE.Vector3[] = [];
    if (fold > 1) {
      const middle = this.middle,
        half = this.piece.getSize(new THREE.Vector3()).multiplyScalar(0.5);
      const [u, v] = [(axis + 1) % 3, (axis + 2) % 3],
        reach = Math.hypot(half.getComponent(u), half.getComponent(v));
      const at = (along: number, turn: number, out: number): THREE.Vector3 =>
        new THREE.Vector3()
          .setComponent(axis, along * half.getComponent(axis))
          .setComponent(u, out * Math.cos(turn))
          .setComponent(v, out * Math.sin(turn))
          .add(middle);
      points.push(at(-1.2, 0, 0), at(1.2, 0, 0));
      for (let i = 0; i < fold; i++) {
        const turn = (2 * Math.PI * i) / fold;
        points.push(at(1, turn, 0), at(1, turn, reach));
      }
    }
    this.folds.geometry = new THREE.BufferGeometry().setFromPoints(points);
    this.redraw();
  }
  private folds = new THREE.LineSegments(
    new THREE.BufferGeometry(),
    new THREE.LineBasicMaterial({
      color: 0x0072b2,
      depthTest: false,
      transparent: true,
      opacity: 0.35,
    }),
  );

  /** Where the tool is; null: nowhere yet. */
  showTool(tip: Vec3 | null, axis: Vec3, side: Vec3, force: Vec3): void {
    this.tool.place(tip, axis, side, force);
  }
  showSecondTool(tip: Vec3 | null, axis: Vec3, side: Vec3, force: Vec3): void {
    this.secondTool.place(tip, axis, side, force);
  }

  /** Whether the tool stands where it can't work. */
  set blocked(now: boolean) {
    this.tool.blocked = now;
  }

  /** A plane that depth counts from; null: none. */
  showPlane(plane: Hit | null): void {
    this.level.visible = plane !== null;
    if (plane) {
      this.level.position.copy(plane.point);
      this.level.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), plane.normal);
      this.level.scale.setScalar(
        this.box.isEmpty() ? 20 : this.box.getSize(new THREE.Vector3()).length() / 2,
      );
    }
    this.redraw();
  }

  showRing(at: Hit | null, radius: number): void {
    this.ring.visible = at !== null;
    if (at) {
      this.ring.position.copy(at.point).addScaledVector(at.normal, 0.05);
      this.ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), at.normal);
      this.ring.scale.setScalar(radius);
    }
    this.redraw();
  }

  /** The wheel that the piece stands on: whether there is one, and whether it turns. */
  showWheel(there: boolean, turns: boolean): void {
    const { group } = this.wheel;
    if (there && !group.visible)
      this.wheel.place(
        this.box.isEmpty() ? this.piece : this.box,
        this.piece.getCenter(new THREE.Vector3()),
      );
    if (there !== group.visible) this.redraw();
    group.visible = there;
    this.wheel.turn(there && turns, () => this.redraw());
  }

  get eye(): Vec3 {
    return this.camera.position.toArray() as Vec3;
  }
  /** From a point towards who looks. */
  towardsEye(point: THREE.Vector3): THREE.Vector3 {
    if (this.orthographic)
      return new THREE.Vector3(0, 0, 1).applyQuaternion(this.camera.quaternion);
    return this.camera.position.clone().sub(point).normalize();
  }
  /** Along a pen that is tilted so from upright on the screen [degrees]. */
  alongPen(tiltX: number, tiltY: number): THREE.Vector3 {
    const tangent = (degrees: number): number =>
      Math.tan((Math.max(-80, Math.min(80, degrees)) * Math.PI) / 180);
    return new THREE.Vector3(tangent(tiltX), -tangent(tiltY), 1)
      .normalize()
      .applyQuaternion(this.camera.quaternion);
  }

  // ---- The look

  set shading(shading: Shading) {
    this.wood.shading = shading;
    this.shades.toned = shading !== "clay";
    for (const mesh of this.shown.values()) mesh.material = this.wood.material;
    this.redrawSolid();
  }
  set hollows(on: boolean) {
    this.shades.hollows = on;
    this.redrawSolid();
  }
  /** 0 ... 1. */
  set cavity(strength: number) {
    this.shades.cavity = strength;
    this.redrawSolid();
  }
  /** Where the sun is, and the light of clay, which turns with the camera. */
  setLight(sun: Vec3, clay: Vec3): void {
    this.wood.clayLight = new THREE.Vector3(...clay).normalize();
    const from = new THREE.Vector3(...sun).normalize();
    if (!from.equals(this.sunFrom)) {
      this.sunFrom.copy(from);
      this.light();
    }
    this.redrawSolid();
  }
  /** From the world's frame into the camera's: columns are the camera's right, up and backward. */
  get turned(): THREE.Matrix4 {
    this.camera.updateMatrixWorld();
    return new THREE.Matrix4().extractRotation(this.camera.matrixWorld);
  }

  get orthographic(): boolean {
    return this.camera === this.parallel;
  }
  /** What is in the middle keeps its size. */
  set orthographic(on: boolean) {
    if (on === this.orthographic) return;
    this.turning++;
    const about = this.controls.target,
      way = this.camera.position.clone().sub(about),
      half = Math.tan((FIELD * Math.PI) / 360);
    let far = way.length() || 1;
    if (on) {
      this.half = half * this.share * far;
      this.parallel.zoom = 1;
      // However near the eye was: what lies behind it would not be seen.
      far = Math.max(far, 4 * this.box.getBoundingSphere(new THREE.Sphere()).radius);
    } else far = this.half / this.share / this.parallel.zoom / half;
    this.camera = on ? this.parallel : this.perspective;
    this.camera.position.copy(about).addScaledVector(way.normalize(), far);
    this.controls.object = this.camera;
    this.fit();
    this.controls.update();
    this.redrawSolid();
  }

  /**
   * Looks at the middle from there, as far away as before; turned there in a moment, unless the
   * person wants no motion.
   */
  turnTo(from: Vec3): void {
    const turn = ++this.turning,
      about = this.controls.target,
      start = performance.now();
    const begin = new THREE.Spherical().setFromVector3(
      asUp(this.camera.position.clone().sub(about)),
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
      this.camera.position.copy(asStands(new THREE.Vector3().setFromSpherical(now))).add(about);
      this.controls.update();
      this.redraw();
      if (share < 1) requestAnimationFrame(step);
    };
    step();
  }

  /** What the solid is cut from. */
  get bounds(): THREE.Box3 {
    return this.piece.clone();
  }
  /** Only what its normal points to is there; null: all. */
  set section(plane: THREE.Plane | null) {
    this.shades.section = this.wood.section = plane;
    this.moved = true;
    this.redrawSolid();
  }
  /** Something to look at, which is no part of the solid. */
  showBeside(thing: THREE.Object3D): void {
    this.over.add(thing);
    this.redraw();
  }
  hideBeside(thing: THREE.Object3D): void {
    this.over.remove(thing);
    this.redraw();
  }

  // ---- Pictures

  /**
   * The whole piece from where one looks first, on no ground, whatever is shown now; null where the
   * browser can't.
   */
  thumbnail(width: number, height: number): Promise<Blob | null> {
    // Of wood and uncut, whatever it is shown like.
    for (const mesh of this.shown.values()) mesh.material = this.wood.pictured;
    const picture = this.thumbnails.draw(this.renderer, width, height);
    for (const mesh of this.shown.values()) mesh.material = this.wood.material;
    return picture;
  }

  /** A picture of what is shown, without the tool, in any size; null where the browser can't. */
  async capture(of: Capture): Promise<Blob | null> {
    let picture: Promise<Blob | null> | null = null;
    await this.sized(of, async () => {
      const { canvas, context } = surfaceOf(of.width, of.height, of.background);
      this.drawWhole();
      context.drawImage(this.canvas, 0, 0);
      picture = new Promise((done) => canvas.toBlob(done, "image/png"));
    });
    return picture;
  }

  /**
   * One turn about the upright axis: so many pictures, each given to use() before the next is
   * drawn.
   */
  async turntable(
    of: Capture,
    count: number,
    use: (picture: HTMLCanvasElement, index: number) => Promise<boolean>,
  ): Promise<void> {
    const about = this.controls.target.clone(),
      from = this.camera.position.clone().sub(about);
    this.turning++;
    const turn = async (): Promise<void> => {
      const { canvas, context } = surfaceOf(of.width, of.height, of.background);
      for (let i = 0, wanted = true; i < count && wanted; i++) {
        this.camera.position
          .copy(from)
          .applyAxisAngle(new THREE.Vector3(0, 0, 1), (2 * Math.PI * i) / count)
          .add(about);
        this.camera.lookAt(about);
        this.drawWhole();
        if (of.background) context.fillRect(0, 0, of.width, of.height);
        else context.clearRect(0, 0, of.width, of.height);
        context.drawImage(this.canvas, 0, 0);
        wanted = await use(canvas, i);
      }
    };
    await this.sized(of, () =>
      turn().finally(() => {
        this.camera.position.copy(from).add(about);
        this.controls.update();
      }),
    );
  }

  /** As well as can be, without the tool and what goes with it, and without the grid. */
  private drawWhole(): void {
    const hidden: THREE.Object3D[] = [
      this.tool.group,
      this.secondTool.group,
      this.wheel.group,
      this.ring,
      this.planes,
      this.level,
      this.aids,
    ];
    if (this.grid) hidden.push(this.grid);
    const were = hidden.map((object) => object.visible);
    for (const object of hidden) object.visible = false;
    const ghostly = this.ghostly;
    this.ghostly = false;
    this.render(true);
    this.ghostly = ghostly;
    hidden.forEach((object, i) => (object.visible = were[i]));
  }
  /** While the canvas has another size. */
  private async sized(of: Capture, use: () => Promise<void>): Promise<void> {
    this.size = { width: of.width, height: of.height };
    this.canvas.style.objectFit = "contain";
    this.controls.enabled = false;
    try {
      await use();
    } finally {
      this.size = null;
      this.canvas.style.objectFit = "";
      this.controls.enabled = true;
      this.render(true);
    }
  }
  private size: { width: number; height: number } | null = null; // other than the window's

  // ---- Drawing

  /** What moves over the solid has changed, or the camera, or chunks that take() brought. */
  redraw(): void {
    if (this.drawn || this.still || this.size) return;
    this.drawn = true;
    const asked = performance.now();
    requestAnimationFrame(() => {
      this.drawn = false;
      if (this.size) return;
      const now = performance.now(),
        took = now - this.began;
      // Only where one frame was asked for right after the other does the time between them tell
      // how long they take.
      this.late = asked - this.ended < 25 && took > 60 && took < 400 ? this.late + 1 : 0;
      if (this.late >= 4) {
        this.late = 0;
        if (this.ratio > 0.75) this.ratio = Math.max(0.75, 0.8 * this.ratio);
        else this.slow = true;
      }
      this.began = now;
      this.render(!this.slow);
      this.ended = performance.now();
      if (!this.slow || (this.image === this.best && !this.moved)) return;
      window.clearTimeout(this.resting);
      const rest = (): void => {
        // A stroke is drawn into the image that it began with; a rough one is first drawn as well
        // as can be.
        if ((this.before && this.image === this.best) || this.still || this.size)
          this.resting = window.setTimeout(rest, REST_MS);
        else this.render(true);
      };
      this.resting = window.setTimeout(rest, REST_MS);
    });
  }
  /** All of the solid looks different. */
  redrawSolid(): void {
    this.stale = true;
    this.redraw();
  }

  /** The solid in the middle of what is not covered. */
  private fit(): void {
    const w = this.size?.width ?? this.canvas.clientWidth,
      h = this.size?.height ?? this.canvas.clientHeight;
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
      const { position } = perspective,
        about = this.controls.target;
      if (this.framed && !this.orthographic && share !== this.share)
        position
          .sub(about)
          .multiplyScalar(this.share / share)
          .add(about);
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

  /** Whole: as well as can be, with shadows as they now are. */
  private render(whole: boolean): void {
    const ratio = this.size ? 1 : this.ratio;
    const w = Math.floor((this.size?.width ?? this.canvas.clientWidth) * ratio),
      h = Math.floor((this.size?.height ?? this.canvas.clientHeight) * ratio);
    if (w === 0 || h === 0) return;
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.renderer.setPixelRatio(1);
      this.renderer.setSize(w, h, false);
      this.stale = true;
    }
    this.fit();
    this.camera.updateMatrixWorld();
    const turned =
      !this.seen.camera.equals(this.camera.matrixWorld) ||
      !this.seen.lens.equals(this.camera.projectionMatrix);
    // While a stroke is made on a slow machine, they stay as they were.
    const shadows = this.moved && whole;
    if (shadows) {
      this.renderer.shadowMap.needsUpdate = true;
      this.moved = false;
    }
    if (turned || this.stale || shadows || (whole && this.image !== this.best)) {
      this.image = whole ? this.best : this.rough;
      const share = whole ? 1 : ROUGH;
      this.image.setSize(Math.ceil(w * share), Math.ceil(h * share));
      if (!whole) this.coarse.follow(this.shown, this.lattice);
      this.coarse.group.visible = !whole;
      this.chunks.visible = whole;
      this.image.draw(this.scene, this.camera, this.shades, null);
      this.coarse.group.visible = false;
      this.chunks.visible = true;
    } else if (this.changed.length > 0) this.drawChanged(w, h);
    this.stale = false;
    this.changed = [];
    this.seen.camera.copy(this.camera.matrixWorld);
    this.seen.lens.copy(this.camera.projectionMatrix);
    this.image.show(this.ghostly ? GHOST : 1);
    this.renderer.render(this.over, this.camera);
    this.frames++;
    if (turned) this.onCamera();
  }

  /** The part of the image that shows chunks that have changed. */
  private drawChanged(w: number, h: number): void {
    const share = this.image === this.best ? 1 : ROUGH,
      part = new THREE.Box2();
    const at = new THREE.Vector3(),
      half = new THREE.Vector3();
    for (const { center, radius } of this.changed)
      for (let corner = 0; corner < 8; corner++) {
        half.set(
          corner & 1 ? radius : -radius,
          corner & 2 ? radius : -radius,
          corner & 4 ? radius : -radius,
        );
        at.copy(center).add(half).applyMatrix4(this.camera.matrixWorldInverse);
        // What is behind the eye has no place in the window.
        if (!this.orthographic && at.z > -this.camera.near)
          return this.image.draw(this.scene, this.camera, this.shades, null);
        at.applyMatrix4(this.camera.projectionMatrix);
        part.expandByPoint(
          new THREE.Vector2(((1 + at.x) / 2) * w * share, ((1 + at.y) / 2) * h * share),
        );
      }
    part.expandByScalar(3);
    part.intersect(new THREE.Box2(new THREE.Vector2(), new THREE.Vector2(w * share, h * share)));
    if (part.isEmpty()) return;
    // Only what may be seen there is handed to the renderer.
    const lens = new THREE.Matrix4();
    const size = part.getSize(new THREE.Vector2()),
      middle = part.getCenter(new THREE.Vector2());
    const sx = (w * share) / size.x,
      sy = (h * share) / size.y;
    lens.set(
      sx,
      0,
      0,
      -sx * ((2 * middle.x) / (w * share) - 1),
      0,
      sy,
      0,
      -sy * ((2 * middle.y) / (h * share) - 1),
      0,
      0,
      1,
      0,
      0,
      0,
      0,
      1,
    );
    lens.multiply(this.camera.projectionMatrix).multiply(this.camera.matrixWorldInverse);
    const frustum = new THREE.Frustum().setFromProjectionMatrix(lens);
    for (const mesh of this.shown.values())
      mesh.visible = frustum.intersectsSphere(mesh.geometry.boundingSphere!);
    this.image.draw(this.scene, this.camera, this.shades, part);
    for (const mesh of this.shown.values()) mesh.visible = true;
  }
}

const UPRIGHT = new THREE.Matrix4();
/** Of a chunk that is shown. */
const nameOf = (place: string, body: number): string => `${place},${body}`;
const bodyOf = (name: string): number => Number(name.slice(name.lastIndexOf(",") + 1));

/** Z is up here; three's spherical coordinates have Y up. */
const asUp = (v: THREE.Vector3): THREE.Vector3 => v.set(v.x, v.z, -v.y);
const asStands = (v: THREE.Vector3): THREE.Vector3 => v.set(v.x, -v.z, v.y);

function surfaceOf(
  width: number,
  height: number,
  background: string | null,
): { canvas: HTMLCanvasElement; context: CanvasRenderingContext2D } {
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const context = canvas.getContext("2d")!;
  if (background) {
    context.fillStyle = background;
    context.fillRect(0, 0, width, height);
  }
  return { canvas, context };
}
