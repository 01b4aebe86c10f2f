// SPDX-License-Identifier: MIT
// Computes scales for force plots, so that a few spikes do not make the rest flat. Finds the spikes
// that are outside such a scale.

export interface Range {
  low: number;
  high: number;
}
export interface Spike {
  x: number;
  value: number;
}

const SHARE = 0.99; // this share of the ticks with a force fits below the scale's end
const ROOM = 1.15; // margin factor above that share
const WORTH = 1.5; // a maximum up to this factor above the scale is included

/** The end of a scale for these sizes. All sizes are at least 0. */
function reach(sizes: number[]): number {
  if (sizes.length === 0) return 0;
  const sorted = Float64Array.from(sizes).sort(),
    largest = sorted[sorted.length - 1];
  const usual = ROOM * sorted[Math.floor(SHARE * (sorted.length - 1))];
  return largest <= WORTH * usual ? 1.05 * largest : usual;
}

/**
 * The common range of several series. It contains 0 and `min`. It ends at 1 if all values are 0.
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

/** Finds values outside the range. Of neighbours closer than `apart` it keeps the largest. */
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
