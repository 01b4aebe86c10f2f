// SPDX-License-Identifier: MIT
// The view: the solid and its light, the tools, and marks around them. Each part has its own file;
// this one connects them. Z is up, lengths are mm.
import * as THREE from "three";
import type { Vec3 } from "../base/vec3";
import { Cameras } from "./cameras";
import type { Lattice } from "./chunks";
import { Marks } from "./marks";
import { Painter } from "./painter";
import type { Hit } from "./pick";
import { Pictures } from "./pictures";
import { PICTURED, Solid } from "./solid";
import { Thumbnails } from "./thumbnails";
import { ToolFigure } from "./tool_figure";
import { WheelHead } from "./wheel_head";
import { Wood, type Shading } from "./wood";

/** The direction from the piece to the eye when a document is opened. */
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
  private over = new THREE.Scene(); // objects that move over it
  private aids = new THREE.Group();
  private wheel = new WheelHead();
  private sun = new THREE.DirectionalLight(0xfff8ee, 2.3);
  private sunFrom = new THREE.Vector3();
  private box = new THREE.Box3(); // bounds of the solid when it was framed
  private piece = new THREE.Box3(); // the piece that the solid is cut from
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
    this.scene.add(this.solid.chunks, this.sun, this.sun.target, sky);
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
    this.pictures = new Pictures(canvas, this.painter, this.cameras, moving);
    this.thumbnails = new Thumbnails(this.scene, this.sun, PICTURED);
  }

  /** `again`: the same document is loaded again, and the camera stays. */
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

  /** All chunks are there. */
  complete(): void {
    this.solid.whole = true;
    if (!this.cameras.framed) this.frame();
  }

  /** Moves the camera so that it shows the whole solid from this direction. */
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

  /** The centre of the piece, and its longest side [mm]. */
  get middle(): THREE.Vector3 {
    return this.piece.isEmpty() ? new THREE.Vector3() : this.piece.getCenter(new THREE.Vector3());
  }
  get pieceSize(): number {
    return this.piece.isEmpty() ? 1 : this.piece.getSize(new THREE.Vector3()).length();
  }
  /** The piece that the solid is cut from. */
  get bounds(): THREE.Box3 {
    return this.piece.clone();
  }

  /**
   * Hit of a point of the window with the surface of a body, by default the active one: before the
   * current stroke if `began`, else now.
   */
  hit(x: number, y: number, began = true, body = this.solid.active): Hit | null {
    return this.solid.hit(this.cameras.rayAt(x, y), this.painter.shades.section, began, body);
  }
  /** The body that is visible at a point of the window; null: none. */
  bodyAt(x: number, y: number): number | null {
    return this.solid.bodyAt(this.cameras.rayAt(x, y), this.painter.shades.section);
  }
  /** Thickness of the wood at a place of its surface, along the normal [mm]; null: unknown. */
  thickness(at: Hit): number | null {
    return this.solid.thickness(at, 1e-4 * this.pieceSize);
  }

  // ---- Objects shown with the solid

  redraw(): void {
    this.painter.redraw();
  }
  /** Shows a body displaced by this motion; null: at its own pose. */
  showMoved(body: number, by: THREE.Matrix4 | null): void {
    this.solid.showMoved(body, by);
    this.painter.redrawSolid();
  }
  /** Adds an object that explains the solid. Pictures and films do not show it. */
  showAid(thing: THREE.Object3D): void {
    this.aids.add(thing);
    this.redraw();
  }
  /** Adds a visible object that is not part of the solid. */
  showBeside(thing: THREE.Object3D): void {
    this.over.add(thing);
    this.redraw();
  }
  hideBeside(thing: THREE.Object3D): void {
    this.over.remove(thing);
    this.redraw();
  }
  /** Shows or hides the wheel under the piece, and turns or stops it. */
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
  /**
   * A small picture of the whole piece from HOME, without a ground; null if the browser cannot make
   * it.
   */
  thumbnail(width: number, height: number): Promise<Blob | null> {
    // In wood and without a section, independent of the current look.
    this.solid.dress(this.wood.pictured);
    const picture = this.thumbnails.draw(this.painter.renderer, width, height);
    this.solid.dress();
    return picture;
  }

  // ---- The look

  /** Makes solid and tools transparent, because objects of showAid() are inside them. */
  set ghost(on: boolean) {
    this.painter.ghostly = this.tool.ghost = this.secondTool.ghost = on;
    this.redraw();
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
  /** 0 ... 1. */
  set cavity(strength: number) {
    this.painter.shades.cavity = strength;
    this.painter.redrawSolid();
  }
  /** Shows the solid only on the side that the plane's normal points to; null: all of it. */
  set section(plane: THREE.Plane | null) {
    this.painter.shades.section = this.wood.section = plane;
    this.solid.shadowsStale = true;
    this.painter.redrawSolid();
  }
  /** Sets the direction of the sun, and of the light of clay, which turns with the camera. */
  setLight(sun: Vec3, clay: Vec3): void {
    this.wood.clayLight = new THREE.Vector3(...clay).normalize();
    const from = new THREE.Vector3(...sun).normalize();
    if (!from.equals(this.sunFrom)) {
      this.sunFrom.copy(from);
      this.light();
    }
    this.painter.redrawSolid();
  }
  /** Places the sun in its direction, so that it lights the whole solid. */
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
