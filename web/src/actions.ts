// SPDX-License-Identifier: MIT
// The actions that keys trigger. Each action has a name for the list of keys and its default keys.
import { t } from "./base/texts";
import * as THREE from "three";
import { dialog, element } from "./base/dom";
import { write } from "./connection/messages";
import type { Hand } from "./hand/hand";
import type { BodiesPanel } from "./panels/bodies";
import { askExport } from "./panels/export";
import type { Hiding } from "./panels/hiding";
import type { Action } from "./panels/keys";
import type { Look } from "./panels/look";
import type { Measure } from "./panels/measure";
import type { Palette } from "./panels/palette";
import { closePopover } from "./panels/popovers";
import type { PrintCheck } from "./panels/print_check";
import type { Splines } from "./panels/splines";
import { BRUSHES, BRUSH_MODES } from "./tools/brushes";
import { SHAPES, TOOLS } from "./tools/tools";
import type { View } from "./view/view";

/** The parts of the page that the actions use. */
export interface Parts {
  send: (message: Uint8Array) => void;
  view: View;
  hand: Hand;
  bodies: BodiesPanel;
  splines: Splines;
  measure: Measure;
  hiding: Hiding;
  printing: PrintCheck;
  look: Look;
  palette: Palette;
}

const brushActions = ({ hand }: Parts): Record<string, Action> =>
  Object.fromEntries(
    BRUSH_MODES.map((mode) => [
      mode,
      {
        label: t("key_brush", { brush: BRUSHES[mode]!.name }),
        keys: [BRUSHES[mode]!.key],
        run: () => hand.pick(mode),
      },
    ]),
  );

const shapeActions = ({ hand, palette }: Parts): Record<string, Action> => ({
  find: { label: t("key_find"), keys: ["/"], run: () => palette.focus() },
  ...Object.fromEntries(
    SHAPES.map((shape) => [
      `tool ${shape}`,
      {
        label: t("key_tool", { tool: TOOLS[shape].name }),
        keys: [TOOLS[shape].key],
        run: () => hand.take(shape),
      },
    ]),
  ),
});

const toolActions = ({ hand }: Parts): Record<string, Action> => ({
  smaller: { label: t("key_smaller"), keys: ["["], run: () => hand.nudge("size", 1 / 1.15) },
  larger: { label: t("key_larger"), keys: ["]"], run: () => hand.nudge("size", 1.15) },
  size: {
    label: t("key_size"),
    keys: ["f"],
    run: () => hand.startSliding("size"),
  },
  depth: {
    label: t("key_depth"),
    keys: ["Shift+f"],
    run: () => hand.startSliding("depth"),
  },
  shallower: { label: t("key_shallower"), keys: ["{"], run: () => hand.nudge("depth", 1 / 1.15) },
  weaker: {
    label: t("key_weaker"),
    keys: ["("],
    run: () => hand.nudge(hand.strength, 1 / 1.15),
  },
  stronger: { label: t("key_stronger"), keys: [")"], run: () => hand.nudge(hand.strength, 1.15) },
  strength: {
    label: t("key_strength"),
    keys: ["u"],
    run: () => hand.startSliding(hand.strength),
  },
  deeper: { label: t("key_deeper"), keys: ["}"], run: () => hand.nudge("depth", 1.15) },
  turn: { label: t("key_turn"), keys: ["Shift+t"], run: () => hand.turn() },
  strike: { label: t("key_strike"), keys: ["Space"], run: () => hand.strike() },
  plane: {
    label: t("key_plane"),
    keys: ["p"],
    run: () => hand.setPlane(),
  },
  centre: {
    label: t("key_centre"),
    keys: ["e"],
    run: () => hand.setCentre(),
  },
  mirror: {
    label: t("key_mirror"),
    keys: ["x"],
    run: () => hand.toggleSymmetry(),
  },
});

const pieceActions = ({
  send,
  hand,
  bodies,
  splines,
  measure,
  hiding,
}: Parts): Record<string, Action> => ({
  cut: {
    label: t("key_cut"),
    keys: ["k"],
    run: () => bodies.take("cut"),
  },
  spline: {
    label: t("key_spline"),
    keys: ["Shift+k"],
    run: () => element("spline-draw").click(),
  },
  body: { label: t("key_body"), keys: ["Shift+b"], run: () => bodies.next() },
  undo: { label: t("key_undo"), keys: ["Ctrl+z"], run: () => send(write.Undo()) },
  redo: { label: t("key_redo"), keys: ["Ctrl+Shift+z", "Ctrl+y"], run: () => send(write.Redo()) },
  cancel: {
    label: t("key_cancel"),
    keys: ["Escape"],
    run: () => {
      if (closePopover()) return;
      if ([splines, bodies, measure, hiding].some((part) => part.leaveOff())) return;
      send(write.Cancel());
      hand.lift();
    },
  },
});

const viewActions = ({ view, look, hiding }: Parts): Record<string, Action> => ({
  front: {
    label: t("key_front"),
    keys: ["1"],
    run: () => view.frame(new THREE.Vector3(0, -1, 0.001)),
  },
  right: {
    label: t("key_right"),
    keys: ["3"],
    run: () => view.frame(new THREE.Vector3(1, 0, 0.001)),
  },
  above: {
    label: t("key_above"),
    keys: ["7"],
    run: () => view.frame(new THREE.Vector3(0, -0.001, 1)),
  },
  saveView: { label: t("key_view_save"), keys: ["8"], run: () => look.savedViews.save() },
  nextView: { label: t("key_view_next"), keys: ["9"], run: () => look.savedViews.next() },
  hideBox: { label: t("key_hide_box"), keys: ["2"], run: () => hiding.take("box") },
  hideLasso: { label: t("key_hide_lasso"), keys: ["6"], run: () => hiding.take("lasso") },
  hideNone: { label: t("key_hide_none"), keys: ["0"], run: () => hiding.showAll() },
  orthographic: {
    label: t("key_orthographic"),
    keys: ["5"],
    run: () => look.toggleOrthographic(),
  },
});

const otherActions = ({ send, view, look, measure, printing }: Parts): Record<string, Action> => ({
  method: {
    label: t("key_method"),
    keys: ["m"],
    run: () => look.toggleMethod(),
  },
  measure: {
    label: t("key_measure"),
    keys: ["Shift+m"],
    run: () => measure.toggle(),
  },
  printing: {
    label: t("key_printing"),
    keys: ["Shift+p"],
    run: () => printing.toggle(),
  },
  all: { label: t("key_all"), keys: ["Home"], run: () => view.frame() },
  export: { label: t("key_export"), keys: ["Ctrl+e"], run: askExport },
  close: {
    label: t("key_close"),
    keys: ["Ctrl+o"],
    run: () => send(write.Leave()),
  },
  help: { label: t("key_help"), keys: ["?"], run: () => dialog("keys").showModal() },
});

/** All actions, in the order of the list of keys. */
export const actions = (parts: Parts): Record<string, Action> => ({
  ...shapeActions(parts),
  ...toolActions(parts),
  ...brushActions(parts),
  ...pieceActions(parts),
  ...viewActions(parts),
  ...otherActions(parts),
});
