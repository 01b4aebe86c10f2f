// SPDX-License-Identifier: MIT
// The entry point of the page. It makes the parts and connects them. It handles each message of the
// studio and each button.
import { fillTexts, t } from "./base/texts";
import { actions } from "./actions";
import { announce, ask, dialog, element, input, put, select } from "./base/dom";
import { save } from "./base/files";
import { notify } from "./base/notice";
import type { Vec3 } from "./base/vec3";
import { Connection, type Handlers } from "./connection/connection";
import { MODEL_NOTES, type Model } from "./connection/kinds";
import { write, type State, type Ticks, type Welcome, type Work } from "./connection/messages";
import { TICK_NUMBERS } from "./connection/wire";
import { Experiments } from "./forces/experiments";
import { ForcePlot } from "./forces/plot";
import { Senses } from "./forces/senses";
import { Hand, itemName } from "./hand/hand";
import { Hindered } from "./hand/hindered";
import { Hiding } from "./panels/hiding";
import { History } from "./history/history";
import { StepPictures } from "./history/step_pictures";
import { BodiesPanel } from "./panels/bodies";
import { DevicePanel } from "./panels/device";
import { askExport, listenForExport } from "./panels/export";
import { Keys } from "./panels/keys";
import { Layout } from "./panels/layout";
import { Look } from "./panels/look";
import { Measure } from "./panels/measure";
import { MethodView } from "./panels/method_view";
import { makeNumberRows } from "./panels/number_row";
import { showPiece, showTick } from "./panels/numbers";
import { Palette } from "./panels/palette";
import { Playback } from "./playback/playback";
import { placePopovers } from "./panels/popovers";
import { Presets } from "./panels/presets";
import { Detail } from "./panels/detail";
import { PrintCheck } from "./panels/print_check";
import { Settings } from "./panels/settings";
import { Splines } from "./panels/splines";
import { Start } from "./start/start";
import "./style.css";
import { offerHooks } from "./test_hooks";
import { lookByKeys } from "./view/look_keys";
import { View } from "./view/view";
import type { Material } from "./view/wood";

fillTexts(document.body);
const canvas = element<HTMLCanvasElement>("view");
// Show the view's focus frame only after the Tab key, not after a pointer's press.
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
  notify(t("no_webgl"), Infinity, true);
  throw new Error("no WebGL 2");
}

let rate = 1000; // ticks per second
let title = "Kibori";
let step = 0; // 0: no document is open, or unknown
let firstTime = true;
let tip: Vec3 = [0, 0, 0]; // at the last tick

// ---- Parts

const handlers: Handlers = {
  Start: ({ holds, json }) => showStart(holds !== 0, json),
  Welcome: (w) => showDocument(w),
  Chunks: ({ data, body, frame, more }) => {
    const from = performance.now();
    view.solid.take(data, body);
    send(write.Got({ frame }));
    if (!more) {
      view.complete();
      detail.changed();
    }
    performance.measure("update", { start: from, detail: data.length });
    document.body.dataset.chunks = String(Number(document.body.dataset.chunks ?? 0) + 1);
  },
  Ticks: (ticks) => showTicks(ticks),
  State: (s) => showState(s),
  Bodies: ({ active, json }) => bodies.set(active, json),
  Mass: ({ volume, mass, centre, memory }) => {
    measure.weigh(volume, mass, centre);
    detail.remember(memory);
  },
  Previewed: (previewed) => splines.previewed(previewed),
  PrintFaults: (faults) => printing.show(faults),
  Remains: (remains) => bodies.remains(remains),
  Method: (answer) => method.take(answer),
  Trace: ({ json, data }) => experiments.add(json, data),
  Playback: ({ json }) => playback.set(json),
  Played: (moment) => playback.show(moment),
  ShowTool: ({ tool }) => hand.show(tool),
  ShowStamp: ({ vertices, triangles }) => hand.showStamp(vertices, triangles),
  Fonts: ({ json }) => hand.stamp.showFonts(json),
  SecondHand: (message) => hand.second.show(message),
  Device: (d) => {
    hand.device = true;
    device.show(d);
  },
  Steps: ({ data }) => history.add(data),
  Versions: ({ json }) => history.setVersions(json),
  Work: (work) => showWork(work),
  // On the start page the notice may say where unsaved work is stored, so it stays.
  Notice: ({ text }) => notify(text, document.body.dataset.shown === "start" ? Infinity : 8),
};
const line = new Connection(handlers, (why) => {
  element("lost").hidden = why === null;
  if (why) put("lost-why", `${why.text}${why.trying ? ` ${t("trying_again")}` : ""}`);
  element("again").hidden = why?.trying ?? true;
});
const send = (message: Uint8Array): void => line.send(message);
makeNumberRows({ size: "ratio", depth: "ratio", strength: "ratio", reach: "exponent" });
placePopovers();
// The bodies are made first, so that their gestures get pointer events before the hand does.
const bodies = new BodiesPanel(
  canvas,
  view,
  send,
  () => hand.holds && !hand.readOnly,
  (file, longest) => void start.importer.bring(file, longest),
  () => printing.leave(),
);
const splines = new Splines(
  canvas,
  view,
  send,
  () => hand.holds && !hand.readOnly,
  () => bodies.activeBody,
);
const hiding = new Hiding(canvas, view);
const measure = new Measure(canvas, view, () => send(write.AskMass()));
const detail = new Detail({
  send,
  triangles: () => view.solid.triangles,
  ask: () => send(write.AskMass()),
  may: () => hand.holds && !hand.readOnly,
});
const printing = new PrintCheck(send, () => bodies.leaveColours());
const hand: Hand = new Hand(canvas, view, send, (x, y) => bodies.takeUp(x, y));
const palette = new Palette();
new Presets({
  current: () => ({ item: hand.item, values: hand.values }),
  use: ({ item, values }) => hand.use(item, values),
  nameOf: itemName,
});
const hindered = new Hindered(hand);
/** A brush that is less behind the hand than this is not reported [s]. */
const PENDING_S = 0.3;
const device = new DevicePanel(send);
const layout = new Layout((insets) => view.cameras.cover(insets));
const look = new Look(canvas, view, (ending, what) => save(`${title}.${ending}`, what));
lookByKeys(canvas, view.cameras.controls);
const method = new MethodView(view, send);
look.showsMethod(method);
// Some controls are not listed here. The material belongs to the document. Symmetry and turn would
// surprise the user in another document. tool_memory.ts keeps the numbers of tools and brushes.
const settings = new Settings(
  "shape mode brush color axis model sound rumble pressure pen-brush crumbs steady leads stamp-text every".split(
    " ",
  ),
);
const start = new Start(send);
const plot = new ForcePlot(element("plot"), () => rate);
const senses = new Senses();
const experiments = new Experiments(send);
const playback = new Playback(send);
const history = new History(
  element("history"),
  (to) => send(write.Go({ step: to })),
  () => {
    ask("naming");
    input("version").select();
  },
);
const pictures = new StepPictures(view, history, send, {
  rests: () =>
    view.solid.whole &&
    !view.painter.still &&
    !hand.working &&
    !bodies.inColours &&
    !printing.inColours,
  may: () => hand.holds,
});

// ---- Messages from the studio

function showStart(holds: boolean, json: string): void {
  hand.holds = holds;
  element("watching").hidden = true;
  element("hint").hidden = true;
  view.begin({ origin: [0, 0, 0], pitch: 1 }, [1, 1, 1]);
  history.clear();
  document.title = "Kibori";
  pictures.goTo((step = 0));
  document.body.dataset.shown = "start";
  notify("");
  experiments.offer(start.show(json));
  detail.closed();
}

function showDocument(w: Welcome): void {
  rate = w.rate;
  const name = w.document.replace(/\.kibori$/, ""),
    again = title === name;
  title = name;
  pictures.goTo((step = 0));
  document.title = `${title} – Kibori`;
  element("title").textContent = element("title").title = title;
  document.body.dataset.shown = "solid";
  notify("");
  // The focused element is gone. Move the focus to the piece, so that keys work there.
  const lost =
    document.activeElement === document.body || element("start").contains(document.activeElement);
  start.hide();
  if (lost) canvas.focus();
  element("hint").hidden = !firstTime;
  firstTime = false;
  const kinds = JSON.parse(w.materials) as Material[];
  view.wood.setKinds(kinds);
  put("n-law", kinds[w.material]?.law ?? "–");
  element("material").replaceChildren(
    ...kinds.map((m, i) => new Option(m.name, String(i), i === w.material, i === w.material)),
  );
  // A tool may be as large as the piece and the room around it.
  for (const id of ["size", "depth"])
    input(id).max = String(Math.ceil(Math.max(...w.nodes) * w.pitch));
  if (w.what === 3) playback.begin(name);
  view.begin({ origin: w.origin, pitch: w.pitch }, w.nodes, again);
  bodies.begin();
  splines.reset();
  start.importer.offer(w.page, kinds);
  look.begin(w.document);
  method.begin(w.origin, w.pitch);
  plot.clear();
  history.clear();
  hand.holds = hand.device = false;
  device.begin();
  showReadOnly(w.what);
  layout.measure();
  settings.restore();
  hand.begin();
  measure.begin();
  hiding.begin();
  printing.leave();
  detail.begin(name, w.pitch, w.what === 0);
}

/** `what`: 0 for editing, 1 for read-only, 2 for an experiment, 3 for a milling job. */
function showReadOnly(what: number): void {
  hand.readOnly = what !== 0;
  element("reading").textContent = t(
    what === 3 ? "playback" : what === 2 ? "experiment" : "read_only",
  );
  element("reading").hidden = !hand.readOnly;
  document.body.classList.toggle("read-only", hand.readOnly);
  document.body.classList.toggle("experiment", what === 2);
  document.body.classList.toggle("playback", what === 3);
  layout.choose(what === 3 ? "program" : "tools");
  if (hand.readOnly) element("hint").hidden = true;
}

function showTicks({ start: first, data }: Ticks): void {
  const rows = new Float32Array(data.slice().buffer);
  plot.add(first, rows);
  senses.update(rows, rate);
  const last = [...rows.subarray(rows.length - TICK_NUMBERS)];
  const [force, moment, axis, side] = [3, 6, 9, 12].map((at) => last.slice(at, at + 3) as Vec3);
  tip = last.slice(0, 3) as Vec3;
  const shown = hand.there || hand.device || hand.readOnly || !hand.holds ? tip : null;
  view.tool.place(shown, axis, side, force);
  method.follow(shown, axis);
  showTick(Math.hypot(...force), Math.hypot(...moment), tip, device.share);
}

function showState(s: State): void {
  // A page that takes over the tool sends its own choices.
  if (s.holds !== 0 && !hand.holds) hand.chooseAll();
  hand.holds = s.holds !== 0;
  element("watching").hidden = hand.holds;
  element<HTMLButtonElement>("undo").disabled = !hand.holds || !s.undo;
  element<HTMLButtonElement>("redo").disabled = !hand.holds || !s.redo;
  element<HTMLButtonElement>("leave").disabled = !hand.holds;
  device.showState(s.safety, s.trip, s.given);
  view.tool.blocked = s.blocked !== 0;
  hindered.follow(s, tip);
  const pending = s.pending >= PENDING_S;
  element("pending").hidden = !pending || !hand.holds;
  showPiece(s);
  playback.showPiece(s);
  splines.step(s.step);
  history.setHead(s.step);
  if (step !== s.step) {
    if (step !== 0) announce(t("step_of", { step: s.step, steps: s.steps }));
    pictures.goTo((step = s.step));
  }
  if (document.body.dataset.hash !== s.hash) measure.changed();
  Object.assign(document.body.dataset, {
    hash: s.hash,
    step: String(s.step),
    volume: String(s.volume),
    pending: pending ? "1" : "0",
  });
}

function showWork({ what, share, cancellable }: Work): void {
  const box = element("work");
  box.hidden = what === "";
  const bar = box.querySelector("progress")!;
  if (share >= 0) bar.value = share;
  else bar.removeAttribute("value");
  box.querySelector("button")!.hidden = cancellable === 0;
  put("work-what", `${what} …`);
}

// ---- Buttons and keys

element("again").onclick = () => line.again();
element("undo").onclick = () => send(write.Undo());
element("redo").onclick = () => send(write.Redo());
element("leave").onclick = () => send(write.Leave());
element("export").onclick = askExport;
listenForExport(() => title);
element("take").onclick = () => send(write.TakeTool());
element("frame").onclick = () => view.frame();
element("help").onclick = () => dialog("keys").showModal();
element("settings").onclick = () => dialog("settings-box").showModal();
element("work").querySelector("button")!.onclick = () => send(write.CancelWork());
element("pending").querySelector("button")!.onclick = () => {
  send(write.Cancel());
  hand.lift();
};
dialog("naming").onclose = () => {
  const name = input("version").value.trim();
  if (dialog("naming").returnValue === "yes" && name) send(write.NameVersion({ name }));
};
element("sound").onchange = () => {
  senses.sound = input("sound").checked;
  if (!senses.sound) senses.silence();
};
element("rumble").onchange = () => (senses.rumble = input("rumble").checked);
element("pause").onclick = () => {
  plot.paused = !plot.paused;
  element("pause").textContent = t(plot.paused ? "resume" : "pause");
};
element("csv").onclick = () => save("forces.csv", plot.csv());
const showModel = (): void => put("model-says", MODEL_NOTES[select("model").value as Model]);
element("model").addEventListener("change", showModel);
showModel();
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("dblclick", (event) => {
  if (!view.hit(event.clientX, event.clientY)) view.frame();
});
const keys = new Keys(
  actions({ send, view, hand, bodies, splines, measure, hiding, printing, look, palette }),
  element("bindings"),
  () => document.querySelector("dialog[open]") !== null || document.body.dataset.shown !== "solid",
);
element("keys-again").onclick = () => keys.reset();
dialog("keys").onclose = () => keys.stopWaiting();
// The browser keeps all performance measures until they are cleared.
setInterval(() => performance.clearMeasures(), 60000);
offerHooks(view, plot, hand, line);
