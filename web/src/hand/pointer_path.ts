// SPDX-License-Identifier: MIT
// Functions that both hands use to read pointer events.
import type * as THREE from "three";

/**
 * Yields the coalesced events after `stroke.time` [ms] and advances that time. The browser delivers
 * the same events twice: raw, and with the next frame.
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
 * Turns a tool's axis towards another one. The turn is spread over half the tool's radius of path
 * length [mm]. So the axis does not jump where the surface does.
 */
export const turnTowards = (
  axis: THREE.Vector3,
  to: THREE.Vector3,
  distance: number,
  radius: number,
): THREE.Vector3 => axis.lerp(to, 1 - Math.exp((-2 * distance) / radius)).normalize();
