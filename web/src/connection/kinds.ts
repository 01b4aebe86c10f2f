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

/** What a tool does (kibori/motion/tool_tick.h). */
export const MODES = ["cut", "deposit", "touch", "off", "smooth", "rasp", "fill", "inflate", "flatten", "crease", "paint", "grab", "nudge", "twist", "bend", "pinch", "scale", "node", "press", "throw", "turn", "trim", "build"] as const;
export type Mode = (typeof MODES)[number];

/** How motion becomes force (kibori/haptics/force.h). */
export const MODELS = ["series", "energy", "paper"] as const;
export type Model = (typeof MODELS)[number];

/** A sentence on each. */
export const MODEL_NOTES: Record<Model, string> = {
  series:
    "Series: what a hand feels that pushes the tool by a spring, F = k (hand − tool); it grows until the wood gives way, and stays while the hand rests.",
  energy:
    "Energy: what the cut costs, F = u × volume removed / way, against the motion; the same for any grid, rate and speed, and nothing at rest.",
  paper:
    "Paper: what vanishes, F = kf × grid points within a tick, against the motion; more at speed, uneven where they are few, and nothing at rest.",
};

/** The files that can be brought, as <input accept> has them: those that become bodies, and all. */
export const MESHES = ".stl, .ply, .obj, .off, .3mf, .glb, .gltf";
export const IMPORTS = `${MESHES}, .png, .nrrd, .kibori`;

/** Materials of one document, at most. */
export const MAX_MATERIALS = 64;
