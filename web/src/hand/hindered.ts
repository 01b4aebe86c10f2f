// SPDX-License-Identifier: MIT
// Explains to the user why the tool cuts nothing: it has no room, or the wood holds it back.
import { t } from "../base/texts";
import { notify } from "../base/notice";
import type { Vec3 } from "../base/vec3";
import type { State } from "../connection/messages";
import type { Hand } from "./hand";

/** If a pressed stroke removes nothing for this time [ms], the page explains why. */
const STILL_MS = 1500;

export class Hindered {
  private blocked = false; // as the studio reported last
  private removed = 0;
  private since = 0; // time [ms] when `removed` last changed or the tool was at its target

  constructor(private hand: Hand) {}

  /** Checks one state. `tip` is the tip at the last tick [mm]. */
  follow(s: State, tip: Vec3): void {
    const blocked = s.blocked !== 0;
    if (blocked && !this.blocked) notify(t("tool_blocked"));
    this.blocked = blocked;
    // While a brush's dabs are pending, the wood is not the reason for the delay.
    if (s.removed !== this.removed || s.pending > 0 || !this.hand.heldBack(tip)) {
      this.removed = s.removed;
      this.since = performance.now();
    } else if (performance.now() - this.since > STILL_MS) {
      notify(this.hand.help);
      this.since = Infinity;
    }
  }
}
