// SPDX-License-Identifier: MIT
// What both hands make of a pointer's events.
import type * as THREE from "three";

/**
 * The events that the browser has put together, those after `stroke.time` [ms], which follows them:
 * the same events come raw and with the next frame.
 */
export function* newEvents(event: PointerEvent, stroke: { time: number }): Generator<PointerEvent> {
  const all = event.getCoalescedEvents?.() ?? [];
  for (const one of all.length > 0 ? all : [event]) {
    if (one.timeStamp <= stroke.time) continue;
    stroke.time = one.timeStamp;
    yield one;
  }
}

/**
 * Turns a tool's axis towards another one. A hand does not turn at once where the surface does: it
 * takes half the tool's radius of the way, however fast the hand goes [mm].
 */
export const turnTowards = (
  axis: THREE.Vector3,
  to: THREE.Vector3,
  way: number,
  radius: number,
): THREE.Vector3 => axis.lerp(to, 1 - Math.exp((-2 * way) / radius)).normalize();
