// SPDX-License-Identifier: MIT
// The view. It puts its parts together: the solid and its light, the tools, and the marks around
// them. Each part has its own file. Z is up. Lengths are in mm.
import * as THREE from "three";
import type { Vec3 } from "../base/vec3";
import { Cameras } from "./cameras";
import type { Lattice } from "./chunks";
import type { ScreenPoint } from "./hidden_parts";
import { Marks } from "./marks";
import { Painter } from "./painter";
import type { Hit } from "./pick";
import { Pictures } from "./pictures";
import { PICTURED, Solid } from "./solid";
import { Thumbnails } from "./thumbnails";
import { ToolFigure } from "./tool_figure";
import { WheelHead } from "./wheel_head";
import { Wood, type Matcap, type Shading } from "./wood";

/**
 * Intensity of the light from the eye. It lights surfaces that face the viewer, even in the shade.
 */
const FILL = 0.9;
/** Number of positions on each of two rings around a position, and the cosine of 15 degrees. */
const AROUND = 12,
  ALIKE = 0.966;
/** The direction from the piece to the eye when a document opens. */
const HOME = new THREE.Vector3(-0.55, -1, 0.75);

export class View {
  readonly wood = new Wood();
  readonly solid: Solid;
  readonly cameras: Cameras;
  readonly painter: Painter;
  readonly pictures: Pictures;
  readonly tool: ToolFigure;
  readonly secondTool: ToolFigure;
  readonly marks: Marks;
  private scene = new THREE.Scene(); // the solid and its light
  private over = new THREE.Scene(); // moving parts over it
  private aids = new THREE.Group();
  private wheel = new WheelHead();
  private sun = new THREE.DirectionalLight(0xfff8ee, 2.3);
  private fill = new THREE.DirectionalLight(0xffffff, FILL);
  private sunFrom = new THREE.Vector3();
  private box = new THREE.Box3(); // of the solid when it was framed
  private piece = new THREE.Box3(); // the lattice's box
  private thumbnails: Thumbnails;

  constructor(canvas: HTMLCanvasElement) {
    const redraw = (): void => this.redraw();
    this.solid = new Solid(this.wood, redraw);
    this.cameras = new Cameras(canvas, redraw);
    this.painter = new Painter(canvas, this.scene, this.over, this.solid, this.cameras);
    this.tool = new ToolFigure(redraw);
    this.secondTool = new ToolFigure(redraw);
    this.marks = new Marks(redraw);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.setScalar(this.painter.slow ? 1024 : 2048);
    this.sun.shadow.bias = -0.0004;
    this.sun.shadow.normalBias = 0.15;
    const sky = new THREE.HemisphereLight(0xf6f8ff, 0xc4bbb0, 1.75);
    sky.layers.enable(PICTURED);
    this.scene.add(this.solid.chunks, this.sun, this.sun.target, sky, this.fill);
    const lamp = new THREE.DirectionalLight(0xffffff, 2.4);
    lamp.position.set(-0.7, -0.45, 1.6);
    const moving = [
      this.marks.group,
      this.tool.group,
      this.secondTool.group,
      this.wheel.group,
      this.aids,
    ];
    this.over.add(
      this.solid.veils,
      ...moving,
      lamp,
      new THREE.HemisphereLight(0xffffff, 0xb5a48f, 1.7),
    );
    // A light's target is the origin, so its position is its direction.
    this.painter.beforeSolid = () =>
      this.fill.position.setFromMatrixColumn(this.cameras.current.matrixWorld, 2);
    this.pictures = new Pictures(canvas, this.painter, this.cameras, moving);
    this.thumbnails = new Thumbnails(this.scene, this.sun, PICTURED);
  }

  /** Starts with a document. `again`: the same document, so the camera stays. */
  begin(lattice: Lattice, nodes: Vec3, again = false): void {
    const before = this.solid.lattice;
    const same =
      again &&
      lattice.pitch === before.pitch &&
      lattice.origin.every((x, i) => x === before.origin[i]);
    this.solid.begin(lattice);
    this.cameras.framed &&= same;
    this.tool.hide();
    this.secondTool.hide();
    this.showWheel(false, false);
    this.piece.min.set(...lattice.origin);
    this.piece.max
      .set(...nodes)
      .multiplyScalar(lattice.pitch)
      .add(this.piece.min);
    this.marks.begin(this.piece);
    this.thumbnails.place(this.piece, HOME);
    this.wood.place(this.piece.min, this.piece.getSize(new THREE.Vector3()));
    this.painter.begin();
  }

  /** All chunks have arrived. */
  complete(): void {
    this.solid.whole = true;
    if (!this.cameras.framed) this.frame();
  }

  /** Shows the whole solid from a direction. */
  frame(from = HOME): void {
    this.box.copy(this.solid.boxOf(null));
    if (this.box.isEmpty()) return;
    const sphere = this.box.getBoundingSphere(new THREE.Sphere());
    this.cameras.frame(sphere, from);
    this.light();
    this.marks.frame(this.box, sphere);
    this.painter.shades.reach = 0.07 * sphere.radius;
    this.painter.redrawSolid();
  }

  // ---- Positions

  /** The middle of the piece. `pieceSize` is its size [mm]. */
  get middle(): THREE.Vector3 {
    return this.piece.isEmpty() ? new THREE.Vector3() : this.piece.getCenter(new THREE.Vector3());
  }
  get pieceSize(): number {
    return this.piece.isEmpty() ? 1 : this.piece.getSize(new THREE.Vector3()).length();
  }
  /** The box of the lattice's base and of the solid, which may have outgrown it. */
  get bounds(): THREE.Box3 {
    return this.piece.clone().union(this.solid.boxOf(null));
  }

  /**
   * Where a point of the window meets a body's surface: before the current stroke if `began` is
   * set, else now. The default is the active body.
   */
  hit(x: number, y: number, began = true, body = this.solid.active): Hit | null {
    return this.solid.hit(this.cameras.rayAt(x, y), this.painter.shades.section, began, body);
  }
  /**
   * The position, with the normal of the surface around it instead of its own. It is the normal
   * that most places within two `radius` [mm] share. So a groove at the position does not count.
   */
  around(at: Hit, radius: number): Hit {
    const middle = this.cameras.onScreen(at.point.toArray() as Vec3),
      size = radius / this.cameras.perPixel(at.point);
    const normals = [at.normal];
    for (let i = 0; i < 2 * AROUND; i++) {
      const angle = (2 * Math.PI * i) / AROUND,
        ring = (i < AROUND ? 1 : 2) * size;
      const hit = this.hit(middle.x + ring * Math.cos(angle), middle.y + ring * Math.sin(angle));
      if (hit && hit.point.distanceTo(at.point) < 4 * radius) normals.push(hit.normal);
    }
    const like = normals.map((one) => normals.filter((other) => one.dot(other) > ALIKE));
    const largest = like.reduce((best, group) => (group.length > best.length ? group : best));
    const normal = largest.reduce((sum, one) => sum.add(one), new THREE.Vector3()).normalize();
    return { ...at, normal };
  }
  /** The body that a point of the window shows. Null: none. */
  bodyAt(x: number, y: number): number | null {
    return this.solid.bodyAt(this.cameras.rayAt(x, y), this.painter.shades.section);
  }
  /** Draws what is masked, or hides it. What is hidden cannot be pressed. */
  hideMasked(hides: boolean): void {
    this.wood.hidesMasked = hides;
    this.painter.redrawSolid();
  }
  /**
   * Hides what is behind an outline on the screen, or with `outside` everything else. What is
   * hidden cannot be pressed.
   */
  hide(outline: ScreenPoint[], outside: boolean): void {
    this.solid.hidden.add(this.cameras.toScreen, outline, outside);
    this.markHidden();
  }
  showAll(): void {
    this.solid.hidden.clear();
    this.markHidden();
  }
  private markHidden(): void {
    this.solid.markHidden();
    this.painter.redrawSolid();
  }
  /** The thickness of the wood under a point of its surface, normal to it [mm]. Null: unknown. */
  thickness(at: Hit): number | null {
    return this.solid.thickness(at, 1e-4 * this.pieceSize);
  }

  // ---- Objects shown with the solid

  redraw(): void {
    this.painter.redraw();
  }
  /** Shows a body displaced by a motion. Null: at its own position. */
  showMoved(body: number, by: THREE.Matrix4 | null): void {
    this.solid.showMoved(body, by);
    this.painter.redrawSolid();
  }
  /** Adds an object that explains the solid. Pictures and films leave it out. */
  showAid(thing: THREE.Object3D): void {
    this.aids.add(thing);
    this.redraw();
  }
  /** Adds an object that is not part of the solid. */
  showExtra(thing: THREE.Object3D): void {
    this.over.add(thing);
    this.redraw();
  }
  hideExtra(thing: THREE.Object3D): void {
    this.over.remove(thing);
    this.redraw();
  }
  /** The wheel under the piece: whether it is shown, and whether it turns. */
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
  /** A small picture of the whole piece from HOME without a ground. Null if encoding fails. */
  thumbnail(width: number, height: number): Promise<Blob | null> {
    // Always draw it in wood and without a section.
    this.solid.dress(this.wood.pictured);
    const picture = this.thumbnails.draw(this.painter.renderer, width, height);
    this.solid.dress();
    return picture;
  }

  // ---- Look

  /**
   * True if solid and tools are transparent, so that objects of showAid() inside them are visible.
   */
  set ghost(on: boolean) {
    this.painter.ghostly = this.tool.ghost = this.secondTool.ghost = on;
    this.redraw();
  }
  /** The look of the shading "clay". */
  set matcap(look: Matcap) {
    this.wood.matcap = look;
    this.painter.redrawSolid();
  }
  set shading(shading: Shading) {
    this.wood.shading = shading;
    this.painter.shades.toned = shading !== "clay";
    this.solid.dress();
    this.painter.redrawSolid();
  }
  set hollows(on: boolean) {
    this.painter.shades.hollows = on;
    this.painter.redrawSolid();
  }
  /** The strength, 0 to 1. */
  set cavity(strength: number) {
    this.painter.shades.cavity = strength;
    this.painter.redrawSolid();
  }
  /** Shows only the side that the plane's normal points to. Null: everything. */
  set section(plane: THREE.Plane | null) {
    this.painter.shades.section = this.wood.section = plane;
    this.solid.shadowsStale = true;
    this.painter.redrawSolid();
  }
  /** Sets the sun's direction, and the light of clay, which turns with the camera. */
  setLight(sun: Vec3, clay: Vec3): void {
    this.wood.clayLight = new THREE.Vector3(...clay).normalize();
    const from = new THREE.Vector3(...sun).normalize();
    if (!from.equals(this.sunFrom)) {
      this.sunFrom.copy(from);
      this.light();
    }
    this.painter.redrawSolid();
  }
  /** Places the sun so that it lights the whole solid. */
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
    this.solid.shadowsStale = true;
  }
}
