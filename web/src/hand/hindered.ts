// SPDX-License-Identifier: MIT
// Tells the person why the tool cuts nothing: it has no room, or the wood holds it back.
import { notify } from "../base/notice";
import type { Vec3 } from "../base/vec3";
import type { State } from "../connection/messages";
import type { Hand } from "./hand";

/** A stroke that removes nothing for so long, though it is pressed, is explained. */
const STILL_MS = 1500;

export class Hindered {
  private blocked = false; // as the studio said last
  private removed = 0;
  private since = 0; // when `removed` changed, or the tool was where it is wanted [ms]

  constructor(private hand: Hand) {}

  /** tip: as of the last tick. */
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
