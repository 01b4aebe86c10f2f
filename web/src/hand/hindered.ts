// SPDX-License-Identifier: MIT
// Explains to the user why the tool cuts nothing: it has no room, or the wood holds it back.
import { notify } from "../base/notice";
import type { Vec3 } from "../base/vec3";
import type { State } from "../connection/messages";
import type { Hand } from "./hand";

/** A pressed stroke that removes nothing for this time is explained. */
const STILL_MS = 1500;

export class Hindered {
  private blocked = false; // from the last report of the studio
  private removed = 0;
  private since = 0; // last time that `removed` changed or the tool was at its target [ms]

  constructor(private hand: Hand) {}

  /** `tip`: position in the last tick. */
  follow(s: State, tip: Vec3): void {
    const blocked = s.blocked !== 0;
    if (blocked && !this.blocked)
      notify(
        "The tool stands in wood there and can't back out along its axis, so it cuts nothing. Lift it, and begin where it has room, point it another way, or take a smaller one.",
      );
    this.blocked = blocked;
    if (s.removed !== this.removed || !this.hand.heldBack(tip)) {
      this.removed = s.removed;
      this.since = performance.now();
    } else if (performance.now() - this.since > STILL_MS) {
      notify(this.hand.help);
      this.since = Infinity;
    }
  }
}
