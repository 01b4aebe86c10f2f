// SPDX-License-Identifier: MIT
// The numbers of the tool and of the piece.
import { element, read } from "../base/dom";
import type { Vec3 } from "../base/vec3";
import type { State } from "../connection/messages";

const newtons = (n: number): string => `${n < 10 ? n.toFixed(1) : n.toFixed(0)} N`;

/**
 * Shows the last tick: force [N], moment [N mm], tip [mm]. `share`: share of the force that the
 * device gives to the hand.
 */
export function showTick(force: number, moment: number, tip: Vec3, share: number): void {
  read("n-force", newtons(force));
  for (const id of ["hand-force", "n-hand"]) element(id).hidden = !(share > 0);
  if (share > 0) read("n-hand", newtons(share * force));
  read("n-moment", `${moment.toFixed(1)} N mm`);
  read("n-tip", tip.map((x) => x.toFixed(1)).join(" "));
}

export function showPiece(s: State): void {
  read("n-volume", `${(s.volume / 1000).toFixed(2)} cm³`);
  // Not "-0.000".
  read("n-removed", `${(Math.round(s.removed) / 1000 + 0).toFixed(3)} cm³`);
  read("n-step", `${s.step} of ${s.steps}`);
}
