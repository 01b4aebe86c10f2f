// SPDX-License-Identifier: MIT
// Three numbers: a place [mm], a direction or a colour.
export type Vec3 = [number, number, number];
