// SPDX-License-Identifier: MIT
// Made by tools/make_protocol.py from protocol/messages.json: change that.
import type { Vec3 } from "../base/vec3";
import type { Mode, Model, Tool } from "./kinds";
import { Reader, Writer } from "./wire";

export const PROTOCOL_VERSION = 18;

/** The first message of a page, with the key that POST /enter gave for the token. Welcome or Start answers; where the key is another one, the line is closed with code 1008. */
export interface Hello { version: number; key: string }
/** Where the tool's tip is wanted [mm], and its axis, from the tip up; time [s] of the pointer's event, by the page's clock. After Press the tool follows these places one after another, as their times say. */
export interface Aim { tip: Vec3; axis: Vec3; time: number }
/** A stroke begins at `tip`: the tool backs out from there along its axis until it is clear of material, and comes in again. time: as of Aim. */
export interface Press { tip: Vec3; axis: Vec3; mode: Mode; time: number }
/** The stroke is over, once the tool has been everywhere that it was aimed to. */
export type Lift = Record<string, never>;
/** The stroke that is being made is as if it had not been. */
export type Cancel = Record<string, never>;
/** One step back. */
export type Undo = Record<string, never>;
/** One step forth. */
export type Redo = Record<string, never>;
/** The tool that is held from now on. */
export interface ChooseTool { tool: Tool | null }
/** The hand's strength [N], 20 to 1000; the stiffness between hand and tool [N/mm], 0: what suits a pointer or the device; powered: 1 where a motor turns the tool, and the hand bears a tenth of the cut; 2 where a press drives it, and the hand bears a hundredth. */
export interface ChooseHand { strength: number; stiffness: number; powered: number }
/** The page has taken this frame of chunks in, and can take the next. */
export interface Got { frame: number }
/** This page wants to hold the tool; the others then watch. */
export type TakeTool = Record<string, never>;
/** A new document, where none is open. shape: 0 block, 1 log, 2 ball. size [mm]: of its box; the log's and the ball's diameter is x, the log's length z. pitch [mm]. material: a number of Start's. An empty name: the time. */
export interface Begin { shape: number; size: Vec3; pitch: number; material: number; name: string }
/** One of Start's documents, where none is open. */
export interface Open { name: string }
/** The document is saved and closed; Start follows. */
export type Leave = Record<string, never>;
/** To a step of the history. */
export interface Go { step: number }
/** Gives the step where the document stands a name. */
export interface NameVersion { name: string }
/** A small picture of a step (PNG, 64 kB at most). */
export interface KeepThumbnail { step: number; png: Uint8Array }
/** What is added: a number of Welcome's materials. */
export interface ChooseMaterial { material: number }
/** How motion becomes force. */
export interface ChooseModel { model: Model }
/** What Work tells of is not to be. */
export type CancelWork = Record<string, never>;
/** One of Start's examples is carved as a new document, where none is open. */
export interface CarveExample { name: string }
/** Where all that the tool does is done again, about the lattice's middle: planes in which it is mirrored (bits 1 normal to x, 2 to y, 4 to z), and how many times it goes around the axis (0 x, 1 y, 2 z) in equal parts of a turn; 1: no more than itself. */
export interface ChooseSymmetry { planes: number; fold: number; axis: number }
/** What a force device's tool does. */
export interface ChooseWork { mode: Mode }
/** Lets a force device push (1) or not (0). */
export interface Arm { armed: number }
/** A force device's tool is here from now on [mm], wherever the hand is. */
export interface BringTool { tip: Vec3 }
/** How far the tool goes for a mm of a force device's hand. */
export interface ChooseReach { scale: number }
/** A scene (TOML, without files) is carved to be looked at, where nothing is open; Trace follows. model: its name, or empty: as the scene says. pace: 1 the scene's own time, 4 four times as fast, 0 as fast as it goes. */
export interface RunExperiment { name: string; scene: string; model: string; pace: number }
/** How far the tool is turned about its own axis from the next place on [rad]. */
export interface ChooseTurn { turn: number }
/** A blow of a mallet (3 J) on the tool that cuts: it is driven on along its aim. */
export type Strike = Record<string, never>;
/** The brush of modes that reshape, from the next stroke on: radius [mm]; strength, below 0 for inflate only; falloff 0 smooth, 1 linear, 2 constant; keep: 1 where smoothing and grabbing keep the volume; the colour of paint; and what flatten goes to: plane 0 that under the stroke's beginning, 1 that under each dab, 2 the one through the point [mm] with that normal; of thrown clay, how far a second finger stands across the wall [mm], 0: there is none. */
export interface ChooseBrush { radius: number; strength: number; falloff: number; keep: number; red: number; green: number; blue: number; plane: number; point: Vec3; normal: Vec3; wall: number }
/** What the rays of one field (axis 0 x, 1 y, 2 z) find near a place [mm]: in the cube of that half side, every so-manyth ray both ways. Method answers once, no sooner than 33 ms after the last answer; a newer question takes the place of one that waits. */
export interface AskMethod { axis: number; centre: Vec3; radius: number; every: number }
/** What is done with bodies, as a step, as documents keep it: {"verb":"join","bodies":[1,2]}. */
export interface ActOnBodies { action: string }
/** The body that strokes go to from now on. */
export interface ChooseBody { body: number }
/** What becomes of pieces that a stroke severs: 0 those under a tenth fall away and larger ones become bodies, 1 they stay, 2 fall away, 3 become bodies. */
export interface ChooseCrumbs { rule: number }
/** Whether the body that is worked on is shown in colours that tell how far its surface is from what is no-go; Remains tells the numbers. */
export interface ShowRemains { shown: number }
/** What this would come to is shown from now on, and is no step; text as of ActOnBodies, or empty: no more. Previewed answers. */
export interface PreviewAction { action: string }
/** What was done with bodies in a step, on the way to head, is done otherwise: text as of ActOnBodies. A new step beside it, and what followed up to head done again after it. */
export interface ReviseStep { step: number; head: number; action: string }
/** The second hand's tool from now on, and what it does while it is pressed: cut, deposit or touch; off: there is no second hand. Its pointer's strokes have the guide and the string of ChooseGuide; lead, entry, lift: as there, of this tool. */
export interface ChooseSecond { tool: Tool | null; mode: Mode; lead: number; entry: number; lift: number }
/** The second hand's tool comes in at `tip`, as of Press; while the first works, in its stroke. time: as of Aim. */
export interface PressSecond { tip: Vec3; axis: Vec3; time: number }
/** Where the second hand's tool is wanted, as of Aim. */
export interface AimSecond { tip: Vec3; axis: Vec3; time: number }
/** The second hand lets go, once its tool has been everywhere that it was aimed to. */
export type LiftSecond = Record<string, never>;
/** How the pointer's strokes behave from the next one on. guide: 0 none, 1 a straight line, whose direction is a multiple of snap [degrees] (0: any), 2 a circle about the centre [mm], 3 the curve through these points (three f64 each [mm]), closed or not. steady: the tool is drawn behind the hand on a string so long [mm]. lead: its local x axis turns to the way it goes; it goes in and comes out over `entry` [mm], from `lift` [mm] above. stamp: it is pressed in, from `lift` above, where the stroke begins, or, where `every` is not 0, at so many mm from each other on its way. */
export interface ChooseGuide { guide: number; snap: number; centre: Vec3; closed: number; steady: number; lead: number; entry: number; lift: number; stamp: number; every: number; curve: Uint8Array }
/** What the body that is worked on weighs; Mass answers. */
export type AskMass = Record<string, never>;
/** A stamp is held from now on. what: 0 letters: `text` in a `font` (a family), `size` [mm] high as a capital H, `depth` long; 1 a picture (PNG) as a relief, `size` wide, white `depth` deeper than black, or, inverted, black deeper; 2 a mesh, `size` wide as the longer of its sides. name: the file's, data: its bytes. ShowStamp tells what it is. */
export interface ChooseStamp { what: number; text: string; font: string; size: number; depth: number; invert: number; name: string; data: Uint8Array }
/** Which fonts are installed where the studio runs; Fonts answers. */
export type AskFonts = Record<string, never>;
/** Whether the body that is worked on is shown in colours that tell what a printer would fail at (1; no longer what ShowRemains asked for): walls thinner than `wall` [mm], faces that look down and lean from upright by more than `overhang` [degrees], loose pieces. PrintFaults tells the numbers. */
export interface ShowFaults { shown: number; wall: number; overhang: number }
/** A document is open: the lattice (lower corner [mm], nodes, pitch [mm]), the servo's rate [Hz], the document's name, its materials (JSON: name, color, rings: how strongly they stand out, 0 to 1), which of them its stock is of, what the page is called in its requests over HTTP, and what it is: 0 carved, 1 only looked at, 2 an experiment. All that was shown before is of another one. */
export interface Welcome { version: number; origin: Vec3; nodes: Vec3; pitch: number; rate: number; document: string; materials: string; material: number; page: string; what: number }
/** Surface of one body that changed; the page answers Got. Each chunk: place x y z (u16), numbers of vertices and triangles (u32), whether any is painted (u16), vertices, corners (u16 each), and of painted ones a colour for each vertex (red, green, blue, 255 where it is painted or 0: u8). A vertex: x y z (u16, 1/2048 pitch from 16 place - 1), normal (3 x i8, 1/127), material (u8). */
export interface Chunks { frame: number; more: number; body: number; data: Uint8Array }
/** Every servo tick since the last: tip [mm], force of the wood on the tool [N], moment about the tip [N mm], and of the tool's frame the third column (its axis) and the first, fifteen f32 a tick. start: number of the first. */
export interface Ticks { start: number; data: Uint8Array }
/** Volume [mm^3], how much less that is than the stock's [mm^3], where the document stands; whether this page holds the tool; whether the tool, which is pressed, stands in material and can't back out. Of a force device: safety 0 off, 1 waits for the hand to be still, 2 pushes; why it is off; the force it gives [N]. */
export interface State { volume: number; removed: number; step: number; steps: number; undo: number; redo: number; holds: number; blocked: number; hash: string; safety: number; trip: string; given: number }
/** A sentence for the person. */
export interface Notice { text: string }
/** No document is open. JSON: documents (name, changed: s since 1970, bytes), materials (as of Welcome), examples (name, about). */
export interface Start { version: number; holds: number; json: string }
/** Steps that this page was not told of yet, by their numbers: number, the one before it or 0 (u32 each), what it removed [mm^3] (f32), when it was begun [s since 1970] (f64; 0: not known), the tool (text, as JSON; null: none), mode (u8; off: the tool only moved), whether a thumbnail of it is kept (u8), label (text). */
export interface Steps { data: Uint8Array }
/** JSON: the number of the step of each name. */
export interface Versions { json: string }
/** What takes a while and can be cancelled; empty: nothing. share: how much of it is done, 0 to 1; below 0: not known. */
export interface Work { what: string; share: number; cancellable: number }
/** After Welcome, where a force device holds the tool, and whenever its reach or the hand changes: its name, the force it can give [N] (0: none), the stiffness that it renders and the greatest it can bear [N/mm, at the hand], the reach, and which share of the wood's force is felt. */
export interface Device { name: string; force: number; stiffness: number; max: number; scale: number; share: number }
/** What an experiment came to. JSON: run (a number of its own), name, model, finished, ticks, removed_mm3, mean_force_N (where there is any), max_force_N, max_moment_Nmm, step_us, marks (label, time_s). Rows: time [s], force [N], moment [N mm], seven f32; of at most 100 000, those with the largest force. */
export interface Trace { json: string; data: Uint8Array }
/** The tool from now on, of an experiment or of whoever holds it. */
export interface ShowTool { tool: Tool | null }
/** Answers AskMethod from the newest snapshot. Rays u, u + every, ... (columns of them) by v, v + every, ... (rows of them) of the field, 32 both ways at most: where that would be more, every is larger than it was asked. spans: of each ray, u first, how many spans reach between the depths low and high [lattice units] (u8, the first 16), and of each its ends in and out (f32). vanished: nodes x y z (u16 each) between these depths, on these rays and on those between them, four times as many both ways or all, that were in the material when this page was answered last and are not now, evenly chosen where they are more than 2048; gone: how many they are. Of the newest tick that took or added any: points (K, of the whole model), volume (how much less material there is for it [mm^3]), motion (of the tool's tip [mm]), force (of the wood on the tool [N]). ticks: how many there were since the last answer, and taken: K of them all. */
export interface Method { axis: number; every: number; u: number; v: number; columns: number; rows: number; low: number; high: number; gone: number; points: number; volume: number; motion: Vec3; force: Vec3; ticks: number; taken: number; spans: Uint8Array; vanished: Uint8Array }
/** Which bodies there are, and the one that strokes go to. JSON: id, name, pose (of the body's lattice in the world: its origin [mm], then the columns of its frame), visible, locked, no_go, volume_mm3. Chunks of a body that is not there, is hidden, or stands otherwise than it was told before are no more; those of one that is shown follow. */
export interface Bodies { active: number; json: string }
/** Of what ShowRemains asked for: how far the surface of the body that is worked on is from what is no-go, at most and on average [mm], how much of it is outside that [mm^3], and the distance that has the last colour [mm]. A scale of 0: nothing is no-go, and no colours are shown. */
export interface Remains { max: number; mean: number; volume: number; scale: number }
/** Answers PreviewAction: why it can't be shown, or empty. Of a spline, forces: JSON, of each control point the force [N] on the hand that moved it there since the last preview, as of soft clay. */
export interface Previewed { error: string; forces: string }
/** The second hand's tool as of the newest tick: tip [mm], the third column of its frame (its axis) and the first, and the force of the wood on it [N]; there: 0 where there is no second hand. */
export interface SecondHand { there: number; tool: Tool | null; tip: Vec3; axis: Vec3; side: Vec3; force: Vec3 }
/** Answers AskMass: the body, its volume [mm^3], its mass [g] (0: of one of its materials the density is not known), and its centre of gravity [mm] in the world. */
export interface Mass { body: number; volume: number; mass: number; centre: Vec3 }
/** The stamp that is held: its triangles in its own frame [mm], tip at the origin: vertices (three f32 each) and their corners (three u32 each). */
export interface ShowStamp { vertices: Uint8Array; triangles: Uint8Array }
/** Answers AskFonts. JSON: the families, in alphabetical order. */
export interface Fonts { json: string }
/** Of what ShowFaults asked for: surface that hangs, and that is of thin walls [mm^2], of so much in all; the thinnest wall [mm], 0: there is none; and how many pieces there are, of which all but the largest are loose. */
export interface PrintFaults { overhang: number; thin: number; area: number; thinnest: number; pieces: number }
/** At --publish HOST:PORT, the first message and again where another document is opened; readers say nothing. JSON: what the rows of PublishedTicks are of, row_bytes, and their columns (name, type, offset in bytes, count). */
export interface PublishedAbout { version: number; json: string }
/** Every servo tick since the last such message: rows of PublishedAbout's row_bytes, one for each hand. */
export interface PublishedTicks { rows: Uint8Array }

export const write = {
  Hello: (m: Hello) => new Writer(1).u16(m.version).text(m.key).done(),
  Aim: (m: Aim) => new Writer(2).vec3(m.tip).vec3(m.axis).f64(m.time).done(),
  Press: (m: Press) => new Writer(3).vec3(m.tip).vec3(m.axis).mode(m.mode).f64(m.time).done(),
  Lift: () => new Writer(4).done(),
  Cancel: () => new Writer(5).done(),
  Undo: () => new Writer(6).done(),
  Redo: () => new Writer(7).done(),
  ChooseTool: (m: ChooseTool) => new Writer(8).tool(m.tool).done(),
  ChooseHand: (m: ChooseHand) => new Writer(9).f64(m.strength).f64(m.stiffness).u8(m.powered).done(),
  Got: (m: Got) => new Writer(10).u32(m.frame).done(),
  TakeTool: () => new Writer(11).done(),
  Begin: (m: Begin) => new Writer(12).u8(m.shape).vec3(m.size).f64(m.pitch).u8(m.material).text(m.name).done(),
  Open: (m: Open) => new Writer(13).text(m.name).done(),
  Leave: () => new Writer(14).done(),
  Go: (m: Go) => new Writer(15).u32(m.step).done(),
  NameVersion: (m: NameVersion) => new Writer(16).text(m.name).done(),
  KeepThumbnail: (m: KeepThumbnail) => new Writer(17).u32(m.step).raw(m.png).done(),
  ChooseMaterial: (m: ChooseMaterial) => new Writer(18).u8(m.material).done(),
  ChooseModel: (m: ChooseModel) => new Writer(19).model(m.model).done(),
  CancelWork: () => new Writer(20).done(),
  CarveExample: (m: CarveExample) => new Writer(21).text(m.name).done(),
  ChooseSymmetry: (m: ChooseSymmetry) => new Writer(22).u8(m.planes).u8(m.fold).u8(m.axis).done(),
  ChooseWork: (m: ChooseWork) => new Writer(23).mode(m.mode).done(),
  Arm: (m: Arm) => new Writer(24).u8(m.armed).done(),
  BringTool: (m: BringTool) => new Writer(25).vec3(m.tip).done(),
  ChooseReach: (m: ChooseReach) => new Writer(26).f64(m.scale).done(),
  RunExperiment: (m: RunExperiment) => new Writer(27).text(m.name).text(m.scene).text(m.model).f64(m.pace).done(),
  ChooseTurn: (m: ChooseTurn) => new Writer(28).f64(m.turn).done(),
  Strike: () => new Writer(29).done(),
  ChooseBrush: (m: ChooseBrush) => new Writer(30).f64(m.radius).f64(m.strength).u8(m.falloff).u8(m.keep).u8(m.red).u8(m.green).u8(m.blue).u8(m.plane).vec3(m.point).vec3(m.normal).f64(m.wall).done(),
  AskMethod: (m: AskMethod) => new Writer(31).u8(m.axis).vec3(m.centre).f64(m.radius).u8(m.every).done(),
  ActOnBodies: (m: ActOnBodies) => new Writer(32).text(m.action).done(),
  ChooseBody: (m: ChooseBody) => new Writer(33).u32(m.body).done(),
  ChooseCrumbs: (m: ChooseCrumbs) => new Writer(34).u8(m.rule).done(),
  ShowRemains: (m: ShowRemains) => new Writer(35).u8(m.shown).done(),
  PreviewAction: (m: PreviewAction) => new Writer(36).text(m.action).done(),
  ReviseStep: (m: ReviseStep) => new Writer(37).u32(m.step).u32(m.head).text(m.action).done(),
  ChooseSecond: (m: ChooseSecond) => new Writer(38).tool(m.tool).mode(m.mode).u8(m.lead).f64(m.entry).f64(m.lift).done(),
  PressSecond: (m: PressSecond) => new Writer(39).vec3(m.tip).vec3(m.axis).f64(m.time).done(),
  AimSecond: (m: AimSecond) => new Writer(40).vec3(m.tip).vec3(m.axis).f64(m.time).done(),
  LiftSecond: () => new Writer(41).done(),
  ChooseGuide: (m: ChooseGuide) => new Writer(42).u8(m.guide).f64(m.snap).vec3(m.centre).u8(m.closed).f64(m.steady).u8(m.lead).f64(m.entry).f64(m.lift).u8(m.stamp).f64(m.every).raw(m.curve).done(),
  AskMass: () => new Writer(43).done(),
  ChooseStamp: (m: ChooseStamp) => new Writer(44).u8(m.what).text(m.text).text(m.font).f64(m.size).f64(m.depth).u8(m.invert).text(m.name).raw(m.data).done(),
  AskFonts: () => new Writer(45).done(),
  ShowFaults: (m: ShowFaults) => new Writer(46).u8(m.shown).f64(m.wall).f64(m.overhang).done(),
};

/** What the studio may say. */
export type FromStudio =
  | { kind: "Welcome"; message: Welcome }
  | { kind: "Chunks"; message: Chunks }
  | { kind: "Ticks"; message: Ticks }
  | { kind: "State"; message: State }
  | { kind: "Notice"; message: Notice }
  | { kind: "Start"; message: Start }
  | { kind: "Steps"; message: Steps }
  | { kind: "Versions"; message: Versions }
  | { kind: "Work"; message: Work }
  | { kind: "Device"; message: Device }
  | { kind: "Trace"; message: Trace }
  | { kind: "ShowTool"; message: ShowTool }
  | { kind: "Method"; message: Method }
  | { kind: "Bodies"; message: Bodies }
  | { kind: "Remains"; message: Remains }
  | { kind: "Previewed"; message: Previewed }
  | { kind: "SecondHand"; message: SecondHand }
  | { kind: "Mass"; message: Mass }
  | { kind: "ShowStamp"; message: ShowStamp }
  | { kind: "Fonts"; message: Fonts }
  | { kind: "PrintFaults"; message: PrintFaults };

/** Throws where it is none of them, or too short or long. */
export function read(data: ArrayBuffer): FromStudio {
  const r = new Reader(data);
  const kind = r.u8();
  switch (kind) {
    case 64:
      return r.end({ kind: "Welcome", message: { version: r.u16(), origin: r.vec3(), nodes: r.vec3(), pitch: r.f64(), rate: r.f64(), document: r.text(), materials: r.text(), material: r.u8(), page: r.text(), what: r.u8() } });
    case 65:
      return r.end({ kind: "Chunks", message: { frame: r.u32(), more: r.u8(), body: r.u32(), data: r.raw() } });
    case 66:
      return r.end({ kind: "Ticks", message: { start: r.f64(), data: r.raw() } });
    case 67:
      return r.end({ kind: "State", message: { volume: r.f64(), removed: r.f64(), step: r.u32(), steps: r.u32(), undo: r.u8(), redo: r.u8(), holds: r.u8(), blocked: r.u8(), hash: r.text(), safety: r.u8(), trip: r.text(), given: r.f64() } });
    case 68:
      return r.end({ kind: "Notice", message: { text: r.text() } });
    case 69:
      return r.end({ kind: "Start", message: { version: r.u16(), holds: r.u8(), json: r.text() } });
    case 70:
      return r.end({ kind: "Steps", message: { data: r.raw() } });
    case 71:
      return r.end({ kind: "Versions", message: { json: r.text() } });
    case 72:
      return r.end({ kind: "Work", message: { what: r.text(), share: r.f64(), cancellable: r.u8() } });
    case 73:
      return r.end({ kind: "Device", message: { name: r.text(), force: r.f64(), stiffness: r.f64(), max: r.f64(), scale: r.f64(), share: r.f64() } });
    case 74:
      return r.end({ kind: "Trace", message: { json: r.text(), data: r.raw() } });
    case 75:
      return r.end({ kind: "ShowTool", message: { tool: r.tool() } });
    case 76:
      return r.end({ kind: "Method", message: { axis: r.u8(), every: r.u16(), u: r.u16(), v: r.u16(), columns: r.u16(), rows: r.u16(), low: r.f64(), high: r.f64(), gone: r.u32(), points: r.f64(), volume: r.f64(), motion: r.vec3(), force: r.vec3(), ticks: r.u32(), taken: r.f64(), spans: r.raw(), vanished: r.raw() } });
    case 77:
      return r.end({ kind: "Bodies", message: { active: r.u32(), json: r.text() } });
    case 78:
      return r.end({ kind: "Remains", message: { max: r.f64(), mean: r.f64(), volume: r.f64(), scale: r.f64() } });
    case 79:
      return r.end({ kind: "Previewed", message: { error: r.text(), forces: r.text() } });
    case 80:
      return r.end({ kind: "SecondHand", message: { there: r.u8(), tool: r.tool(), tip: r.vec3(), axis: r.vec3(), side: r.vec3(), force: r.vec3() } });
    case 81:
      return r.end({ kind: "Mass", message: { body: r.u32(), volume: r.f64(), mass: r.f64(), centre: r.vec3() } });
    case 82:
      return r.end({ kind: "ShowStamp", message: { vertices: r.raw(), triangles: r.raw() } });
    case 83:
      return r.end({ kind: "Fonts", message: { json: r.text() } });
    case 84:
      return r.end({ kind: "PrintFaults", message: { overhang: r.f64(), thin: r.f64(), area: r.f64(), thinnest: r.f64(), pieces: r.u32() } });
    default:
      throw new Error(`a message of kind ${kind}, which is none`);
  }
}
