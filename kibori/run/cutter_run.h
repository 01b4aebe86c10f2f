// SPDX-License-Identifier: MIT
// Runs a scene's cutter: cuts bodies apart, computes the force along the feed, and moves the
// separated parts aside. Internal: not installed.
#pragma once

#include <functional>

#include <kibori/body/bodies.h>
#include <kibori/run/carving_result.h>
#include <kibori/scene/scene.h>

namespace kibori {

// act(action) must apply the action to `bodies`. Adds ticks, totals and forces to `carving`.
// Errors: no body has the cutter's body name; those of act; a feed of more than 10^7 ticks.
Status run_cutter(const SceneCutter& with, const BodyList& bodies,
                  const std::function<Result<BodyChange>(const BodyAction&)>& act,
                  const Scene& scene, Carving& carving);

}  // namespace kibori
