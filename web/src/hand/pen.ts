// SPDX-License-Identifier: MIT
// The pressure of a pen on brushes.
import { select } from "../base/dom";
import { PRESSURE_USES, type PressureUse } from "../connection/kinds";

/** Size of a brush without pressure, as a share of its full size. The studio has the same. */
const MIN_SIZE = 0.1;

const use = (): PressureUse => select("pen-brush").value as PressureUse;

/** The user's choice as the studio's number. */
export const pressureUse = (): number => PRESSURE_USES.indexOf(use());

/** The pressure of an event: 1 for a mouse or a finger. */
export const pressureOf = (event: PointerEvent): number =>
  event.pointerType === "pen" ? Math.min(1, Math.max(0, event.pressure)) : 1;

/** The share of its size that a brush has at this pressure. */
export const sizeShare = (pressure: number): number =>
  ["size", "both"].includes(use()) ? Math.max(MIN_SIZE, pressure) : 1;
