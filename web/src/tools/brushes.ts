// SPDX-License-Identifier: MIT
// The brushes that replace the tool: one row for each mode that reshapes by a brush.
import { t } from "../base/texts";
import { ALPHAS, type Mode } from "../connection/kinds";

interface Row {
  name: string;
  /** A text for the user: what the brush does, and its force on the hand. */
  about: string;
  /** The content of an SVG of 24 by 24. */
  icon: string;
  /** The default strength, 0 to 1. */
  strength: number;
  /**
   * How the surface follows the pointer during a press.
   * `drags`: the pressed point moves with the pointer, in a plane perpendicular to the view.
   * `turns`: the surface turns as the pointer moves to the right.
   * `scales`: the surface grows as the pointer moves out of the wood. If the surface faces the eye,
   * it grows as the pointer moves to the right and up.
   * Not set: the brush acts along the pointer's path.
   */
  follows?: "drags" | "turns" | "scales";
  /** True if the brush can keep the volume. */
  keeps?: boolean;
  /** True if a negative strength does the opposite. Ctrl inverts the strength then. */
  signed?: boolean;
  /** The default key. */
  key: string;
}

export const BRUSHES: Partial<Record<Mode, Row>> = {
  smooth: {
    name: t("brush_smooth"),
    about: t("brush_smooth_about"),
    icon: '<path d="M2 15c4-9 6-9 10-4s6 4 10-2M3 20h18" />',
    strength: 0.5,
    keeps: true,
    key: "s",
  },
  rasp: {
    name: t("brush_rasp"),
    about: t("brush_rasp_about"),
    icon: '<path d="M2 17h20M4 13l3-5 3 5M10 13l3-5 3 5M16 13l3-5 2 5" />',
    strength: 0.5,
    key: "r",
  },
  fill: {
    name: t("brush_fill"),
    about: t("brush_fill_about"),
    icon: '<path d="M2 8h5c0 12 10 12 10 0h5M8 9h8M9 13h6" />',
    strength: 0.5,
    key: "v",
  },
  inflate: {
    name: t("brush_inflate"),
    about: t("brush_inflate_about"),
    icon: '<path d="M2 19h5c0-9 10-9 10 0h5M12 9V3M9 6l3-3 3 3" />',
    strength: 0.5,
    signed: true,
    key: "i",
  },
  flatten: {
    name: t("brush_flatten"),
    about: t("brush_flatten_about"),
    icon: '<path d="M2 12h20M5 12l2-5M12 12V5M19 12l-2-5M4 19h16" />',
    strength: 0.5,
    key: "w",
  },
  trim: {
    name: t("brush_trim"),
    about: t("brush_trim_about"),
    icon: '<path d="M2 14h20M5 14c2-6 4-6 6 0M13 14c2-8 4-8 6 0M3 10l4-4M17 4l3 3" />',
    strength: 0.7,
    key: "t",
  },
  build: {
    name: t("brush_build"),
    about: t("brush_build_about"),
    icon: '<path d="M2 18h20M5 18v-4h14v4M8 14v-4h8v4M12 8V3M9 5h6" />',
    strength: 0.6,
    key: "h",
  },
  crease: {
    name: t("brush_crease"),
    about: t("brush_crease_about"),
    icon: '<path d="M2 8c6 0 8 2 10 10 2-8 4-10 10-10" />',
    strength: 0.5,
    signed: true,
    key: "c",
  },
  grab: {
    name: t("brush_grab"),
    about: t("brush_grab_about"),
    icon: '<path d="M2 19h4c4 0 4-13 6-13s2 13 6 13h4M12 2v4" />',
    strength: 1,
    follows: "drags",
    keeps: true,
    key: "g",
  },
  grab_connected: {
    name: t("brush_grab_connected"),
    about: t("brush_grab_connected_about"),
    icon: '<path d="M2 20h4c4 0 3-8 6-8s2 8 6 8h4M12 12V4M9 7l3-3 3 3M3 3c6 4 12 4 18 0" />',
    strength: 1,
    follows: "drags",
    key: "Shift+q",
  },
  snake_hook: {
    name: t("brush_snake_hook"),
    about: t("brush_snake_hook_about"),
    icon: '<path d="M2 20h5c4 0 3-6 4-9s5-3 5-6M16 20h6M16 20c-3-3 1-8 3-11M13 3l4 1-1 4" />',
    strength: 1,
    follows: "drags",
    key: "z",
  },
  nudge: {
    name: t("brush_nudge"),
    about: t("brush_nudge_about"),
    icon: '<path d="M2 16c5 0 5-6 9-6s3 6 11 6M13 5h8M18 2l3 3-3 3" />',
    strength: 1,
    follows: "drags",
    key: "n",
  },
  twist: {
    name: t("brush_twist"),
    about: t("brush_twist_about"),
    icon: '<path d="M20 12a8 8 0 1 1-3-6M17 2v4h-4M12 9v6" />',
    strength: 1,
    follows: "turns",
    key: "o",
  },
  bend: {
    name: t("brush_bend"),
    about: t("brush_bend_about"),
    icon: '<path d="M8 21c0-9 2-14 11-16M13 3l6 2-3 5" />',
    strength: 1,
    follows: "drags",
    key: "d",
  },
  pinch: {
    name: t("brush_pinch"),
    about: t("brush_pinch_about"),
    icon: '<path d="M2 12h7M6 9l3 3-3 3M22 12h-7M18 9l-3 3 3 3M12 4v16" />',
    strength: 1,
    follows: "drags",
    signed: true,
    key: "j",
  },
  scale: {
    name: t("brush_scale"),
    about: t("brush_scale_about"),
    icon: '<path d="M4 14v6h6M4 20l7-7M20 10V4h-6M20 4l-7 7" />',
    strength: 1,
    follows: "scales",
    key: "q",
  },
  node: {
    name: t("brush_node"),
    about: t("brush_node_about"),
    icon: '<path d="M2 19h4l6-13 6 13h4M12 6v13" /><circle cx="12" cy="4" r="2" />',
    strength: 1,
    follows: "drags",
    key: "y",
  },
  mask: {
    name: t("brush_mask"),
    about: t("brush_mask_about"),
    icon: '<path d="M3 6c6 3 12 3 18 0 0 9-3 14-9 14S3 15 3 6zM7 11h3M14 11h3" />',
    strength: 1,
    signed: true,
    key: "4",
  },
  paint: {
    name: t("brush_paint"),
    about: t("brush_paint_about"),
    icon: '<path d="M14 3l7 7-7 5-5-5zM9 10c-5 1-3 7-7 9 6 2 11 0 12-4" />',
    strength: 1,
    key: "a",
  },
};
export const BRUSH_MODES = Object.keys(BRUSHES) as Mode[];

/** The mode that replaces a mode while Ctrl or Alt is down. Other modes do not change. */
const INVERSES: Partial<Record<Mode, Mode>> = {
  cut: "deposit",
  deposit: "cut",
  rasp: "fill",
  fill: "rasp",
};
export const inverseOf = (mode: Mode): Mode => INVERSES[mode] ?? mode;

/** Colours to paint with: common pigments. */
export const PALETTE = [
  ["#b23a30", t("pigment_vermilion")],
  ["#c47a1e", t("pigment_ochre")],
  ["#e3c34a", t("pigment_yellow")],
  ["#4f7a3a", t("pigment_green")],
  ["#2f6f9f", t("pigment_blue")],
  ["#6b4a8a", t("pigment_violet")],
  ["#4a2f20", t("pigment_umber")],
  ["#efe9dc", t("pigment_white")],
  ["#22201f", t("pigment_black")],
] as const;

/** One button per brush. */
export const brushButtons = (): string =>
  BRUSH_MODES.map((mode) => {
    const { name, about, icon, key } = BRUSHES[mode]!;
    return `<label title="${name}: ${about} (${key.toUpperCase()})"><input type="radio" name="brush" value="${mode}" aria-label="${name}" /><svg viewBox="0 0 24 24" aria-hidden="true">${icon}</svg><span aria-hidden="true">${name}</span></label>`;
  }).join("");
/** The options of the list of textures. */
export const alphaOptions = (): string =>
  ALPHAS.map((alpha) => `<option value="${alpha}">${t(`alpha_${alpha}`)}</option>`).join("");
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
