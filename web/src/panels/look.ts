// SPDX-License-Identifier: MIT
// The panel that controls how the solid is shown: shading, light, section, reference picture, view
// cube, pictures and films. The browser keeps the choices. Section and reference belong to the open
// document.
import { t } from "../base/texts";
import * as THREE from "three";
import { ViewCube } from "../view/cube";
import { ask, dialog, element, input, put, select } from "../base/dom";
import { notify } from "../base/notice";
import { canFilm, Film } from "../view/film";
import type { Field, MethodView } from "./method_view";
import type { Capture } from "../view/pictures";
import type { View } from "../view/view";
import type { Vec3 } from "../base/vec3";
import { MATCAPS, type Matcap, type Shading } from "../view/wood";
import { SavedViews } from "./saved_views";

const STORE = "kibori.look";
const LIGHT: Vec3 = [-0.39, -0.25, 0.89],
  CLAY_LIGHT: Vec3 = [-0.45, 0.6, 0.66];
const SIDE_PX = { min: 16, max: 8192 };
const MAX_FRAMES = 3600;
const REFERENCE_PX = 2048; // max length of its longer side
const LIGHT_STEP = 0.08; // share of the widget's radius per arrow key
const MIN_PANEL_PX = 120,
  PANEL_MARGIN_PX = 12;
const LIGHT_DRAG_PX = 160; // drag distance on the view from the widget's centre to its rim

interface Settings {
  shading: Shading;
  matcap: Matcap;
  cavity: boolean;
  strength: number;
  hollows: boolean;
  light: Vec3;
  clayLight: Vec3;
  orthographic: boolean;
}
const isLight = (a: unknown): a is Vec3 =>
  Array.isArray(a) &&
  a.length === 3 &&
  a.every((x) => Number.isFinite(x)) &&
  Math.hypot(...a) > 0.1;

function kept(): Settings {
  const settings: Settings = {
    shading: "wood",
    matcap: "clay",
    cavity: true,
    strength: 0.5,
    hollows: true,
    light: LIGHT,
    clayLight: CLAY_LIGHT,
    orthographic: false,
  };
  try {
    const was = JSON.parse(localStorage.getItem(STORE) ?? "{}") as Partial<Settings>;
    if (was.shading === "plain" || was.shading === "clay") settings.shading = was.shading;
    if (MATCAPS.some((look) => look === was.matcap)) settings.matcap = was.matcap!;
    if (typeof was.strength === "number" && was.strength >= 0 && was.strength <= 1)
      settings.strength = was.strength;
    for (const name of ["cavity", "hollows", "orthographic"] as const)
      if (typeof was[name] === "boolean") settings[name] = was[name];
    for (const name of ["light", "clayLight"] as const)
      if (isLight(was[name])) settings[name] = was[name];
  } catch {
    // Ignore stored values that cannot be read.
  }
  return settings;
}

export class Look {
  private settings = kept();
  private document = "";
  readonly savedViews: SavedViews;
  private cube: ViewCube;
  private reference: THREE.Mesh<THREE.PlaneGeometry, THREE.MeshBasicMaterial> | null = null;
  private filming: { left: boolean } | null = null;
  private lightKey = false; // whether it is held

  constructor(
    private canvas: HTMLCanvasElement,
    private view: View,
    private save: (ending: string, what: Blob) => void,
  ) {
    this.cube = new ViewCube(element("cube"), (from) => view.cameras.turnTo(from));
    this.savedViews = new SavedViews(view.cameras);
    view.painter.onCamera = () => this.turned();
    const { settings } = this;
    document.querySelector<HTMLInputElement>(
      `input[name=shading][value=${settings.shading}]`,
    )!.checked = true;
    select("matcap").value = settings.matcap;
    select("matcap").onchange = () => {
      settings.matcap = select("matcap").value as Matcap;
      this.apply();
    };
    input("cavity").checked = settings.cavity;
    input("cavity-strength").value = String(settings.strength);
    input("hollows").checked = settings.hollows;
    input("orthographic").checked = settings.orthographic;
    element("shadings").onchange = () => {
      settings.shading = document.querySelector<HTMLInputElement>("input[name=shading]:checked")!
        .value as Shading;
      this.apply();
    };
    for (const id of ["cavity", "hollows", "orthographic"] as const)
      input(id).onchange = () => {
        settings[id] = input(id).checked;
        this.apply();
      };
    input("cavity-strength").oninput = () => {
      settings.strength = Number(input("cavity-strength").value);
      input("cavity").checked = settings.cavity = settings.strength > 0;
      this.apply();
    };
    this.listenForLight();
    this.listenForLightKey();
    // "onclick", because a second click on "view" changes nothing in the form, but takes the new
    // viewing direction.
    element("section").onclick = () => this.section();
    input("section-at").oninput = () => this.section(false);
    input("section-flip").onchange = () => this.section(false);
    input("reference").onchange = () => void this.bring();
    for (const id of [
      "reference-size",
      "reference-across",
      "reference-up",
      "reference-deep",
      "reference-opacity",
    ])
      input(id).oninput = () => this.place();
    select("reference-plane").onchange = () => this.place();
    element("reference-remove").onclick = () => this.remove();
    this.listenForPictures();
    this.makeRoom();
    this.apply();
  }

  /** Limits the panel's height to the window. */
  private makeRoom(): void {
    const box = element<HTMLDetailsElement>("look-box"),
      panel = element("look-panel");
    const fit = (): void => {
      if (box.open)
        panel.style.maxHeight = `${Math.max(MIN_PANEL_PX, innerHeight - panel.getBoundingClientRect().top - PANEL_MARGIN_PX)}px`;
    };
    box.ontoggle = fit;
    window.addEventListener("resize", fit);
    // In a narrow window the messages are above the panel.
    new ResizeObserver(fit).observe(element("messages"));
  }

  /** Starts with another document. Removes section and reference of the previous one. */
  begin(name: string): void {
    if (name === this.document) return;
    this.document = name;
    this.savedViews.begin(name);
    this.remove();
    input("section-at").value = "0";
    input("section-flip").checked = false;
    document.querySelector<HTMLInputElement>("input[name=section][value=off]")!.checked = true;
    this.section();
  }

  toggleOrthographic(): void {
    input("orthographic").checked = this.settings.orthographic = !this.settings.orthographic;
    this.apply();
  }

  /** Connects the buttons that choose the field of the method view. */
  showsMethod(method: MethodView): void {
    this.method = method;
    element("methods").onchange = () => {
      const { value } = document.querySelector<HTMLInputElement>("input[name=method]:checked")!;
      method.field = value === "off" ? null : ((this.field = Number(value) as 0 | 1 | 2) as Field);
    };
  }
  private method: MethodView | null = null;
  private field: 0 | 1 | 2 = 2; // the field that was shown last

  toggleMethod(): void {
    const value = this.method?.field === null ? String(this.field) : "off";
    document.querySelector<HTMLInputElement>(`input[name=method][value="${value}"]`)!.checked =
      true;
    element("methods").dispatchEvent(new Event("change"));
  }

  private apply(): void {
    const { settings, view } = this;
    view.matcap = settings.matcap;
    view.shading = settings.shading;
    element("matcaps").hidden = settings.shading !== "clay";
    view.cavity = settings.cavity ? settings.strength : 0;
    view.hollows = settings.hollows;
    view.cameras.orthographic = settings.orthographic;
    view.setLight(settings.light, settings.clayLight);
    this.turned();
    try {
      localStorage.setItem(STORE, JSON.stringify(settings));
    } catch {
      // Without storage the choice holds until the page is reloaded.
    }
  }

  /** Updates the cube and the light's widget after the camera has moved. */
  private turned(): void {
    this.cube.turn(this.view.cameras.turned);
    const light = this.light,
      dot = element("light-dot");
    dot.style.left = `${50 + 46 * light.x}%`;
    dot.style.top = `${50 - 46 * light.y}%`;
    dot.classList.toggle("behind", light.z < 0);
    const degrees = (x: number): number =>
      Math.round((180 * Math.asin(Math.max(-1, Math.min(1, x)))) / Math.PI);
    const aside = degrees(light.x),
      up = degrees(light.y);
    element("light").ariaValueNow = String(aside);
    element("light").ariaValueText = [
      t(aside < 0 ? "light_left" : "light_right", { n: Math.abs(aside) }),
      t(up < 0 ? "light_below" : "light_above", { n: Math.abs(up) }),
      ...(light.z < 0 ? [t("light_behind")] : []),
    ].join(", ");
  }

  // ---- Light

  /** The light that is used, in the camera's frame. */
  private get light(): THREE.Vector3 {
    const { shading, light, clayLight } = this.settings;
    if (shading === "clay") return new THREE.Vector3(...clayLight).normalize();
    return new THREE.Vector3(...light)
      .normalize()
      .applyMatrix4(this.view.cameras.turned.transpose());
  }
  /** Sets the light from a point of the widget's disc. Points beyond the rim move to the rim. */
  private setLight(x: number, y: number): void {
    const far = Math.hypot(x, y),
      shrunk = far > 0.995 ? 0.995 / far : 1;
    const light = new THREE.Vector3(
      shrunk * x,
      shrunk * y,
      Math.sqrt(1 - Math.min(far, 0.995) ** 2),
    );
    if (this.settings.shading === "clay") this.settings.clayLight = light.toArray();
    else this.settings.light = light.applyMatrix4(this.view.cameras.turned).toArray();
    this.apply();
  }
  private listenForLight(): void {
    const widget = element("light");
    const follow = (event: PointerEvent): void => {
      const r = widget.getBoundingClientRect();
      this.setLight(
        (2 * (event.clientX - r.left)) / r.width - 1,
        1 - (2 * (event.clientY - r.top)) / r.height,
      );
    };
    widget.onpointerdown = (event) => {
      widget.setPointerCapture(event.pointerId);
      follow(event);
    };
    widget.onpointermove = (event) => widget.hasPointerCapture(event.pointerId) && follow(event);
    widget.onkeydown = (event) => {
      const directions: Record<string, [number, number]> = {
        ArrowLeft: [-1, 0],
        ArrowRight: [1, 0],
        ArrowUp: [0, 1],
        ArrowDown: [0, -1],
      };
      const direction = directions[event.key],
        { x, y } = this.light;
      if (!direction) return;
      event.preventDefault();
      event.stopPropagation();
      this.setLight(x + LIGHT_STEP * direction[0], y + LIGHT_STEP * direction[1]);
    };
    element("light-reset").onclick = () => {
      Object.assign(this.settings, { light: LIGHT, clayLight: CLAY_LIGHT });
      this.apply();
    };
  }
  /** While its key is held, the pointer moves the light. The tool does not receive these events. */
  private listenForLightKey(): void {
    const typing = (target: EventTarget | null): boolean =>
      target instanceof HTMLInputElement && ["text", "number"].includes(target.type);
    window.addEventListener("keydown", (event) => {
      if (
        event.key.toLowerCase() === "l" &&
        !event.ctrlKey &&
        !event.metaKey &&
        !event.altKey &&
        !typing(event.target) &&
        !document.querySelector("dialog[open]")
      )
        this.lightKey = true;
    });
    window.addEventListener(
      "keyup",
      (event) => event.key.toLowerCase() === "l" && (this.lightKey = false),
    );
    window.addEventListener("blur", () => (this.lightKey = false));
    let last: { pointer: number; x: number; y: number } | null = null;
    const mine = (event: PointerEvent): void => {
      event.stopImmediatePropagation();
      event.preventDefault();
    };
    window.addEventListener(
      "pointerdown",
      (event) => {
        if (event.target !== this.canvas || !this.lightKey || last) return;
        mine(event);
        last = { pointer: event.pointerId, x: event.clientX, y: event.clientY };
        this.canvas.setPointerCapture(event.pointerId);
      },
      { capture: true },
    );
    window.addEventListener(
      "pointermove",
      (event) => {
        if (event.pointerId !== last?.pointer) return;
        mine(event);
        const { x, y } = this.light;
        this.setLight(
          x + (event.clientX - last.x) / LIGHT_DRAG_PX,
          y - (event.clientY - last.y) / LIGHT_DRAG_PX,
        );
        last = { ...last, x: event.clientX, y: event.clientY };
      },
      { capture: true },
    );
    for (const end of ["pointerup", "pointercancel"] as const)
      window.addEventListener(
        end,
        (event) => {
          if (event.pointerId !== last?.pointer) return;
          mine(event);
          last = null;
        },
        { capture: true },
      );
  }

  // ---- Section

  private sectionNormal = new THREE.Vector3(); // before it is flipped
  private section(chosen = true): void {
    const how = document.querySelector<HTMLInputElement>("input[name=section]:checked")!.value;
    element("section-more").hidden = how === "off";
    if (how === "off") return void (this.view.section = null);
    const { min, max } = this.view.bounds,
      middle = min.clone().add(max).multiplyScalar(0.5),
      half = max.clone().sub(middle);
    // At first, the section keeps the half that is behind it as seen by the viewer.
    if (chosen && how !== "view")
      this.sectionNormal.set(how === "x" ? 1 : 0, how === "y" ? 1 : 0, how === "z" ? -1 : 0);
    if (chosen && how === "view")
      this.sectionNormal.setFromMatrixColumn(this.view.cameras.turned, 2).negate();
    const out = this.sectionNormal,
      along = how === "view" ? 1 : Math.sign(out.x + out.y + out.z);
    const reach = Math.abs(out.x) * half.x + Math.abs(out.y) * half.y + Math.abs(out.z) * half.z;
    const at = Number(input("section-at").value) * reach;
    put("section-out", `${at.toFixed(1)} mm`);
    const normal = out.clone().multiplyScalar(input("section-flip").checked ? -1 : 1);
    this.view.section = new THREE.Plane().setFromNormalAndCoplanarPoint(
      normal,
      middle.addScaledVector(out, along * at),
    );
  }

  // ---- Reference

  private async bring(): Promise<void> {
    const file = input("reference").files?.[0];
    input("reference").value = "";
    if (!file) return;
    try {
      const bitmap = await createImageBitmap(file);
      const shrunk = Math.min(1, REFERENCE_PX / Math.max(bitmap.width, bitmap.height)),
        picture = document.createElement("canvas");
      picture.width = Math.max(1, Math.round(shrunk * bitmap.width));
      picture.height = Math.max(1, Math.round(shrunk * bitmap.height));
      picture.getContext("2d")!.drawImage(bitmap, 0, 0, picture.width, picture.height);
      bitmap.close();
      this.remove();
      const map = new THREE.CanvasTexture(picture);
      map.colorSpace = THREE.SRGBColorSpace;
      this.reference = new THREE.Mesh(
        new THREE.PlaneGeometry(picture.width / picture.height, 1),
        new THREE.MeshBasicMaterial({
          map,
          side: THREE.DoubleSide,
          transparent: true,
          depthWrite: false,
          toneMapped: false,
        }),
      );
      this.reference.renderOrder = -1;
      element("reference-more").hidden = false;
      this.view.showExtra(this.reference);
      this.place();
    } catch {
      notify(t("picture_unreadable", { file: file.name }));
    }
  }
  private place(): void {
    const picture = this.reference;
    if (!picture) return;
    const { min, max } = this.view.bounds,
      size = max.clone().sub(min),
      middle = min.clone().add(max).multiplyScalar(0.5);
    const plane = select("reference-plane").value,
      value = (id: string): number => Number(input(id).value);
    // For each plane: the directions of the picture's right side, of its top, and to its viewer.
    const axes = {
      front: [
        [1, 0, 0],
        [0, 0, 1],
        [0, -1, 0],
      ],
      right: [
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 0],
      ],
      top: [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
      ],
    }[plane]!;
    const [right, up, out] = axes.map((axis) => new THREE.Vector3(...(axis as Vec3)));
    const along = (axis: THREE.Vector3): number => Math.abs(axis.dot(size));
    picture.quaternion.setFromRotationMatrix(new THREE.Matrix4().makeBasis(right, up, out));
    picture.scale.setScalar(value("reference-size") * along(up));
    picture.position
      .copy(middle)
      .addScaledVector(right, value("reference-across") * along(right))
      .addScaledVector(up, value("reference-up") * along(up));
    picture.position.addScaledVector(out, -0.51 * value("reference-deep") * along(out));
    picture.material.opacity = value("reference-opacity");
    this.view.redraw();
  }
  private remove(): void {
    element("reference-more").hidden = true;
    if (!this.reference) return;
    this.view.hideExtra(this.reference);
    this.reference.geometry.dispose();
    this.reference.material.map?.dispose();
    this.reference.material.dispose();
    this.reference = null;
  }

  // ---- Pictures and films

  private listenForPictures(): void {
    const open = (film: boolean): void => {
      const ratio = Math.min(2, devicePixelRatio);
      put("capture-title", t(film ? "turntable_title" : "picture_title"));
      for (const part of document.querySelectorAll<HTMLElement>("#capturing .film"))
        part.hidden = !film;
      input("capture-clear").parentElement!.hidden = film;
      element("capture-progress").hidden = true;
      element("capture-save").dataset.what = film ? "film" : "picture";
      for (const [id, px] of [
        ["capture-width", this.canvas.clientWidth],
        ["capture-height", this.canvas.clientHeight],
      ] as const)
        if (!input(id).value) input(id).value = String(Math.round(ratio * px));
      ask("capturing");
    };
    element("picture").onclick = () => open(false);
    element("turn").onclick = () => (canFilm() ? open(true) : notify(t("no_films")));
    dialog("capturing").querySelector("form")!.onsubmit = (event) => {
      event.preventDefault();
      if (!this.filming) void this.capture(element("capture-save").dataset.what === "film");
    };
    dialog("capturing").onclose = () => this.filming && (this.filming.left = true);
  }

  private async capture(filmed: boolean): Promise<void> {
    const number = (id: string): number => Math.round(Number(input(id).value));
    const clear = !filmed && input("capture-clear").checked;
    const of: Capture = {
      width: number("capture-width"),
      height: number("capture-height"),
      background: clear ? null : input("capture-color").value,
    };
    if (![of.width, of.height].every((px) => px >= SIDE_PX.min && px <= SIDE_PX.max))
      return notify(t("picture_limits", SIDE_PX));
    const rate = number("film-rate"),
      count = Math.round(Number(input("film-seconds").value) * rate);
    if (filmed && !(count >= 2 && count <= MAX_FRAMES))
      return notify(t("film_limits", { max: MAX_FRAMES, count }));
    const run = (this.filming = { left: false });
    let made: Film | null = null;
    try {
      if (!filmed) {
        const picture = await this.view.pictures.capture(of);
        if (picture) this.save("png", picture);
        else notify(t("picture_too_large"));
      } else {
        const bar = element<HTMLProgressElement>("capture-progress"),
          film = (made = new Film(of.width, of.height, rate));
        bar.hidden = false;
        await this.view.pictures.turntable(of, count, async (picture, index) => {
          await film.add(picture, index);
          bar.value = (index + 1) / count;
          return !run.left;
        });
        if (!run.left) this.save("webm", await film.end());
      }
    } catch (error) {
      notify(t(filmed ? "film_failed" : "picture_failed", { error: (error as Error).message }));
    }
    made?.leave();
    this.filming = null;
    dialog("capturing").close();
  }
}
