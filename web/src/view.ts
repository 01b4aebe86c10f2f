// SPDX-License-Identifier: MIT
// The solid, the tool and the light. Z is up, lengths are mm.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { pack, unpack, type Lattice } from "./chunks";
import type { Insets } from "./layout";
import { Occlusion } from "./occlusion";
import { Thumbnails } from "./thumbnails";
import type { Vec3 } from "./wire";
import { Wood } from "./wood";

export interface Hit {
  point: THREE.Vector3;
  normal: THREE.Vector3;
}

const STEEL = 0xb8bcc2;
const HOLLOWS = 1; // the layer of what hides the sky
const PICTURED = 2; // the layer of what thumbnails show
/** Where one looks from when a document is opened. */
const HOME = new THREE.Vector3(-0.55, -1, 0.75);

/** Whether there is no graphics card to draw with. */
function drawnBySoftware(): boolean {
  const probe = document.createElement("canvas").getContext("webgl2");
  const about = probe?.getExtension("WEBGL_debug_renderer_info");
  const name = probe && about ? String(probe.getParameter(about.UNMASKED_RENDERER_WEBGL)) : "";
  probe?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

export class View {
  readonly controls: OrbitControls;
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(35, 1, 1, 5000);
  private chunks = new THREE.Group();
  private shown = new Map<string, THREE.Mesh>();
  // What a chunk was when the stroke began: depth is taken from there, so that the tool does not sink by itself.
  // null: there was none.
  private before: Map<string, THREE.Mesh | null> | null = null;
  readonly wood = new Wood();
  private tool = new THREE.Group();
  private ring: THREE.Mesh;
  private arrow = new THREE.ArrowHelper(new THREE.Vector3(0, 0, 1), new THREE.Vector3(), 1, 0xd55e00);
  private sun = new THREE.DirectionalLight(0xfff4e6, 2.6);
  private grid: THREE.GridHelper | null = null;
  private ray = new THREE.Raycaster();
  private box = new THREE.Box3();
  private framed = false;
  private fine = Math.min(2, window.devicePixelRatio); // pixels a pixel; fewer where drawing is slow
  private began = 0; // the last frame, and when it was drawn
  private ended = 0;
  private late = 0; // frames that took long, one right after the other
  private slow: boolean; // hollows are drawn when all is at rest, and shadows then or once a second
  private shadowsAt = 0;
  /** Nothing is drawn. */
  still = false;
  private covered: Insets = { left: 0, right: 0, top: 0, bottom: 0 };
  private occlusion: Occlusion;
  private thumbnails: Thumbnails;
  private resting = 0;
  private drawn = false;
  private planes = new THREE.Group();
  private level = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), new THREE.MeshBasicMaterial({ color: 0x0072b2, transparent: true, opacity: 0.14, side: THREE.DoubleSide, depthWrite: false }));

  constructor(private canvas: HTMLCanvasElement) {
    this.slow = drawnBySoftware();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.slow, alpha: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = this.slow ? THREE.PCFShadowMap : THREE.PCFSoftShadowMap;
    if (this.slow) this.fine = 0.75;
    // Shadows are drawn anew when what throws them changes, not when the camera moves.
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.toneMapping = THREE.ACESFilmicToneMapping;
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.mouseButtons = { LEFT: THREE.MOUSE.ROTATE, MIDDLE: THREE.MOUSE.ROTATE, RIGHT: THREE.MOUSE.ROTATE };
    this.controls.zoomToCursor = true;
    this.controls.addEventListener("change", () => this.redraw());
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.setScalar(this.slow ? 1024 : 2048);
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.15;
    const ringShape = new THREE.RingGeometry(0.94, 1, 64);
    this.ring = new THREE.Mesh(ringShape, new THREE.MeshBasicMaterial({ color: 0x0072b2, side: THREE.DoubleSide, depthTest: false, transparent: true }));
    this.ring.visible = this.arrow.visible = false;
    this.ring.renderOrder = 2;
    const sky = new THREE.HemisphereLight(0xffffff, 0xb5a48f, 1.7);
    this.level.visible = false;
    this.scene.add(this.planes, this.level, this.chunks, this.tool, this.ring, this.arrow, this.sun, this.sun.target, sky);
    // Lights that came and went with the layer would make every material anew.
    for (const light of [this.sun, sky]) light.layers.enable(HOLLOWS);
    sky.layers.enable(PICTURED);
    this.occlusion = new Occlusion(this.scene, this.camera, HOLLOWS);
    this.thumbnails = new Thumbnails(this.scene, this.sun, PICTURED);
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  begin(lattice: Lattice, nodes: Vec3): void {
    for (const mesh of this.shown.values()) mesh.geometry.dispose();
    this.shown.clear();
    this.chunks.clear();
    this.endStroke();
    this.framed = this.whole = false;
    this.arrow.visible = this.ring.visible = this.tool.visible = false;
    this.told = "";
    const size = nodes.map((n) => n * lattice.pitch);
    for (const frame of this.planes.children as THREE.LineLoop[]) {
      frame.geometry.dispose();
      (frame.material as THREE.Material).dispose();
    }
    this.planes.clear();
    for (let i = 0; i < 3; i++) {
      const [u, v] = [size[(i + 1) % 3], size[(i + 2) % 3]];
      const frame = new THREE.LineLoop(
        new THREE.BufferGeometry().setFromPoints([[-u, -v], [u, -v], [u, v], [-u, v]].map(([a, b]) => new THREE.Vector3().setComponent((i + 1) % 3, a / 2).setComponent((i + 2) % 3, b / 2))),
        new THREE.LineBasicMaterial({ color: 0x0072b2 }),
      );
      frame.position.set(...(lattice.origin.map((o, k) => o + (lattice.pitch * nodes[k]) / 2) as Vec3));
      frame.visible = false;
      this.planes.add(frame);
    }
    const corner = new THREE.Vector3(...lattice.origin);
    this.thumbnails.place(new THREE.Box3(corner, corner.clone().add(new THREE.Vector3(...size))), HOME);
    this.wood.place(new THREE.Vector3(lattice.origin[0], lattice.origin[1] + 0.42 * size[1], lattice.origin[2] - 0.35 * size[2]), Math.max(...size));
    this.redraw();
  }

  /** Takes a frame of chunks in. */
  take(data: Uint8Array, lattice: Lattice): void {
    this.whole = false;
    unpack(data, lattice, (place, made) => {
      const old = this.shown.get(place);
      if (!old && this.before && !this.before.has(place)) this.before.set(place, null);
      if (old) {
        this.chunks.remove(old);
        if (this.before && !this.before.has(place)) this.before.set(place, old);
        else if (this.before?.get(place) !== old) old.geometry.dispose();
        this.shown.delete(place);
      }
      if (!made) return;
      const mesh = new THREE.Mesh(made, this.wood.material);
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.layers.enable(HOLLOWS);
      mesh.layers.enable(PICTURED);
      this.shown.set(place, mesh);
      this.chunks.add(mesh);
    });
    this.moved = true;
    this.redraw();
  }
  private moved = false; // what throws shadows has changed since they were drawn

  /** All chunks are there. */
  complete(): void {
    this.whole = true;
    if (!this.framed) this.frame();
  }
  /** Whether all of the solid is shown that there is. */
  whole = false;

  /** The chunks that are shown, as they were sent, by their places. */
  surface(lattice: Lattice): Uint8Array {
    return pack(new Map([...this.shown].map(([place, mesh]) => [place, mesh.geometry])), lattice);
  }

  frame(from = HOME): void {
    this.box.makeEmpty();
    for (const mesh of this.shown.values()) this.box.union(new THREE.Box3().setFromBufferAttribute(mesh.geometry.attributes.position as THREE.BufferAttribute));
    if (this.box.isEmpty()) return;
    this.fit();
    const sphere = this.box.getBoundingSphere(new THREE.Sphere());
    const r = sphere.radius;
    const far = (1.15 * r) / Math.sin((this.camera.fov * Math.PI) / 360) / Math.min(1, this.camera.aspect);
    this.camera.position.copy(sphere.center).addScaledVector(from.clone().normalize(), far);
    this.camera.near = far / 200;
    this.camera.far = far * 20;
    this.controls.target.copy(sphere.center);
    this.controls.update();
    this.sun.position.copy(sphere.center).add(new THREE.Vector3(-0.7, -0.45, 1.6).multiplyScalar(3 * r));
    this.sun.target.position.copy(sphere.center);
    const shadow = this.sun.shadow.camera;
    shadow.left = shadow.bottom = -1.2 * r;
    shadow.right = shadow.top = 1.2 * r;
    shadow.near = r;
    shadow.far = 9 * r;
    shadow.updateProjectionMatrix();
    if (this.grid) this.scene.remove(this.grid);
    this.grid?.dispose();
    // Lines 1, 10, 100 ... mm apart.
    const apart = 10 ** Math.max(0, Math.round(Math.log10(r) - 0.7));
    const half = Math.ceil((1.6 * r) / apart) * apart;
    this.grid = new THREE.GridHelper(2 * half, (2 * half) / apart, 0x8a7a68, 0xb9aca0);
    this.grid.rotation.x = Math.PI / 2;
    this.grid.position.set(Math.round(sphere.center.x / apart) * apart, Math.round(sphere.center.y / apart) * apart, this.box.min.z - 0.001 * r);
    (this.grid.material as THREE.Material).transparent = true;
    (this.grid.material as THREE.Material).opacity = 0.45;
    this.scene.add(this.grid);
    this.occlusion.reach = 0.12 * r;
    this.framed = this.moved = true;
    this.redraw();
  }

  beginStroke(): void {
    this.before = new Map();
  }
  endStroke(): void {
    if (!this.before) return;
    for (const [place, mesh] of this.before) if (mesh && this.shown.get(place) !== mesh) mesh.geometry.dispose();
    this.before = null;
    this.redraw();
  }

  /** The line of sight through a point of the window. */
  rayAt(x: number, y: number): THREE.Ray {
    const r = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    this.ray.setFromCamera(new THREE.Vector2((2 * (x - r.left)) / r.width - 1, 1 - (2 * (y - r.top)) / r.height), this.camera);
    return this.ray.ray;
  }
  /** How many mm a pixel of the window is wide at a place. */
  perPixel(at: THREE.Vector3): number {
    const r = this.canvas.getBoundingClientRect(), seen = at.clone().project(this.camera), beside = seen.clone();
    beside.x += 2 / r.width;
    return seen.unproject(this.camera).distanceTo(beside.unproject(this.camera));
  }
  /** What the view turns about. */
  get target(): THREE.Vector3 {
    return this.controls.target;
  }

  /** Where a point of the window meets the surface: as it was before the stroke that is being made, or as it is. */
  hit(x: number, y: number, began = true): Hit | null {
    this.rayAt(x, y);
    const before = began ? this.before : null;
    const meshes: THREE.Object3D[] = [];
    for (const [place, mesh] of this.shown) if (!before?.has(place)) meshes.push(mesh);
    if (before) for (const mesh of before.values()) if (mesh) meshes.push(mesh);
    const found = this.ray.intersectObjects(meshes, false)[0];
    if (!found) return null;
    const normal = found.normal ? found.normal.clone() : found.face!.normal.clone();
    if (normal.dot(this.ray.ray.direction) > 0) normal.negate();
    return { point: found.point.clone(), normal };
  }

  private held = ""; // the tool that is drawn
  /** The tool as it is; shapes and their numbers are those of ChooseTool. */
  setTool(shape: number, size: number, length: number, other: number): void {
    const told = [shape, size, length, other].join();
    if (told === this.held) return;
    this.held = told;
    for (const mesh of this.tool.children as THREE.Mesh[]) {
      mesh.geometry.dispose();
      (mesh.material as THREE.Material).dispose();
    }
    this.tool.clear();
    const look = new THREE.MeshStandardMaterial({ color: STEEL, roughness: 0.3, metalness: 0.6, transparent: true, opacity: 0.75 });
    const add = (geometry: THREE.BufferGeometry, z: number, turn = true): void => {
      const mesh = new THREE.Mesh(geometry, look);
      if (turn) mesh.rotation.x = Math.PI / 2;
      mesh.position.z = z;
      this.tool.add(mesh);
    };
    if (shape === 0) add(new THREE.SphereGeometry(size, 40, 28), size);
    if (shape === 2) add(new THREE.CylinderGeometry(size, size, length, 40), length / 2);
    if (shape === 3) add(new THREE.CapsuleGeometry(size, length - 2 * size, 12, 40), length / 2);
    // What turns about its axis: radii and heights from the tip.
    const lathe = (...points: [number, number][]): void => add(new THREE.LatheGeometry(points.map(([r, z]) => new THREE.Vector2(r, z)), 40), 0);
    if (shape === 4) {
      const round = Array.from({ length: 9 }, (_, i): [number, number] => {
        const a = (i * Math.PI) / 16;
        return [size - other + other * Math.sin(a), other - other * Math.cos(a)];
      });
      lathe([0, 0], ...round, [size, length], [0, length]);
    }
    if (shape === 5) {
      const slope = Math.tan((other * Math.PI) / 360), radius = Math.min(size, slope * length);
      lathe([0, 0], [radius, radius / slope], [radius, length], [0, length]);
    }
    if (shape === 6) add(new THREE.BoxGeometry(size, length, other), other / 2, false);
    if (shape === 7) {
      add(new THREE.SphereGeometry(1, 40, 28), other, false);
      this.tool.children[0].scale.set(size, length, other);
    }
    if (shape === 1) {
      // A paraboloid: z = Ks r^2 up to its length.
      const points: THREE.Vector2[] = [];
      for (let i = 0; i <= 24; i++) {
        const z = (length * i * i) / (24 * 24);
        points.push(new THREE.Vector2(Math.sqrt(z / size), z));
      }
      add(new THREE.LatheGeometry(points, 40), 0);
    }
    this.redraw();
  }

  /** So many pixels at each edge are covered by something: the rest is what the solid is shown in. */
  cover(insets: Insets): void {
    const { left, right, top, bottom } = this.covered;
    if (insets.left === left && insets.right === right && insets.top === top && insets.bottom === bottom) return;
    this.covered = insets;
    this.fit();
    this.redraw();
  }

  /** Frames around the planes of symmetry: bits 1 normal to x, 2 to y, 4 to z. */
  set mirrored(planes: number) {
    this.planes.children.forEach((frame, i) => (frame.visible = ((planes >> i) & 1) === 1));
    this.redraw();
  }

  /** Where it is; null: nowhere yet. */
  showTool(tip: Vec3 | null, axis: Vec3, side: Vec3, force: Vec3): void {
    const told = tip ? [...tip, ...axis, ...side, ...force].join() : "";
    if (told === this.told) return;
    this.told = told;
    this.redraw();
    this.tool.visible = tip !== null;
    this.arrow.visible = false;
    if (!tip) return;
    this.tool.position.set(...tip);
    const x = new THREE.Vector3(...side), z = new THREE.Vector3(...axis);
    this.tool.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(x, z.clone().cross(x), z));
    const f = new THREE.Vector3(...force);
    const n = f.length();
    this.arrow.visible = n > 0.01;
    if (this.arrow.visible) {
      this.arrow.position.set(...tip);
      this.arrow.setDirection(f.divideScalar(n));
      const long = Math.min(40, 6 + 12 * Math.log1p(n));
      this.arrow.setLength(long, 3, 1.6);
    }
  }
  private told = ""; // where the tool was said to be

  /** The tool stands where it can't work. */
  set blocked(now: boolean) {
    for (const mesh of this.tool.children as THREE.Mesh[]) (mesh.material as THREE.MeshStandardMaterial).color.set(now ? 0xc62828 : STEEL);
    this.redraw();
  }

  /** A plane that depth counts from; null: none. */
  showPlane(plane: Hit | null): void {
    this.level.visible = plane !== null;
    if (plane) {
      this.level.position.copy(plane.point);
      this.level.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), plane.normal);
      this.level.scale.setScalar(this.box.isEmpty() ? 20 : this.box.getSize(new THREE.Vector3()).length() / 2);
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

  get eye(): Vec3 {
    return this.camera.position.toArray() as Vec3;
  }
  /** From a point towards who looks. */
  towardsEye(point: THREE.Vector3): THREE.Vector3 {
    return this.camera.position.clone().sub(point).normalize();
  }
  /** Along a pen that is tilted so from upright on the screen [degrees]. */
  alongPen(tiltX: number, tiltY: number): THREE.Vector3 {
    const tangent = (degrees: number): number => Math.tan((Math.max(-80, Math.min(80, degrees)) * Math.PI) / 180);
    return new THREE.Vector3(tangent(tiltX), -tangent(tiltY), 1).normalize().applyQuaternion(this.camera.quaternion);
  }

  /** The whole piece from where one looks first, on no ground, whatever is shown now; null where the browser can't. */
  thumbnail(width: number, height: number): Promise<Blob | null> {
    return this.thumbnails.draw(this.renderer, width, height);
  }

  /** What is shown, without tool and ring, as a picture so wide; null where the browser can't. */
  picture(width: number, height: number): Promise<Blob | null> {
    const hidden = [this.tool, this.ring, this.arrow, this.planes];
    const were = hidden.map((object) => object.visible);
    for (const object of hidden) object.visible = false;
    const covered = this.covered;
    this.cover({ left: 0, right: 0, top: 0, bottom: 0 });
    this.render(true);
    const small = document.createElement("canvas");
    small.width = width;
    small.height = height;
    const scale = Math.max(width / this.canvas.width, height / this.canvas.height);
    const w = scale * this.canvas.width, h = scale * this.canvas.height;
    const into = small.getContext("2d")!;
    into.fillStyle = getComputedStyle(document.body).backgroundColor;
    into.fillRect(0, 0, width, height);
    into.drawImage(this.canvas, (width - w) / 2, (height - h) / 2, w, h);
    hidden.forEach((object, i) => (object.visible = were[i]));
    this.cover(covered);
    this.redraw();
    return new Promise((done) => small.toBlob(done, "image/png"));
  }

  /** One turn about the upright axis; recorded, if the browser can. stop() ends it early. */
  turn(seconds: number): { stop: () => void; film: Promise<Blob | null> } {
    const start = performance.now(), about = this.controls.target.clone();
    const from = this.camera.position.clone().sub(about);
    let stopped = false;
    let recorder: MediaRecorder | null = null;
    const parts: Blob[] = [];
    try {
      recorder = new MediaRecorder(this.canvas.captureStream(30), { videoBitsPerSecond: 8e6 });
      recorder.ondataavailable = (event) => parts.push(event.data);
      recorder.start();
    } catch {
      recorder = null;
    }
    const film = new Promise<Blob | null>((done) => {
      const step = (): void => {
        const share = Math.min(1, (performance.now() - start) / (1000 * seconds));
        this.camera.position.copy(from).applyAxisAngle(new THREE.Vector3(0, 0, 1), 2 * Math.PI * share).add(about);
        this.camera.lookAt(about);
        this.redraw();
        if (share < 1 && !stopped) return void requestAnimationFrame(step);
        this.controls.update();
        if (!recorder) return done(null);
        recorder.onstop = () => done(stopped ? null : new Blob(parts, { type: recorder!.mimeType }));
        recorder.stop();
      };
      step();
    });
    return { stop: () => (stopped = true), film };
  }

  redraw(): void {
    if (this.drawn || this.still) return;
    this.drawn = true;
    const asked = performance.now();
    requestAnimationFrame(() => {
      this.drawn = false;
      const now = performance.now(), took = now - this.began;
      // Only where one frame was asked for right after the other does the time between them tell how long they take.
      this.late = asked - this.ended < 25 && took > 60 && took < 400 ? this.late + 1 : 0;
      if (this.late >= 4) {
        this.late = 0;
        if (this.fine > 0.75) this.fine = Math.max(0.75, 0.8 * this.fine);
        else this.slow = true;
      }
      this.began = now;
      this.render(!this.slow);
      this.ended = performance.now();
      if (!this.slow) return;
      window.clearTimeout(this.resting);
      const rest = (): void => {
        if (this.before || this.still) this.resting = window.setTimeout(rest, 700);
        else this.render(true);
      };
      this.resting = window.setTimeout(rest, 700);
    });
  }

  /** The solid in the middle of what is not covered. */
  private fit(): void {
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight, { left, right, top, bottom } = this.covered;
    const wide = w - left - right, high = h - top - bottom, before = Math.min(1, this.camera.aspect);
    if (wide <= 0 || high <= 0) return;
    this.camera.setViewOffset(wide, high, -left, -top, w, h);
    // A turn of the wrist, or a sheet, that leaves less breadth for the height: what was all shown still is.
    const nearer = Math.min(1, this.camera.aspect) / before;
    if (this.framed && nearer !== 1) this.camera.position.sub(this.controls.target).divideScalar(nearer).add(this.controls.target);
    this.controls.panSpeed = h / high; // it reckons with the canvas's height
  }

  /** Whole: with shadows as they now are, and hollows. */
  private render(whole: boolean): void {
    const w = this.canvas.clientWidth, h = this.canvas.clientHeight, now = performance.now();
    if (this.canvas.width !== Math.floor(w * this.fine) || this.canvas.height !== Math.floor(h * this.fine)) {
      this.renderer.setPixelRatio(this.fine);
      this.renderer.setSize(w, h, false);
    }
    this.fit();
    if (this.moved && (whole || now - this.shadowsAt > 1000)) {
      this.renderer.shadowMap.needsUpdate = true;
      this.moved = false;
      this.shadowsAt = now;
    }
    this.renderer.render(this.scene, this.camera);
    if (whole) this.occlusion.draw(this.renderer, this.slow ? 2 : 1);
  }
}
