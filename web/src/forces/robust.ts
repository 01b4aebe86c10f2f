// SPDX-License-Identifier: MIT
// Scales of force plots that a few spikes do not flatten, and the spikes beyond such a scale.

export interface Range {
  low: number;
  high: number;
}
export interface Spike {
  x: number;
  value: number;
}

const SHARE = 0.99; // share of the ticks with a force that fit into the scale
const ROOM = 1.15; // margin above them
const WORTH = 1.5; // a largest value up to this factor above the scale is included in it

/** Upper end of a scale for these values, none of which is below 0. */
function reach(sizes: number[]): number {
  if (sizes.length === 0) return 0;
  const sorted = Float64Array.from(sizes).sort(),
    largest = sorted[sorted.length - 1];
  const usual = ROOM * sorted[Math.floor(SHARE * (sorted.length - 1))];
  return largest <= WORTH * usual ? 1.05 * largest : usual;
}

/**
 * Range of all series together: it includes 0 and reaches at least `min`, or 1 if there are no
 * values.
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

/** The values outside the range. Of values that are closer than `apart`, only the outermost. */
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
