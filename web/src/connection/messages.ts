// SPDX-License-Identifier: MIT
// Made by tools/make_protocol.py from protocol/messages.json; edit that file.
import type { Vec3 } from "../base/vec3";
import type { Mode, Model, Tool } from "./kinds";
import { Reader, Writer } from "./wire";

export const PROTOCOL_VERSION = 24;

/** The first message of a page. key: the page got it from POST /enter, in exchange for the token. The studio answers with Welcome or Start. A wrong key closes the connection with code 1008. */
export interface Hello { version: number; key: string }
/** The requested position of the tool's tip [mm], and the direction of its axis, from the tip into the tool. time [s]: when the pointer's event happened, by the page's clock. After Press, the tool follows these positions one after another, at their times. pressure: that of a pen, or 1 without a pen; see ChooseBrush. */
export interface Aim { tip: Vec3; axis: Vec3; time: number; pressure: number }
/** Begins a stroke at `tip`. If the tool would be inside material there, it begins farther out on its axis, clear of material, and then goes in to `tip`. time and pressure: as in Aim. */
export interface Press { tip: Vec3; axis: Vec3; mode: Mode; time: number; pressure: number }
/** Ends the stroke, after the tool has followed all poses of Aim. */
export type Lift = Record<string, never>;
/** Discards the current stroke. */
export type Cancel = Record<string, never>;
/** Goes one step back. */
export type Undo = Record<string, never>;
/** Goes one step forward. */
export type Redo = Record<string, never>;
/** Sets the tool. */
export interface ChooseTool { tool: Tool | null }
/** The hand's strength [N], 20 to 1000. The stiffness of the spring between hand and tool [N/mm]; 0: the default for the pointer or the device. powered: 1 if a motor turns the tool, and the hand receives a tenth of the cutting force; 2 if a press drives it, and the hand receives a hundredth. */
export interface ChooseHand { strength: number; stiffness: number; powered: number }
/** The page has received this frame of chunks and can take the next. */
export interface Got { frame: number }
/** This page wants to hold the tool. The other pages then watch. */
export type TakeTool = Record<string, never>;
/** Makes a new document if none is open. shape: 0 block, 1 log, 2 ball. size [mm]: of its box; x is the diameter of the log and the ball, and z is the log's length. pitch [mm]. material: an index of Start's materials. If the name is empty, the time becomes the name. */
export interface Begin { shape: number; size: Vec3; pitch: number; material: number; name: string }
/** Opens one of Start's documents if none is open. */
export interface Open { name: string }
/** Saves and closes the document. Start follows. */
export type Leave = Record<string, never>;
/** Goes to a step of the history. */
export interface Go { step: number }
/** Names the current step. */
export interface NameVersion { name: string }
/** A small picture of a step (PNG, at most 64 kB). */
export interface KeepThumbnail { step: number; png: Uint8Array }
/** The material to add: an index of Welcome's materials. */
export interface ChooseMaterial { material: number }
/** The force model. */
export interface ChooseModel { model: Model }
/** Cancels the job that Work reports. */
export type CancelWork = Record<string, never>;
/** Carves one of Start's examples as a new document if none is open. */
export interface CarveExample { name: string }
/** Repeats everything that the tool does, symmetrically about the middle of the lattice. planes: mirror planes (bits 1 normal to x, 2 to y, 4 to z). fold: the number of repetitions about the axis (0 x, 1 y, 2 z) in equal parts of a turn; 1: no repetition. */
export interface ChooseSymmetry { planes: number; fold: number; axis: number }
/** Chooses what a force device's tool does. */
export interface ChooseWork { mode: Mode }
/** Permits (1) or forbids (0) that a force device pushes the hand. */
export interface Arm { armed: number }
/** Moves a force device's tool to this position [mm], while the hand stays in place. */
export interface BringTool { tip: Vec3 }
/** The distance that the tool moves per mm of a force device's hand. */
export interface ChooseReach { scale: number }
/** Carves a scene while the user watches, if no document is open. At the end, the studio sends Trace. scene: TOML that names no files. model: the name of a force model; empty: that of the scene. pace: 1: the scene's own speed; 4: four times as fast; 0: as fast as possible. */
export interface RunExperiment { name: string; scene: string; model: string; pace: number }
/** The tool's rotation about its own axis [rad], from the next position on. */
export interface ChooseTurn { turn: number }
/** A mallet hits the cutting tool with an energy of 3 J. This drives the tool along its aim. */
export type Strike = Record<string, never>;
/** The brush of reshaping modes from the next stroke on. radius [mm]. strength: negative only for inflate, crease, pinch and mask. falloff: 0 smooth, 1 linear, 2 constant. keep: 1 if smoothing and grabbing keep the volume. red, green, blue: the colour of paint. plane: the plane for flatten, trim and build. 0: the plane under the stroke's beginning. 1: the plane under each dab. 2: the plane through `point` [mm] with `normal`. wall: for throw, the distance to a second finger on the other side of the wall [mm]; 0: there is no second finger. mask: what the mode mask does: 0 paint, 1 invert, 2 blur, 3 cavity, 4 height, 5 material. mask_material: the number of a material for 5. alpha: the texture of the brush, as an index in the list ALPHAS of kinds.ts; The entry `picture` is the picture of ChooseTexture; without such a picture, there is no texture. pressure: what the pressure of a pen changes: 0 nothing, 1 the size, 2 the strength, 3 both. */
export interface ChooseBrush { radius: number; strength: number; falloff: number; keep: number; red: number; green: number; blue: number; plane: number; point: Vec3; normal: Vec3; wall: number; mask: number; mask_material: number; alpha: number; pressure: number }
/** Asks for the rays of one field (axis 0 x, 1 y, 2 z) near a position [mm]. The rays are in a cube with half side `radius`. every: 1 for all of these rays, n for every n-th in both directions. The studio answers once with Method, at least 33 ms after its last answer. A newer request replaces a request that waits. */
export interface AskMethod { axis: number; centre: Vec3; radius: number; every: number }
/** Runs an action on bodies as a step, in the form of documents: {"verb":"join","bodies":[1,2]}. */
export interface ActOnBodies { action: string }
/** Makes a body the active one, which strokes change. */
export interface ChooseBody { body: number }
/** The rule for pieces that a stroke cuts off. 0: a piece below a tenth of the piece that it came from falls away, and a larger one becomes a body. 1: all stay. 2: all fall away. 3: all become bodies. */
export interface ChooseCrumbs { rule: number }
/** Switches colours on (1) or off (0) that show the distance of the active body's surface from the protected region. Remains reports the numbers. */
export interface ShowRemains { shown: number }
/** Shows the result of an action, without a step in the history. action: as in ActOnBodies; empty: ends the preview. The studio answers with Previewed. */
export interface PreviewAction { action: string }
/** Replaces the action of the earlier step `step`, which is on the path to the step `head`. action: as in ActOnBodies. The studio adds a new step next to the old one. After the new step, it repeats the later steps up to `head`. */
export interface ReviseStep { step: number; head: number; action: string }
/** The second hand's tool, and its mode while it is pressed: cut, deposit or touch; off: there is no second hand. Its strokes use the guide and the string of ChooseGuide. lead, entry, lift: as in ChooseGuide, but for this tool. */
export interface ChooseSecond { tool: Tool | null; mode: Mode; lead: number; entry: number; lift: number }
/** Presses the second hand's tool at `tip`, as in Press. While the first hand works, the second hand joins its stroke. time: as in Aim. */
export interface PressSecond { tip: Vec3; axis: Vec3; time: number }
/** The requested pose of the second hand's tool, as in Aim. */
export interface AimSecond { tip: Vec3; axis: Vec3; time: number }
/** Lifts the second hand after its tool has followed all aims. */
export type LiftSecond = Record<string, never>;
/** How the strokes of the pointer behave, from the next stroke on. guide: 0: none. 1: a straight line; its direction is a multiple of `snap` [degrees], or any direction if `snap` is 0. 2: a circle about `centre` [mm]. 3: the curve through the points of `curve` (three f64 each [mm]); closed: 1 if the curve is closed. steady: the length of the string that pulls the tool behind the hand [mm]. lead: the tool's local x axis turns to its path; it starts `lift` [mm] above the wood, goes in over `entry` [mm] of path, and comes out in the same way. stamp: the tool is pressed in from `lift` above the wood: once where the stroke begins, or every `every` mm along its path if `every` is not 0. */
export interface ChooseGuide { guide: number; snap: number; centre: Vec3; closed: number; steady: number; lead: number; entry: number; lift: number; stamp: number; every: number; curve: Uint8Array }
/** Asks for the mass of the active body. The studio answers with Mass. */
export type AskMass = Record<string, never>;
/** Chooses a stamp. what: 0 letters, 1 a picture, 2 a mesh. Letters: `text` in a `font` (a family); `size` is the height of a capital H, and `depth` the length of the letters [mm]. A picture (PNG) is a relief of width `size`. White parts are `depth` deeper than black parts; if `invert` is 1, black parts are deeper. A mesh: its longer horizontal side is `size`. name: the file's name. data: its bytes. ShowStamp reports the result. */
export interface ChooseStamp { what: number; text: string; font: string; size: number; depth: number; invert: number; name: string; data: Uint8Array }
/** Asks for the fonts that are installed on the studio's machine. The studio answers with Fonts. */
export type AskFonts = Record<string, never>;
/** Switches colours on (1) or off (0) that show printing faults of the active body. They replace those of ShowRemains. The faults are walls thinner than `wall` [mm], faces that look down and lean from upright by more than `overhang` [degrees], loose pieces. PrintFaults reports the numbers. */
export interface ShowFaults { shown: number; wall: number; overhang: number }
/** Carves a document of the library again with another pitch [mm], into a new document, and opens that. No document may be open. */
export interface ChangeDetail { document: string; pitch: number }
/** Plays the milling job, or pauses it. speed: seconds of the machine per second; 0: as fast as possible. stops: 1 if it stops at collisions. */
export interface PlayProgram { playing: number; speed: number; stops: number }
/** Goes to a time of the milling job [s]. If this time is not computed yet, goes to the last computed time. */
export interface SeekProgram { time: number }
/** forward 1: goes to the end of the next line that moves the tool. forward 0: goes to the beginning of the current line. */
export interface StepProgram { forward: number }
/** Goes to the end of a line's first execution. program: its index in Playback. line: from 1. If the line is not computed yet, the studio waits until it is. */
export interface GoToLine { program: number; line: number }
/** Runs the milling job into a new document, and opens that. If the name is empty, the job's name is used. */
export interface KeepProgram { name: string }
/** The picture (PNG, at most 1024 pixels on a side) for the texture `picture` of brushes. Black has no effect, white the full effect. name: the file's name, for messages. */
export interface ChooseTexture { name: string; data: Uint8Array }
/** A document is open. origin, nodes, pitch: the base of its lattice, with the lower corner and the pitch in mm. The lattice may have grown beyond it. rate: of the servo [Hz]. document: its name. materials: JSON (name, color, rings: their contrast, 0 to 1). material: the index of the stock's material. page: the page's id in HTTP requests. what: 0: a document that can be carved; 1: a document that is open read-only; 2: an experiment; 3: a milling job that is played back. The page must discard everything that it showed before. */
export interface Welcome { version: number; origin: Vec3; nodes: Vec3; pitch: number; rate: number; document: string; materials: string; material: number; page: string; what: number }
/** The changed surface of one body. The page answers Got. Each chunk: position x y z (i16), numbers of vertices and triangles (u32), a flag (u16; 1: a vertex is painted or masked), vertices, corners (u16 each). If the flag is 1, a colour per vertex follows: red, green, blue, and 255 - m if painted, else m, with the mask m from 0 to 127 (u8 each). A vertex: x y z (u16 each, in 1/2048 of the pitch), normal (3 x i8, 1/127), material (u8). The coordinates of its vertices are relative to the point that is (16 * position - 1) cells from the lattice's origin. */
export interface Chunks { frame: number; more: number; body: number; data: Uint8Array }
/** Every servo tick since the last Ticks message, fifteen f32 for each tick. If a page has too many unread bytes, it misses messages; `start` shows the gap. A tick has: tip [mm], force of the wood on the tool [N], moment about the tip [N mm]; the third (axis) and first column of the tool's frame. start: the number of the first. */
export interface Ticks { start: number; data: Uint8Array }
/** volume: of the bodies [mm^3]. removed: the volume of the stock minus `volume` [mm^3]. step: the current one. holds: 1 if this page holds the tool. blocked: 1 if the pressed tool is inside material and cannot back out. pending: how far the model is behind the hand in a brush's stroke, as a time of the hand's motion [s]. For a force device: safety (0 off, 1 waits until the computed force is small, 2 on), trip (why it is off), given (its force [N]). */
export interface State { volume: number; removed: number; step: number; steps: number; undo: number; redo: number; holds: number; blocked: number; pending: number; hash: string; safety: number; trip: string; given: number }
/** A sentence for the user. */
export interface Notice { text: string }
/** No document is open. JSON: documents (name, changed: s since 1970, bytes), materials (as in Welcome), examples (name, about). */
export interface Start { version: number; holds: number; json: string }
/** The steps that this page does not have yet, in the order of their numbers. Each has its number and its parent's or 0 (u32 each), and the removed volume [mm^3] (f32). Then the time of its beginning [s since 1970] (f64; 0: unknown), the tool (text, as JSON; null: none), mode (u8; off: the tool only moved), 1 if a thumbnail is stored, else 0 (u8), label (text). */
export interface Steps { data: Uint8Array }
/** JSON: the step number of each name. */
export interface Versions { json: string }
/** A job that may take long is running. what: its name for the user; empty: no job runs. share: its progress, 0 to 1; below 0: unknown. */
export interface Work { what: string; share: number; cancellable: number }
/** The force device that holds the tool. Sent after Welcome, and when its reach or the hand changes: its name, max force [N] (0: none), rendered stiffness and max stiffness [N/mm, at the hand], the reach, and the share of the wood's force at the hand. */
export interface Device { name: string; force: number; stiffness: number; max: number; scale: number; share: number }
/** The result of an experiment. JSON: run (a unique number), name, model, finished, ticks, removed_mm3, mean_force_N (over ticks with a force), max_force_N, max_moment_Nmm, step_us, marks (label, time_s). data: at most 100 000 rows of seven f32: time [s], force [N], moment [N mm]. If there are more ticks, each row is the one with the largest force of several successive ticks. */
export interface Trace { json: string; data: Uint8Array }
/** The current tool: that of an experiment, or that of the page that holds the tool. */
export interface ShowTool { tool: Tool | null }
/** Answers AskMethod from the newest snapshot. The rays are u, u + every, ... (columns of them) by v, v + every, ... (rows of them) of the field, at most 32 in each direction. If there would be more, every is larger than requested. spans: for each ray the number of spans (u8, at most 16), and the ends in and out of each span (f32). u changes fastest from ray to ray. Only spans between the depths low and high [lattice units] are listed. vanished: nodes x y z (i16 each) between these depths that were in the material at this page's last answer and are not now. They are on these rays and on rays between them: on four times as many rays in each direction, or on all rays if there are fewer. The list has at most 2048 nodes, evenly chosen. gone: the number of all. For the newest tick that removed or added points: points (K: their number in the whole model), volume (removed [mm^3]), motion (of the tool's tip [mm]), force (of the wood on the tool [N]). ticks: the number of ticks since the last answer. taken: the sum of their K. */
export interface Method { axis: number; every: number; u: number; v: number; columns: number; rows: number; low: number; high: number; gone: number; points: number; volume: number; motion: Vec3; force: Vec3; ticks: number; taken: number; spans: Uint8Array; vanished: Uint8Array }
/** All bodies. active: the id of the active body. JSON: for each body id, name, pose (of the body's lattice in the world: its origin [mm], then the columns of its frame), visible, locked, no_go, volume_mm3. Chunks of a body that is gone, hidden or moved are invalid. Chunks of a newly shown body follow. */
export interface Bodies { active: number; json: string }
/** The numbers for ShowRemains. max, mean: the maximum and mean distance [mm] of the active body's surface from the protected region. volume: the volume of the body outside that region [mm^3]. scale: the distance of the last colour [mm]; 0: there is no protected region, and no colours are shown. */
export interface Remains { max: number; mean: number; volume: number; scale: number }
/** Answers PreviewAction. error: a sentence; empty: no error. forces: JSON. For a spline, it has a force [N] for each control point: the force of soft clay on a finger that moved this point since the last preview. */
export interface Previewed { error: string; forces: string }
/** The second hand's tool at the newest tick: tip [mm], the third (axis) and first column of its frame, and the force of the wood on it [N]. there: 0 if there is no second hand. */
export interface SecondHand { there: number; tool: Tool | null; tip: Vec3; axis: Vec3; side: Vec3; force: Vec3 }
/** Answers AskMass: the body, its volume [mm^3], its mass [g] (0: the density of one of its materials is unknown), its centre of gravity [mm] in the world, and the memory of all bodies [bytes]. */
export interface Mass { body: number; volume: number; mass: number; centre: Vec3; memory: number }
/** The triangles of the current stamp in its own frame [mm], with the tip at the origin: vertices (three f32 each) and triangles of their indices (three u32 each). */
export interface ShowStamp { vertices: Uint8Array; triangles: Uint8Array }
/** Answers AskFonts. JSON: the families in alphabetical order. */
export interface Fonts { json: string }
/** The numbers for ShowFaults. overhang, thin: areas of overhanging and of thin walls; area: of the whole surface [mm^2]. thinnest: thickness of the thinnest wall [mm], 0 without one. pieces: the number of pieces; all but the largest are loose. */
export interface PrintFaults { overhang: number; thin: number; area: number; thinnest: number; pieces: number }
/** The milling job. JSON: programs (name, lines), collisions (kind, program, line, tool, time: its end [s], volume_mm3), warnings and error (sentences). Sent after Welcome, and when it changes. */
export interface Playback { json: string }
/** The moment of a milling job that is shown. time: of the job [s]. computed: the job is computed up to this time [s]. done: 1 if the whole job is computed. share: progress of computing, 0 to 1. playing, speed, stops: as in PlayProgram. program, line: as in GoToLine; line 0: before the first move. tool: its number; 0: none. rapid: 1 if it is a rapid move. force [N], power [W]: the maximum during the move; 0: unknown. stopped: the index of the collision at which the playback stopped; -1: none. */
export interface Played { time: number; computed: number; done: number; share: number; playing: number; speed: number; stops: number; program: number; line: number; tool: number; rapid: number; force: number; power: number; stopped: number }
/** The first message that a reader of --publish HOST:PORT receives. It is sent again when another document is opened. Readers send nothing. The JSON describes the rows of PublishedTicks: their size (row_bytes) and their columns (name, type, offset in bytes, count). */
export interface PublishedAbout { version: number; json: string }
/** Every servo tick since the last such message: rows of PublishedAbout's row_bytes, one per hand. */
export interface PublishedTicks { rows: Uint8Array }

export const write = {
  Hello: (m: Hello) => new Writer(1).u16(m.version).text(m.key).done(),
  Aim: (m: Aim) => new Writer(2).vec3(m.tip).vec3(m.axis).f64(m.time).f64(m.pressure).done(),
  Press: (m: Press) => new Writer(3).vec3(m.tip).vec3(m.axis).mode(m.mode).f64(m.time).f64(m.pressure).done(),
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
  ChooseBrush: (m: ChooseBrush) => new Writer(30).f64(m.radius).f64(m.strength).u8(m.falloff).u8(m.keep).u8(m.red).u8(m.green).u8(m.blue).u8(m.plane).vec3(m.point).vec3(m.normal).f64(m.wall).u8(m.mask).u8(m.mask_material).u8(m.alpha).u8(m.pressure).done(),
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
  ChangeDetail: (m: ChangeDetail) => new Writer(47).text(m.document).f64(m.pitch).done(),
  PlayProgram: (m: PlayProgram) => new Writer(48).u8(m.playing).f64(m.speed).u8(m.stops).done(),
  SeekProgram: (m: SeekProgram) => new Writer(49).f64(m.time).done(),
  StepProgram: (m: StepProgram) => new Writer(50).u8(m.forward).done(),
  GoToLine: (m: GoToLine) => new Writer(51).u32(m.program).u32(m.line).done(),
  KeepProgram: (m: KeepProgram) => new Writer(52).text(m.name).done(),
  ChooseTexture: (m: ChooseTexture) => new Writer(53).text(m.name).raw(m.data).done(),
};

/** The messages that the studio may send. */
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
  | { kind: "PrintFaults"; message: PrintFaults }
  | { kind: "Playback"; message: Playback }
  | { kind: "Played"; message: Played };

/** Throws if the data is not one of these messages, or has the wrong length. */
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
      return r.end({ kind: "State", message: { volume: r.f64(), removed: r.f64(), step: r.u32(), steps: r.u32(), undo: r.u8(), redo: r.u8(), holds: r.u8(), blocked: r.u8(), pending: r.f64(), hash: r.text(), safety: r.u8(), trip: r.text(), given: r.f64() } });
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
      return r.end({ kind: "Method", message: { axis: r.u8(), every: r.u16(), u: r.f64(), v: r.f64(), columns: r.u16(), rows: r.u16(), low: r.f64(), high: r.f64(), gone: r.u32(), points: r.f64(), volume: r.f64(), motion: r.vec3(), force: r.vec3(), ticks: r.u32(), taken: r.f64(), spans: r.raw(), vanished: r.raw() } });
    case 77:
      return r.end({ kind: "Bodies", message: { active: r.u32(), json: r.text() } });
    case 78:
      return r.end({ kind: "Remains", message: { max: r.f64(), mean: r.f64(), volume: r.f64(), scale: r.f64() } });
    case 79:
      return r.end({ kind: "Previewed", message: { error: r.text(), forces: r.text() } });
    case 80:
      return r.end({ kind: "SecondHand", message: { there: r.u8(), tool: r.tool(), tip: r.vec3(), axis: r.vec3(), side: r.vec3(), force: r.vec3() } });
    case 81:
      return r.end({ kind: "Mass", message: { body: r.u32(), volume: r.f64(), mass: r.f64(), centre: r.vec3(), memory: r.f64() } });
    case 82:
      return r.end({ kind: "ShowStamp", message: { vertices: r.raw(), triangles: r.raw() } });
    case 83:
      return r.end({ kind: "Fonts", message: { json: r.text() } });
    case 84:
      return r.end({ kind: "PrintFaults", message: { overhang: r.f64(), thin: r.f64(), area: r.f64(), thinnest: r.f64(), pieces: r.u32() } });
    case 85:
      return r.end({ kind: "Playback", message: { json: r.text() } });
    case 86:
      return r.end({ kind: "Played", message: { time: r.f64(), computed: r.f64(), done: r.u8(), share: r.f64(), playing: r.u8(), speed: r.f64(), stops: r.u8(), program: r.u32(), line: r.u32(), tool: r.u32(), rapid: r.u8(), force: r.f64(), power: r.f64(), stopped: r.f64() } });
    default:
      throw new Error(`unknown kind ${kind} of message`);
  }
}
