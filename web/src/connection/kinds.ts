// SPDX-License-Identifier: MIT
// Made by apps/studio/make_kinds.cpp from the library's own lists: change those.
import type { Vec3 } from "../base/vec3";

/** A tool: its shape and its numbers [mm, degrees]; kibori/solid/tools/ says what they are. */
export type Tool =
  | { shape: "finger"; ks: number; length: number }
  | { shape: "ball"; radius: number }
  | { shape: "flat"; radius: number; length: number }
  | { shape: "bull"; radius: number; corner: number; length: number }
  | { shape: "cone"; angle_deg: number; radius: number; length: number }
  | { shape: "capsule"; radius: number; length: number }
  | { shape: "halfspace" }
  | { shape: "box"; size: Vec3 }
  | { shape: "ellipsoid"; radii: Vec3 }
  | { shape: "mesh" }
  | { shape: "drill"; angle_deg: number; radius: number; length: number }
  | { shape: "tapered"; ball: number; angle_deg: number; radius: number; length: number }
  | { shape: "gouge"; sweep: number; width: number; thickness: number; length: number }
  | { shape: "vee"; angle_deg: number; width: number; thickness: number; length: number }
  | { shape: "chisel"; width: number; bevel_deg: number; thickness: number; length: number }
  | { shape: "skew"; width: number; skew_deg: number; bevel_deg: number; thickness: number; length: number }
  | { shape: "knife"; edge_deg: number; point_deg: number; length: number }
  | { shape: "lollipop"; radius: number; neck: number; reach: number; shank: number; length: number }
  | { shape: "tslot"; radius: number; height: number; neck: number; reach: number; shank: number; length: number };

/** What a tool does (kibori/motion/mode.h). */
export const MODES = ["cut", "deposit", "touch", "off", "smooth", "rasp", "fill", "inflate", "flatten", "crease", "paint", "grab", "nudge", "twist", "bend", "pinch", "scale", "node", "press", "throw", "turn", "trim", "build", "snake_hook", "grab_connected", "mask"] as const;
export type Mode = (typeof MODES)[number];

/** How motion becomes force (kibori/haptics/force.h). */
export const MODELS = ["series", "energy", "paper"] as const;
export type Model = (typeof MODELS)[number];

/** The textures of brushes (kibori/reshape/alpha.h). */
export const ALPHAS = ["none", "scales", "bark", "hatching", "leather", "cracks", "pores", "weave", "knit", "hammered", "fur", "ripples", "studs", "picture"] as const;
export type Alpha = (typeof ALPHAS)[number];

/** What the mode mask does (kibori/reshape/brush.h). */
export const MASK_VERBS = ["paint", "invert", "blur", "cavity", "height", "material"] as const;
export type MaskVerb = (typeof MASK_VERBS)[number];

/** What the pressure of a pen changes (kibori/reshape/brush.h). */
export const PRESSURE_USES = ["none", "size", "strength", "both"] as const;
export type PressureUse = (typeof PRESSURE_USES)[number];

/** One sentence for each force model. */
export const MODEL_NOTES: Record<Model, string> = {
  series:
    "Series: a spring pulls the tool to the hand, F = k (hand − tool). The force grows until the wood gives way, and stays while the hand rests.",
  energy:
    "Energy: the force of the cut by the material's law and the removed volume, against the motion. It does not depend on the lattice or the rate, and it is zero at rest.",
  paper:
    "Paper: F = kf × lattice points removed in a tick, against the motion. It grows with the speed, is uneven where the points are few, and is zero at rest.",
};

/** The endings of files that can become bodies, for <input accept>, and of all files that can be imported. */
export const MESHES = ".stl, .ply, .obj, .off, .3mf, .glb, .gltf";
export const IMPORTS = `${MESHES}, .png, .nrrd, .kibori, .nc, .ngc, .gcode, .tap, .cnc, .ncc, .gc, .g, .gz, .canon, .tbl, .toml, .camotics`;

/** The maximum number of materials in a document. */
export const MAX_MATERIALS = 64;
