// SPDX-License-Identifier: MIT
// The actions that keys run. Each has a name for the list of keys, and default keys.
import * as THREE from "three";
import { dialog, element } from "./base/dom";
import { write } from "./connection/messages";
import type { Hand } from "./hand/hand";
import type { Bodies } from "./panels/bodies";
import { askExport } from "./panels/export";
import type { Action } from "./panels/keys";
import type { Look } from "./panels/look";
import type { Measure } from "./panels/measure";
import type { PrintCheck } from "./panels/print_check";
import type { Splines } from "./panels/splines";
import { BRUSHES, BRUSH_MODES } from "./tools/brushes";
import type { View } from "./view/view";

/** The parts of the page that the actions use. */
export interface Parts {
  send: (message: Uint8Array) => void;
  view: View;
  hand: Hand;
  bodies: Bodies;
  splines: Splines;
  measure: Measure;
  printing: PrintCheck;
  look: Look;
}

const brushActions = ({ hand }: Parts): Record<string, Action> =>
  Object.fromEntries(
    BRUSH_MODES.map((mode) => [
      mode,
      {
        label: `${BRUSHES[mode]!.name.toLowerCase()}, or carve again`,
        keys: [BRUSHES[mode]!.key],
        run: () => hand.pick(mode),
      },
    ]),
  );

const toolActions = ({ hand }: Parts): Record<string, Action> => ({
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
});

const pieceActions = ({ send, hand, bodies, splines, measure }: Parts): Record<string, Action> => ({
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
  undo: { label: "undo", keys: ["Ctrl+z"], run: () => send(write.Undo()) },
  redo: { label: "redo", keys: ["Ctrl+Shift+z", "Ctrl+y"], run: () => send(write.Redo()) },
  cancel: {
    label: "leave the stroke off",
    keys: ["Escape"],
    run: () => {
      if (splines.leaveOff() || bodies.leaveOff() || measure.leaveOff()) return;
      send(write.Cancel());
      hand.lift();
    },
  },
});

const viewActions = ({ view, look }: Parts): Record<string, Action> => ({
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
});

const otherActions = ({ send, view, look, measure, printing }: Parts): Record<string, Action> => ({
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
  close: {
    label: "close the document, and begin another",
    keys: ["Ctrl+o"],
    run: () => send(write.Leave()),
  },
  help: { label: "these keys", keys: ["?"], run: () => dialog("keys").showModal() },
});

/** All actions, in the order of the list. */
export const actions = (parts: Parts): Record<string, Action> => ({
  ...toolActions(parts),
  ...brushActions(parts),
  ...pieceActions(parts),
  ...viewActions(parts),
  ...otherActions(parts),
});
