// SPDX-License-Identifier: MIT
// The brushes that a user can hold instead of a tool: one row for each mode that reshapes with a
// brush.
import type { Mode } from "../connection/kinds";

interface Row {
  name: string;
  /** Its effect on the surface. */
  about: string;
  /** Content of an SVG of 24 by 24. */
  icon: string;
  /** Default strength, 0 to 1. */
  strength: number;
  /**
   * `drags`: the surface under the press follows the pointer in the plane across the view. `turns`:
   * moving the pointer to the right turns it. Other brushes work along the pointer's path.
   */
  goes?: "drags" | "turns";
  /** True if it can keep the volume. */
  keeps?: boolean;
  /** The key that picks it up. */
  key: string;
}

export const BRUSHES: Partial<Record<Mode, Row>> = {
  smooth: {
    name: "Smooth",
    about: "Takes peaks and fills hollows",
    icon: '<path d="M2 15c4-9 6-9 10-4s6 4 10-2M3 20h18" />',
    strength: 0.5,
    keeps: true,
    key: "s",
  },
  rasp: {
    name: "Rasp",
    about: "Takes peaks, leaves hollows",
    icon: '<path d="M2 17h20M4 13l3-5 3 5M10 13l3-5 3 5M16 13l3-5 2 5" />',
    strength: 0.5,
    key: "r",
  },
  fill: {
    name: "Fill",
    about: "Fills hollows, leaves peaks",
    icon: '<path d="M2 8h5c0 12 10 12 10 0h5M8 9h8M9 13h6" />',
    strength: 0.5,
    key: "v",
  },
  inflate: {
    name: "Inflate",
    about: "Raises the surface; with a strength below 0 sinks it",
    icon: '<path d="M2 19h5c0-9 10-9 10 0h5M12 9V3M9 6l3-3 3 3" />',
    strength: 0.5,
    key: "i",
  },
  flatten: {
    name: "Flatten",
    about: "Planes down to the plane where the stroke begins, or to the one that is set (P)",
    icon: '<path d="M2 12h20M5 12l2-5M12 12V5M19 12l-2-5M4 19h16" />',
    strength: 0.5,
    key: "w",
  },
  crease: {
    name: "Crease",
    about: "Draws a sharp valley",
    icon: '<path d="M2 8c6 0 8 2 10 10 2-8 4-10 10-10" />',
    strength: 0.5,
    key: "c",
  },
  grab: {
    name: "Grab",
    about: "Pulls the surface along, as far as you like",
    icon: '<path d="M2 19h4c4 0 4-13 6-13s2 13 6 13h4M12 2v4" />',
    strength: 1,
    goes: "drags",
    keeps: true,
    key: "g",
  },
  nudge: {
    name: "Nudge",
    about: "Pushes the surface along itself",
    icon: '<path d="M2 16c5 0 5-6 9-6s3 6 11 6M13 5h8M18 2l3 3-3 3" />',
    strength: 1,
    goes: "drags",
    key: "n",
  },
  twist: {
    name: "Twist",
    about: "Turns the surface about its normal: drag to the right or left",
    icon: '<path d="M20 12a8 8 0 1 1-3-6M17 2v4h-4M12 9v6" />',
    strength: 1,
    goes: "turns",
    key: "o",
  },
  bend: {
    name: "Bend",
    about: "Leans over what stands there",
    icon: '<path d="M8 21c0-9 2-14 11-16M13 3l6 2-3 5" />',
    strength: 1,
    goes: "drags",
    key: "d",
  },
  pinch: {
    name: "Pinch",
    about: "Draws the surface together",
    icon: '<path d="M2 12h7M6 9l3 3-3 3M22 12h-7M18 9l-3 3 3 3M12 4v16" />',
    strength: 1,
    goes: "drags",
    key: "j",
  },
  scale: {
    name: "Scale",
    about: "Larger as you drag away from the wood, smaller into it",
    icon: '<path d="M4 14v6h6M4 20l7-7M20 10V4h-6M20 4l-7 7" />',
    strength: 1,
    goes: "drags",
    key: "q",
  },
  node: {
    name: "Node",
    about: "Moves one point of the surface: a pyramid",
    icon: '<path d="M2 19h4l6-13 6 13h4M12 6v13" /><circle cx="12" cy="4" r="2" />',
    strength: 1,
    goes: "drags",
    key: "y",
  },
  paint: {
    name: "Paint",
    about: "Colours the surface",
    icon: '<path d="M14 3l7 7-7 5-5-5zM9 10c-5 1-3 7-7 9 6 2 11 0 12-4" />',
    strength: 1,
    key: "a",
  },
};
export const BRUSH_MODES = Object.keys(BRUSHES) as Mode[];

/** Colours to paint with: earth colours and workshop pigments. */
export const PALETTE = [
  ["#b23a30", "Vermilion"],
  ["#c47a1e", "Ochre"],
  ["#e3c34a", "Yellow"],
  ["#4f7a3a", "Green"],
  ["#2f6f9f", "Blue"],
  ["#6b4a8a", "Violet"],
  ["#4a2f20", "Umber"],
  ["#efe9dc", "White"],
  ["#22201f", "Black"],
] as const;

/** A button for each brush. */
export const brushButtons = (): string =>
  BRUSH_MODES.map((mode) => {
    const { name, about, icon, key } = BRUSHES[mode]!;
    return `<label title="${name}: ${about} (${key.toUpperCase()})"><input type="radio" name="mode" value="${mode}" aria-label="${name}" /><svg viewBox="0 0 24 24" aria-hidden="true">${icon}</svg></label>`;
  }).join("");
export function fillPalette(palette: HTMLElement): void {
  palette.replaceChildren(
    ...PALETTE.map(([color, name]) => {
      const button = document.createElement("button");
      button.type = "button";
      button.title = button.ariaLabel = name;
      button.dataset.color = color;
      button.style.background = color;
      return button;
    }),
  );
}
