// SPDX-License-Identifier: MIT
// The page: what the studio says to surface, plot, history and numbers; buttons and keys to the
// studio.
import { Bodies } from "./panels/bodies";
import { Splines } from "./panels/splines";
import { BRUSHES, BRUSH_MODES } from "./tools/brushes";
import * as THREE from "three";
import { request } from "./connection/access";
import { Connection } from "./connection/connection";
import { announce, ask, dialog, element, input, put, read } from "./base/dom";
import { Experiments } from "./forces/experiments";
import { Hand } from "./hand/hand";
import { History } from "./history/history";
import { Keys } from "./panels/keys";
import { Layout } from "./panels/layout";
import { Look } from "./panels/look";
import { lookByKeys } from "./view/look_keys";
import { write, type FromStudio } from "./connection/messages";
import { MODEL_NOTES, type Model } from "./connection/kinds";
import { Measure } from "./panels/measure";
import { MethodView } from "./panels/method_view";
import { makeNumberRows } from "./panels/number_row";
import { PrintCheck } from "./panels/print_check";
import { ForcePlot } from "./forces/plot";
import { Senses } from "./forces/senses";
import { Settings } from "./panels/settings";
import type { Material } from "./view/wood";
import { Start } from "./start/start";
import "./style.css";
import { View } from "./view/view";
import type { Vec3 } from "./base/vec3";
import { TICK_NUMBERS } from "./connection/wire";

const canvas = element<HTMLCanvasElement>("view");
// The view has a frame where the Tab key came to it, and none for a pointer's sake.
document.addEventListener("pointerdown", () => document.body.classList.add("by-pointer"), true);
document.addEventListener(
  "keydown",
  (event) => event.key === "Tab" && document.body.classList.remove("by-pointer"),
  true,
);
let view: View;
try {
  view = new View(canvas);
} catch {
  notify(
    "This browser can't draw in three dimensions: WebGL 2 is off or missing. Turn it on, or use another browser.",
    Infinity,
    true,
  );
  throw new Error("no WebGL 2");
}

let rate = 1000;
let title = "Kibori";
let step = 0;
let firstTime = true;
let tip: Vec3 = [0, 0, 0]; // as of the last tick
let force = 0; // of the wood [N]
let share = 0; // of that, what a force device's hand feels
const newtons = (n: number): string => `${n < 10 ? n.toFixed(1) : n.toFixed(0)} N`;
// Where a stroke takes nothing away for so long, though it is pressed: the person is told why.
const STILL_MS = 1500;
let blocked = false; // as the studio said last
let stuck = { removed: 0, since: 0 };

// ---- From the studio

function notify(text: string, forSeconds = 8, trouble = false): void {
  const box = element("notice");
  box.setAttribute("role", trouble ? "alert" : "status");
  box.textContent = text;
  if (forSeconds < Infinity)
    setTimeout(() => box.textContent === text && (box.textContent = ""), 1000 * forSeconds);
}

const line = new Connection(onMessage, (why) => {
  element("lost").hidden = why === null;
  if (why) put("lost-why", `${why.text}${why.trying ? " Trying again …" : ""}`);
  element("again").hidden = why?.trying ?? true;
});
element("again").onclick = () => line.again();
const send = (message: Uint8Array): void => line.send(message);
makeNumberRows({ size: "ratio", depth: "ratio", strength: "ratio", reach: "exponent" });
// Its gestures are for the piece before the hand's strokes are.
const bodies = new Bodies(
  canvas,
  view,
  send,
  (text) => notify(text),
  () => hand.holds && !hand.readOnly,
  (file, longest) => void start.importer.bring(file, longest),
  () => printing.leave(),
);
const splines = new Splines(
  canvas,
  view,
  send,
  (text) => notify(text),
  () => hand.holds && !hand.readOnly,
  () => bodies.activeBody,
);
const measure = new Measure(canvas, view, () => send(write.AskMass()));
const printing = new PrintCheck(send, () => bodies.leaveColours());
const hand: Hand = new Hand(canvas, view, send, (x, y) => bodies.takeUp(x, y), notify);
const layout = new Layout((insets) => view.cameras.cover(insets));
const look = new Look(canvas, view, notify, (ending, what) => save(`${title}.${ending}`, what));
lookByKeys(canvas, view.cameras.controls);
const method = new MethodView(view, send);
look.showsMethod(method);
// Not kept are what a document says itself (its wood), and mirrors, which would surprise.
const settings = new Settings([
  "shape",
  "mode",
  "size",
  "form",
  "turn-by",
  "depth",
  "strength",
  "falloff",
  "keep",
  "color",
  "axis",
  "model",
  "sound",
  "rumble",
  "pressure",
  "crumbs",
  "steady",
  "leads",
  "stamp-text",
  "every",
]);
const start = new Start(
  send,
  notify,
  (text) => element("notice").textContent === text && notify(""),
);
const plot = new ForcePlot(element("plot"), () => rate);
const senses = new Senses();
const experiments = new Experiments(send, notify, save);
const history = new History(
  element("history"),
  (to) => send(write.Go({ step: to })),
  () => {
    ask("naming");
    element<HTMLInputElement>("version").select();
  },
);

function onMessage(said: FromStudio): void {
  switch (said.kind) {
    case "Start": {
      hand.holds = said.message.holds !== 0;
      element("watching").hidden = true;
      element("hint").hidden = true;
      view.begin({ origin: [0, 0, 0], pitch: 1 }, [1, 1, 1]);
      history.clear();
      document.title = "Kibori";
      step = 0;
      document.body.dataset.shown = "start";
      notify("");
      experiments.offer(start.show(said.message.json));
      break;
    }
    case "Welcome": {
      const w = said.message;
      rate = w.rate;
      const again = title === w.document.replace(/\.kibori$/, "");
      title = w.document.replace(/\.kibori$/, "");
      step = 0;
      document.title = `${title} – Kibori`;
      element("title").textContent = element("title").title = title;
      document.body.dataset.shown = "solid";
      notify("");
      // The focus was where there is nothing any more; keys go on at the piece.
      const lost =
        document.activeElement === document.body ||
        element("start").contains(document.activeElement);
      start.hide();
      if (lost) canvas.focus();
      element("hint").hidden = !firstTime;
      firstTime = false;
      const kinds = JSON.parse(w.materials) as Material[];
      view.wood.setKinds(kinds);
      element("material").replaceChildren(
        ...kinds.map((m, i) => new Option(m.name, String(i), i === w.material, i === w.material)),
      );
      // A tool may be as large as the piece and the room around it.
      for (const id of ["size", "depth"])
        input(id).max = String(Math.ceil(Math.max(...w.nodes) * w.pitch));
      view.begin({ origin: w.origin, pitch: w.pitch }, w.nodes, again);
      bodies.begin();
      splines.reset();
      start.importer.offer(w.page, kinds);
      look.begin(w.document);
      method.begin(w.origin, w.pitch);
      plot.clear();
      history.clear();
      hand.holds = hand.device = false;
      share = 0;
      hand.readOnly = w.what !== 0;
      element("reading").textContent = w.what === 2 ? "experiment" : "read only";
      element("reading").hidden = !hand.readOnly;
      element("device").hidden = true;
      document.body.classList.toggle("read-only", hand.readOnly);
      document.body.classList.toggle("experiment", w.what === 2);
      document.body.classList.remove("device");
      if (hand.readOnly) element("hint").hidden = true;
      layout.measure();
      settings.restore();
      hand.begin();
      measure.begin();
      printing.leave();
      break;
    }
    case "Chunks": {
      const from = performance.now();
      view.solid.take(said.message.data, said.message.body);
      send(write.Got({ frame: said.message.frame }));
      if (!said.message.more) view.complete();
      performance.measure("update", { start: from, detail: said.message.data.length });
      document.body.dataset.chunks = String(Number(document.body.dataset.chunks ?? 0) + 1);
      break;
    }
    case "Ticks": {
      const rows = new Float32Array(said.message.data.slice().buffer);
      plot.add(said.message.start, rows);
      senses.feel(rows, rate);
      const last = rows.subarray(rows.length - TICK_NUMBERS);
      tip = [last[0], last[1], last[2]];
      const pushed: Vec3 = [last[3], last[4], last[5]],
        axis: Vec3 = [last[9], last[10], last[11]],
        side: Vec3 = [last[12], last[13], last[14]];
      const shown = hand.there || hand.device || hand.readOnly || !hand.holds ? tip : null;
      view.tool.place(shown, axis, side, pushed);
      method.follow(shown, axis);
      force = Math.hypot(...pushed);
      read("n-force", newtons(force));
      for (const id of ["hand-force", "n-hand"]) element(id).hidden = !(share > 0);
      if (share > 0) read("n-hand", newtons(share * force));
      read("n-moment", `${Math.hypot(last[6], last[7], last[8]).toFixed(1)} N mm`);
      read("n-tip", tip.map((x) => x.toFixed(1)).join(" "));
      break;
    }
    case "Bodies":
      bodies.set(said.message.active, said.message.json);
      break;
    case "Mass":
      measure.weigh(said.message.volume, said.message.mass, said.message.centre);
      break;
    case "Previewed":
      splines.previewed(said.message);
      break;
    case "PrintFaults":
      printing.show(said.message);
      break;
    case "Remains":
      bodies.remains(said.message);
      break;
    case "Method":
      method.take(said.message);
      break;
    case "Trace":
      experiments.add(said.message.json, said.message.data);
      break;
    case "ShowTool": {
      hand.show(said.message.tool);
      break;
    }
    case "ShowStamp":
      hand.showStamp(said.message.vertices, said.message.triangles);
      break;
    case "Fonts":
      hand.stamp.showFonts(said.message.json);
      break;
    case "SecondHand":
      hand.second.show(said.message);
      break;
    case "Device": {
      const d = said.message;
      hand.device = true;
      document.body.classList.add("device");
      element("hint").hidden = true;
      element("device").hidden = false;
      element("device-name").textContent =
        d.force > 0
          ? `${d.name}: at most ${d.force.toPrecision(2)} N`
          : `${d.name}: gives no force`;
      element("arm").hidden = d.force === 0;
      const reach = element<HTMLInputElement>("reach");
      reach.value = String(Math.log10(d.scale));
      element("reach-out").textContent = `${d.scale.toPrecision(2)} ×`;
      share = d.force > 0 ? d.share : 0;
      element<HTMLInputElement>("stiffness").max = d.max.toPrecision(3);
      element<HTMLInputElement>("stiffness").placeholder = d.stiffness.toPrecision(2);
      break;
    }
    case "State": {
      const s = said.message;
      // Who takes the tool over brings what is chosen here.
      if (s.holds !== 0 && !hand.holds) hand.chooseAll();
      hand.holds = s.holds !== 0;
      element("watching").hidden = hand.holds;
      element<HTMLButtonElement>("undo").disabled = !hand.holds || !s.undo;
      element<HTMLButtonElement>("redo").disabled = !hand.holds || !s.redo;
      element<HTMLButtonElement>("leave").disabled = !hand.holds;
      showDevice(s.safety, s.trip, s.given);
      view.tool.blocked = s.blocked !== 0;
      if (s.blocked !== 0 && !blocked)
        notify(
          "The tool stands in wood there and can't back out along its axis, so it cuts nothing. Lift it, and begin where it has room, point it another way, or take a smaller one.",
        );
      blocked = s.blocked !== 0;
      if (s.removed !== stuck.removed || !hand.heldBack(tip))
        stuck = { removed: s.removed, since: performance.now() };
      else if (performance.now() - stuck.since > STILL_MS) {
        notify(hand.help);
        stuck.since = Infinity;
      }
      read("n-volume", `${(s.volume / 1000).toFixed(2)} cm³`);
      // Not "-0.000".
      read("n-removed", `${(Math.round(s.removed) / 1000 + 0).toFixed(3)} cm³`);
      read("n-step", `${s.step} of ${s.steps}`);
      splines.step(s.step);
      history.setHead(s.step);
      if (step !== s.step) {
        if (step !== 0) announce(`Step ${s.step} of ${s.steps}`);
        pictureSoon((step = s.step));
      }
      if (document.body.dataset.hash !== s.hash) measure.changed();
      Object.assign(document.body.dataset, {
        hash: s.hash,
        step: String(s.step),
        volume: String(s.volume),
      });
      break;
    }
    case "Steps":
      history.add(said.message.data);
      break;
    case "Versions":
      history.setVersions(said.message.json);
      break;
    case "Work": {
      const box = element("work");
      box.hidden = said.message.what === "";
      const bar = box.querySelector("progress")!;
      if (said.message.share >= 0) bar.value = said.message.share;
      else bar.removeAttribute("value");
      box.querySelector("button")!.hidden = said.message.cancellable === 0;
      put("work-what", `${said.message.what} …`);
      break;
    }
    case "Notice":
      // On the first page it may be where something lies that could not be saved.
      notify(said.message.text, document.body.dataset.shown === "start" ? Infinity : 8);
  }
}

let armed = false;
function showDevice(safety: number, trip: string, given: number): void {
  if (!hand.device) return;
  armed = safety !== 0;
  put("arm", armed ? "Stop the force" : "Let it push");
  put(
    "device-state",
    ["Off: it gives no force.", "Waiting: move it clear of the wood.", "On: it gives the force."][
      safety
    ] + (trip ? ` ${trip}` : ""),
  );
  read("device-given", safety === 2 ? `${given.toFixed(2)} N given` : "");
}

/** A small picture of a step for the history, once it is at rest; all by one camera. */
function pictureSoon(of: number, tries = 20): void {
  setTimeout(async () => {
    if (of !== step || !hand.holds || !history.wants(of) || tries === 0) return;
    if (!view.solid.whole || hand.working || bodies.inColours || printing.inColours)
      return pictureSoon(of, tries - 1);
    const png = await view.thumbnail(128, 96);
    if (!png || of !== step) return;
    history.setPicture(of, png);
    const bytes = new Uint8Array(await png.arrayBuffer());
    if (bytes.length <= 65536) send(write.KeepThumbnail({ step: of, png: bytes }));
  }, 600);
}

// ---- Files

function save(name: string, what: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(what);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

async function exportAs(format: string, tolerance: string): Promise<void> {
  try {
    const answer = await request(`/export?format=${format}&tolerance=${tolerance}`);
    if (answer.ok) save(`${title}.${format}`, await answer.blob());
    else notify(await answer.text(), 8, true);
  } catch {
    notify("The file did not arrive; is 'kibori studio' still running?", 8, true);
  }
}

// ---- Buttons and keys

const undo = (): void => send(write.Undo());
const redo = (): void => send(write.Redo());
const leave = (): void => send(write.Leave());
const askExport = (): void => ask("exporting");
const help = (): void => dialog("keys").showModal();
element("undo").onclick = undo;
element("redo").onclick = redo;
element("leave").onclick = leave;
element("export").onclick = askExport;
element("take").onclick = () => send(write.TakeTool());
element("frame").onclick = () => view.frame();
element("help").onclick = help;
element("settings").onclick = () => dialog("settings-box").showModal();
element("work").querySelector("button")!.onclick = () => send(write.CancelWork());
dialog("exporting").onclose = () => {
  if (dialog("exporting").returnValue === "yes")
    void exportAs(
      element<HTMLSelectElement>("format").value,
      element<HTMLInputElement>("tolerance").value || "0",
    );
};
dialog("naming").onclose = () => {
  const name = element<HTMLInputElement>("version").value.trim();
  if (dialog("naming").returnValue === "yes" && name) send(write.NameVersion({ name }));
};
element("sound").onchange = () => {
  senses.sound = element<HTMLInputElement>("sound").checked;
  if (!senses.sound) senses.silence();
};
element("rumble").onchange = () => (senses.rumble = element<HTMLInputElement>("rumble").checked);
element("pause").onclick = () => {
  plot.paused = !plot.paused;
  element("pause").textContent = plot.paused ? "Go on" : "Pause";
};
const sayModel = (): void =>
  put("model-says", MODEL_NOTES[element<HTMLSelectElement>("model").value as Model]);
element("model").addEventListener("change", sayModel);
sayModel();
element("csv").onclick = () => save("forces.csv", plot.csv());
element("arm").onclick = () => send(write.Arm({ armed: armed ? 0 : 1 }));
element("reach").oninput = () =>
  send(write.ChooseReach({ scale: 10 ** Number(element<HTMLInputElement>("reach").value) }));
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("dblclick", (event) => {
  if (!view.hit(event.clientX, event.clientY)) view.frame();
});

const keys = new Keys(
  {
    smaller: { label: "smaller tool", keys: ["["], run: () => hand.nudge("size", 1 / 1.15) },
    larger: { label: "larger tool", keys: ["]"], run: () => hand.nudge("size", 1.15) },
    size: {
      label: "size by moving the pointer, until it is pressed",
      keys: ["f"],
      run: () => hand.startSliding("size"),
    },
    depth: {
      label: "depth by moving the pointer, until it is pressed",
      keys: ["Shift+f"],
      run: () => hand.startSliding("depth"),
    },
    shallower: { label: "shallower", keys: ["{"], run: () => hand.nudge("depth", 1 / 1.15) },
    deeper: { label: "deeper", keys: ["}"], run: () => hand.nudge("depth", 1.15) },
    turn: { label: "turn the tool by 15°", keys: ["t"], run: () => hand.turn() },
    strike: { label: "strike with the mallet", keys: ["Space"], run: () => hand.strike() },
    plane: {
      label: "depth from the plane of the wood under the pointer",
      keys: ["p"],
      run: () => hand.setPlane(),
    },
    centre: {
      label: "strokes in circles about the place under the pointer",
      keys: ["e"],
      run: () => hand.setCentre(),
    },
    mirror: {
      label: "mirror left and right, or nothing",
      keys: ["x"],
      run: () => hand.toggleSymmetry(),
    },
    ...Object.fromEntries(
      BRUSH_MODES.map((mode) => [
        mode,
        {
          label: `${BRUSHES[mode]!.name.toLowerCase()}, or carve again`,
          keys: [BRUSHES[mode]!.key],
          run: () => hand.pick(mode),
        },
      ]),
    ),
    cut: {
      label: "cut the piece along a line",
      keys: ["k"],
      run: () => bodies.take("cut"),
    },
    spline: {
      label: "draw a spline",
      keys: ["Shift+k"],
      run: () => element("spline-draw").click(),
    },
    body: { label: "the next body", keys: ["Shift+b"], run: () => bodies.next() },
    undo: { label: "undo", keys: ["Ctrl+z"], run: undo },
    redo: { label: "redo", keys: ["Ctrl+Shift+z", "Ctrl+y"], run: redo },
    cancel: {
      label: "leave the stroke off",
      keys: ["Escape"],
      run: () => {
        if (splines.leaveOff() || bodies.leaveOff() || measure.leaveOff()) return;
        send(write.Cancel());
        hand.lift();
      },
    },
    front: {
      label: "from the front",
      keys: ["1"],
      run: () => view.frame(new THREE.Vector3(0, -1, 0.001)),
    },
    right: {
      label: "from the right",
      keys: ["3"],
      run: () => view.frame(new THREE.Vector3(1, 0, 0.001)),
    },
    above: {
      label: "from above",
      keys: ["7"],
      run: () => view.frame(new THREE.Vector3(0, -0.001, 1)),
    },
    orthographic: {
      label: "orthographic or perspective",
      keys: ["5"],
      run: () => look.toggleOrthographic(),
    },
    method: {
      label: "the method: rays, dexels and vanished points, or not",
      keys: ["m"],
      run: () => look.toggleMethod(),
    },
    measure: {
      label: "measure, or carve again",
      keys: ["Shift+m"],
      run: () => measure.toggle(),
    },
    printing: {
      label: "check for printing, or not",
      keys: ["Shift+p"],
      run: () => printing.toggle(),
    },
    all: { label: "show all", keys: ["Home"], run: () => view.frame() },
    export: { label: "export", keys: ["Ctrl+e"], run: askExport },
    close: { label: "close the document, and begin another", keys: ["Ctrl+o"], run: leave },
    help: { label: "these keys", keys: ["?"], run: help },
  },
  element("bindings"),
  () => document.querySelector("dialog[open]") !== null || document.body.dataset.shown !== "solid",
);
element("keys-again").onclick = () => keys.reset();
dialog("keys").onclose = () => keys.stopWaiting();
// For tests: from now on every frame takes at least so long [ms], as on a slow computer; 0: as it
// comes.
let frameTakes = 0;
function slowFrames(ms: number): void {
  const runs = frameTakes > 0;
  frameTakes = ms;
  const wait = (): void => {
    for (const until = performance.now() + frameTakes; performance.now() < until; );
    if (frameTakes > 0) requestAnimationFrame(wait);
  };
  if (!runs && ms > 0) requestAnimationFrame(wait);
}
// The browser keeps every measure until it is told not to.
setInterval(() => performance.clearMeasures(), 60000);
// For tests and measurements.
Object.assign(window, {
  kibori: {
    surface: () => view.solid.surface(),
    whole: () => view.solid.whole,
    settled: () => view.painter.settled,
    frames: () => view.painter.frames,
    eye: () => view.cameras.eye,
    middle: () => view.cameras.target.toArray(),
    hit: (x: number, y: number) => {
      const hit = view.hit(x, y);
      return hit && { point: hit.point.toArray(), normal: hit.normal.toArray() };
    },
    onScreen: (place: Vec3) => view.cameras.onScreen(place),
    thumbnail: () => view.thumbnail(128, 96),
    onPiece: (x: number, y: number) => view.hit(x, y) !== null,
    stampsMade: () => hand.stamp.made,
    breakLine: () => line.breakOff(),
    at: (x: number, y: number) => view.hit(x, y)?.point.toArray() ?? null,
    slowFrames,
    still: (still: boolean) => (view.painter.still = plot.still = still),
  },
});
