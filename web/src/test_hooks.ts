// SPDX-License-Identifier: MIT
// The hooks for tests and measurements: window.kibori.
import type { Vec3 } from "./base/vec3";
import type { Connection } from "./connection/connection";
import type { ForcePlot } from "./forces/plot";
import type { Hand } from "./hand/hand";
import { everyTool } from "./tools/tools";
import type { View } from "./view/view";

let frameTakes = 0;
/** Delays every frame to at least `ms` milliseconds, as on a slow computer. 0: no delay. */
function slowFrames(ms: number): void {
  const runs = frameTakes > 0;
  frameTakes = ms;
  const wait = (): void => {
    for (const until = performance.now() + frameTakes; performance.now() < until; );
    if (frameTakes > 0) requestAnimationFrame(wait);
  };
  if (!runs && ms > 0) requestAnimationFrame(wait);
}

export function offerHooks(view: View, plot: ForcePlot, hand: Hand, line: Connection): void {
  Object.assign(window, {
    kibori: {
      // True if the page shows all chunks that the studio has sent, at full quality.
      whole: () => view.solid.whole,
      settled: () => view.painter.settled,
      // Resolves when the studio has handled everything that the page has sent (see Connection).
      answered: () => line.answered(),
      // Resolves with the next report of the studio's state, 20 per second.
      nextState: () => line.next("State"),
      surface: () => view.solid.surface(),
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
      tools: everyTool,
      slowFrames,
      // While this is set, the page draws neither the piece nor the plot, and no pictures of steps.
      still: (still: boolean) => {
        view.painter.still = plot.still = still;
        view.painter.redrawSolid();
      },
      // Draws the piece once at low quality, also while the page is still.
      draw: () => view.painter.render(false),
    },
  });
}
