// SPDX-License-Identifier: MIT
// Three numbers: a position [mm], a direction or a colour.
export type Vec3 = [number, number, number];
