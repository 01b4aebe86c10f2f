// SPDX-License-Identifier: MIT
// Scales of force plots that a few spikes do not flatten, and the spikes that such a scale leaves
// out.

export interface Range {
  low: number;
  high: number;
}
export interface Spike {
  x: number;
  value: number;
}

const SHARE = 0.99; // of the ticks with any force: they fit in
const ROOM = 1.15; // above them
const WORTH = 1.5; // a largest value that is no higher above the scale than so is shown whole

/** How far a scale goes that shows these sizes, none of them below 0. */
function reach(sizes: number[]): number {
  if (sizes.length === 0) return 0;
  const sorted = Float64Array.from(sizes).sort(),
    largest = sorted[sorted.length - 1];
  const usual = ROOM * sorted[Math.floor(SHARE * (sorted.length - 1))];
  return largest <= WORTH * usual ? 1.05 * largest : usual;
}

/**
 * What the series need together: from 0, and to `min` at least; to 1 where there is nothing to
 * show.
 */
export function robustRange(series: ArrayLike<number | null | undefined>[], min: number): Range {
  const above: number[] = [],
    below: number[] = [];
  for (const values of series)
    for (let i = 0; i < values.length; i++) {
      const value = values[i] ?? 0;
      if (value > 0) above.push(value);
      else if (value < 0) below.push(-value);
    }
  return { low: -reach(below), high: Math.max(min, reach(above)) || (below.length > 0 ? 0 : 1) };
}

/** What leaves the range: of values less than `apart` from each other the outermost. */
export function spikes(
  x: ArrayLike<number>,
  y: ArrayLike<number | null | undefined>,
  range: Range,
  apart: number,
): Spike[] {
  const found: Spike[] = [];
  for (let i = 0; i < x.length; i++) {
    const value = y[i] ?? 0;
    if (value <= range.high && value >= range.low) continue;
    const last = found.at(-1);
    if (!last || x[i] - last.x > apart || last.value > 0 !== value > 0)
      found.push({ x: x[i], value });
    else if (Math.abs(value) > Math.abs(last.value)) Object.assign(last, { x: x[i], value });
  }
  return found;
}
