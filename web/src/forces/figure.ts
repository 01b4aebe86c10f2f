// SPDX-License-Identifier: MIT
// Forces over time as a figure for print (SVG).
import { robustRange, spikes } from "./robust";

export interface Curve {
  name: string;
  colour: string;
  dashed: boolean;
  x: ArrayLike<number>; // [s], ascending
  y: ArrayLike<number>;
}

const WIDTH = 720,
  HEIGHT = 400,
  LEFT = 64,
  RIGHT = 16,
  TOP = 22,
  BELOW = 52; // `BELOW`: numbers and title of the time axis
const LINE = 18; // height of a line of the legend
const LETTERS = 104; // characters per line of the notes

const escaped = (text: string): string => text.replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

/** Steps of 1, 2 or 5 times a power of ten. */
function ticks(from: number, to: number): number[] {
  const raw = (to - from) / 6,
    power = 10 ** Math.floor(Math.log10(raw)),
    step = power * ([1, 2, 5, 10].find((m) => m * power >= raw) ?? 10);
  const all: number[] = [];
  for (let v = Math.ceil(from / step) * step; v <= to + 1e-9 * step; v += step)
    all.push(Number(v.toPrecision(6)));
  return all;
}

function lines(text: string): string[] {
  const found = [""];
  for (const word of text.split(" ")) {
    if (found.at(-1)!.length + word.length > LETTERS) found.push("");
    found[found.length - 1] += (found.at(-1) === "" ? "" : " ") + word;
  }
  return found;
}

/**
 * Points of a polyline at visible resolution: the lowest and the highest value in each half unit of
 * width.
 */
function pointsOf(curve: Curve, x: (t: number) => number, y: (v: number) => number): string[] {
  const points: string[] = [];
  let column = -1,
    min = 0,
    max = 0,
    at = 0;
  const put = (): void => {
    if (column >= 0)
      points.push(
        `${at.toFixed(1)},${y(min).toFixed(1)}`,
        ...(max > min ? [`${at.toFixed(1)},${y(max).toFixed(1)}`] : []),
      );
  };
  for (let k = 0; k < curve.x.length; k++) {
    const px = x(curve.x[k]),
      v = curve.y[k];
    if (Math.floor(2 * px) !== column) {
      put();
      column = Math.floor(2 * px);
      at = px;
      min = max = v;
    }
    min = Math.min(min, v);
    max = Math.max(max, v);
  }
  put();
  return points;
}

/** `label` of the vertical axis with its unit; `notes` are sentences below. */
export function figure(curves: Curve[], label: string, notes: string[]): string {
  const notesLines = notes.flatMap(lines);
  const total =
    HEIGHT + LINE * (curves.length + notesLines.length) + (notesLines.length > 0 ? 8 : 0);
  const end = Math.max(0, ...curves.map((curve) => curve.x[curve.x.length - 1] ?? 0)) || 1;
  const range = robustRange(
      curves.map((curve) => curve.y),
      0,
    ),
    { low, high } = range;
  const x = (t: number): number => LEFT + ((WIDTH - LEFT - RIGHT) * t) / end;
  const y = (v: number): number => TOP + ((HEIGHT - TOP - BELOW) * (high - v)) / (high - low);
  const out = [
    `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${WIDTH} ${total}" width="${WIDTH}" height="${total}" font-family="sans-serif" font-size="12"><rect width="${WIDTH}" height="${total}" fill="#fff"/>`,
  ];
  out.push(
    `<clipPath id="inside"><rect x="${LEFT}" y="${TOP}" width="${WIDTH - LEFT - RIGHT}" height="${HEIGHT - TOP - BELOW}"/></clipPath>`,
  );
  for (const v of ticks(low, high))
    out.push(
      `<line x1="${LEFT}" x2="${WIDTH - RIGHT}" y1="${y(v)}" y2="${y(v)}" stroke="#ddd"/><text x="${LEFT - 6}" y="${y(v) + 4}" text-anchor="end">${v}</text>`,
    );
  for (const t of ticks(0, end))
    out.push(
      `<line x1="${x(t)}" x2="${x(t)}" y1="${TOP}" y2="${y(low)}" stroke="#eee"/><text x="${x(t)}" y="${y(low) + 16}" text-anchor="middle">${t}</text>`,
    );
  out.push(
    `<text x="${(LEFT + WIDTH) / 2}" y="${y(low) + 34}" text-anchor="middle">Time [s]</text><text transform="translate(16 ${(TOP + y(low)) / 2}) rotate(-90)" text-anchor="middle">${escaped(label)}</text>`,
  );
  const unit = /\[(.*)\]/.exec(label)?.[1] ?? "";
  const told: number[] = []; // positions of the labels of spikes
  curves.forEach((curve, place) => {
    const points = pointsOf(curve, x, y);
    const look = `fill="none" stroke="${curve.colour}" stroke-width="1.5"${curve.dashed ? ' stroke-dasharray="6 4"' : ""}`;
    out.push(`<polyline points="${points.join(" ")}" clip-path="url(#inside)" ${look}/>`);
    for (const spike of spikes(curve.x, curve.y, range, (8 * end) / (WIDTH - LEFT - RIGHT))) {
      const px = x(spike.x),
        [tip, base] = spike.value > 0 ? [TOP - 7, TOP] : [y(low) + 7, y(low)],
        size = `${Number(spike.value.toPrecision(3))} ${unit}`.trim();
      out.push(
        `<path class="spike" d="M${px.toFixed(1)} ${tip}l4 ${base - tip}h-8z" fill="${curve.colour}"><title>${size}</title></path>`,
      );
      if (spike.value < 0 || told.some((other) => Math.abs(other - px) < 56)) continue;
      told.push(px);
      out.push(
        `<text x="${(px > WIDTH - 70 ? px - 6 : px + 6).toFixed(1)}" y="${TOP - 6}" font-size="10"${px > WIDTH - 70 ? ' text-anchor="end"' : ""}>${size}</text>`,
      );
    }
    const line = HEIGHT + 4 + LINE * place;
    out.push(
      `<line x1="${LEFT}" x2="${LEFT + 28}" y1="${line}" y2="${line}" ${look}/><text x="${LEFT + 36}" y="${line + 4}">${escaped(curve.name)}</text>`,
    );
  });
  notesLines.forEach((note, i) =>
    out.push(
      `<text x="${LEFT}" y="${HEIGHT + 16 + LINE * (curves.length + i)}" font-size="11" fill="#555">${escaped(note)}</text>`,
    ),
  );
  return out.join("\n") + "\n</svg>\n";
}
