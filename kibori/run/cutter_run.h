// SPDX-License-Identifier: MIT
// Runs a cutter of a scene: cuts bodies apart, computes the force along the cutter's feed, and
// moves the separated parts aside. Internal: not installed.
#pragma once

#include <functional>

#include <kibori/body/bodies.h>
#include <kibori/run/carving_result.h>
#include <kibori/scene/scene.h>

namespace kibori {

// `act` must apply an action to `bodies`. run_cutter() adds ticks, totals and forces to `carving`.
// Errors: no body has the name SceneCutter::body; act() fails; the feed needs more than 10^7 ticks.
Status run_cutter(const SceneCutter& with, const BodyList& bodies,
                  const std::function<Result<BodyChange>(const BodyAction&)>& act,
                  const Scene& scene, Carving& carving);

}  // namespace kibori
