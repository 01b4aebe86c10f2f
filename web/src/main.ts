// SPDX-License-Identifier: MIT
// The page: pointer and keys to the studio, surface, force and numbers from it.
import * as THREE from "three";
import { Connection } from "./connection";
import { write, type FromStudio } from "./messages";
import { ForcePlot } from "./plot";
import "./style.css";
import { View, type Hit } from "./view";
import type { Vec3 } from "./wire";

const element = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;
const input = (id: string): HTMLInputElement => element<HTMLInputElement>(id);

const canvas = element<HTMLCanvasElement>("view");
let view: View;
try {
  view = new View(canvas);
} catch {
  element("hint").textContent = "This browser can't draw in three dimensions: WebGL 2 is off or missing. Turn it on, or use another browser.";
  throw new Error("no WebGL 2");
}

let lattice = { origin: [0, 0, 0] as Vec3, pitch: 1 };
let rate = 1000;
let holds = false;
let axis = new THREE.Vector3(0, 0, 1);
const plot = new ForcePlot(element("plot"), () => rate);

// ---- From the studio

function tell(text: string, forSeconds = 8): void {
  const box = element("notice");
  box.textContent = text;
  box.hidden = text === "";
  if (forSeconds < Infinity) setTimeout(() => box.textContent === text && (box.hidden = true), 1000 * forSeconds);
}

const line = new Connection(hear, (why) => tell(why, Infinity));

function hear(said: FromStudio): void {
  switch (said.kind) {
    case "Welcome": {
      const w = said.message;
      lattice = { origin: w.origin, pitch: w.pitch };
      rate = w.rate;
      document.title = `${w.document.split("/").pop()} – Kibori`;
      tell("");
      view.begin(lattice, w.nodes);
      chooseTool();
      chooseSpring();
      break;
    }
    case "Chunks":
      view.take(said.message.data, lattice);
      line.send(write.Got({ frame: said.message.frame }));
      if (!said.message.more) view.complete();
      document.body.dataset.chunks = String(Number(document.body.dataset.chunks ?? 0) + 1);
      break;
    case "Ticks": {
      const bytes = said.message.data;
      const rows = new Float32Array(bytes.slice().buffer);
      plot.add(said.message.start, rows);
      const last = rows.subarray(rows.length - 9);
      const force: Vec3 = [last[3], last[4], last[5]];
      view.showTool([last[0], last[1], last[2]], axis, force);
      element("n-force").textContent = `${Math.hypot(...force).toFixed(2)} N`;
      element("n-moment").textContent = `${Math.hypot(last[6], last[7], last[8]).toFixed(1)} N mm`;
      break;
    }
    case "State": {
      const s = said.message;
      holds = s.holds !== 0;
      element("take").hidden = holds;
      element<HTMLButtonElement>("undo").disabled = !holds || !s.undo;
      element<HTMLButtonElement>("redo").disabled = !holds || !s.redo;
      element("n-volume").textContent = `${(s.volume / 1000).toFixed(2)} cm³`;
      element("n-removed").textContent = `${(s.removed / 1000).toFixed(3)} cm³`;
      element("n-step").textContent = `${s.step} of ${s.steps}`;
      Object.assign(document.body.dataset, { hash: s.hash, step: String(s.step), volume: String(s.volume) });
      break;
    }
    case "Notice":
      tell(said.message.text);
  }
}

// ---- Tool

const chosen = (name: string): number => Number((document.querySelector(`input[name=${name}]:checked`) as HTMLInputElement).value);
const radius = (): number => Number(input("size").value);
const depth = (): number => Number(input("depth").value);

/** From its tip to its other end [mm]. */
const TOOL_LENGTH = 25;
const FINGER_LENGTH = 20;
function toolHeight(): number {
  return [2 * radius(), FINGER_LENGTH, TOOL_LENGTH, TOOL_LENGTH][chosen("shape")];
}

function chooseTool(): void {
  const shape = chosen("shape");
  element("size-out").textContent = `${radius().toFixed(1)} mm`;
  element("depth-out").textContent = `${depth().toFixed(1)} mm`;
  const length = shape === 1 ? FINGER_LENGTH : TOOL_LENGTH;
  // The finger's Ks such that it is as wide as a ball would be, a radius above its tip.
  const size = shape === 1 ? 1 / radius() : radius();
  view.setTool(shape, size, length);
  line.send(write.ChooseTool({ shape, size, length }));
}
function chooseSpring(): void {
  const stiffness = 10 ** Number(input("spring").value);
  element("spring-out").textContent = `${stiffness.toPrecision(2)} N/mm`;
  line.send(write.ChooseSpring({ stiffness }));
}
element("shapes").addEventListener("change", chooseTool);
input("size").addEventListener("input", chooseTool);
input("depth").addEventListener("input", chooseTool);
input("spring").addEventListener("input", chooseSpring);

// ---- Pointer

let stroke: { pointer: number; last: Hit; fill: boolean } | null = null;

/** The tip, the tool's lowest point, that presses so deep at a place; above it for a depth below zero. */
function tipAt(hit: Hit, deep: number): Vec3 {
  return hit.point.clone().addScaledVector(hit.normal, -deep).toArray() as Vec3;
}

function aim(hit: Hit, deep: number): void {
  axis = hit.normal;
  line.send(write.Aim({ tip: tipAt(hit, deep), axis: axis.toArray() as Vec3 }));
}

canvas.addEventListener(
  "pointerdown",
  (event) => {
    element("hint").hidden = true;
    const hit = event.button === 0 && holds && !stroke ? view.hit(event.clientX, event.clientY) : null;
    if (!hit) return; // beside it: the view turns
    event.stopImmediatePropagation();
    canvas.focus();
    canvas.setPointerCapture(event.pointerId);
    view.controls.enabled = false;
    view.beginStroke();
    const fill = event.ctrlKey || event.altKey || chosen("mode") === 1;
    stroke = { pointer: event.pointerId, last: hit, fill };
    axis = hit.normal;
    line.send(write.Press({ tip: tipAt(hit, -1), axis: axis.toArray() as Vec3, mode: fill ? 1 : 0 }));
    aim(hit, pressed(event));
  },
  { capture: true },
);

/** How deep: where it adds, so that the tool stands out as much as it else would sink in. */
function pressed(event: PointerEvent): number {
  if (stroke?.fill) return toolHeight() - depth();
  return event.pointerType === "pen" && event.pressure > 0 ? 2 * event.pressure * depth() : depth();
}

canvas.addEventListener("pointermove", (event) => {
  const hit = view.hit(event.clientX, event.clientY);
  if (stroke) {
    if (event.pointerId !== stroke.pointer) return;
    if (hit) stroke.last = hit;
    aim(stroke.last, pressed(event));
    view.showRing(stroke.last, radius());
  } else if (event.buttons === 0) {
    view.showRing(hit, radius());
    if (hit && holds) aim(hit, -2);
  }
});

function lift(): void {
  if (!stroke) return;
  const { last } = stroke;
  stroke = null;
  view.controls.enabled = true;
  view.endStroke();
  line.send(write.Lift());
  aim(last, -2);
}
canvas.addEventListener("pointerup", (event) => event.pointerId === stroke?.pointer && lift());
canvas.addEventListener("pointercancel", lift);
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("dblclick", () => view.frame());
window.addEventListener("blur", lift);

// ---- Buttons and keys

const undo = (): void => line.send(write.Undo());
const redo = (): void => line.send(write.Redo());
element("undo").onclick = undo;
element("redo").onclick = redo;
element("take").onclick = () => line.send(write.TakeTool());
element("frame").onclick = () => view.frame();
element("help").onclick = () => element<HTMLDialogElement>("keys").showModal();
element("pause").onclick = () => {
  plot.paused = !plot.paused;
  element("pause").textContent = plot.paused ? "Go on" : "Pause";
};
element("csv").onclick = () => {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(plot.csv());
  link.download = "forces.csv";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
};

function nudge(id: string, factor: number): void {
  input(id).value = String(Number(input(id).value) * factor);
  chooseTool();
}
window.addEventListener("keydown", (event) => {
  if (element<HTMLDialogElement>("keys").open) return;
  const control = event.ctrlKey || event.metaKey;
  const key = control ? `Ctrl+${event.shiftKey ? "Shift+" : ""}${event.key.toLowerCase()}` : event.key;
  const known: Record<string, () => void> = {
    "Ctrl+z": undo,
    "Ctrl+Shift+z": redo,
    "Ctrl+y": redo,
    Escape: () => {
      line.send(write.Cancel());
      if (stroke) lift();
    },
    "[": () => nudge("size", 1 / 1.15),
    "]": () => nudge("size", 1.15),
    "{": () => nudge("depth", 1 / 1.15),
    "}": () => nudge("depth", 1.15),
    "1": () => view.frame(new THREE.Vector3(0, -1, 0.001)),
    "3": () => view.frame(new THREE.Vector3(1, 0, 0.001)),
    "7": () => view.frame(new THREE.Vector3(0, -0.001, 1)),
    Home: () => view.frame(),
    "?": () => element<HTMLDialogElement>("keys").showModal(),
  };
  const action = known[key];
  if (!action) return;
  event.preventDefault();
  action();
});
