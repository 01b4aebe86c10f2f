// SPDX-License-Identifier: MIT
// Functions of both hands that turn a pointer's events into a path.
import type * as THREE from "three";

/**
 * The coalesced events after `stroke.time` [ms]. Updates `stroke.time`, because the same events
 * arrive twice: raw and with the next frame.
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
 * Turns a tool's axis towards another axis. A hand does not turn as suddenly as the surface. The
 * turn takes half the tool's radius of path [mm], at any speed.
 */
export const turnTowards = (
  axis: THREE.Vector3,
  to: THREE.Vector3,
  way: number,
  radius: number,
): THREE.Vector3 => axis.lerp(to, 1 - Math.exp((-2 * way) / radius)).normalize();
