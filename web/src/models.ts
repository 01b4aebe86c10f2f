// SPDX-License-Identifier: MIT
// What the force models are, in a sentence each: by the name that summaries have, in the order of ChooseModel. The
// command line says the same under its plots (model_note in kibori/session/force_report.cpp).

export const MODELS: Record<string, string> = {
  series: "Series: what a hand feels that pushes the tool by a spring, F = k (hand − tool); it grows until the wood gives way, and stays while the hand rests.",
  energy: "Energy: what the cut costs, F = u × volume removed / way, against the motion; the same for any grid, rate and speed, and nothing at rest.",
  paper: "Paper: what vanishes, F = kf × grid points within a tick, against the motion; more at speed, uneven where they are few, and nothing at rest.",
};
