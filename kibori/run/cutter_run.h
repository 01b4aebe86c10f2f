// SPDX-License-Identifier: MIT
// Runs a scene's cutter. It cuts bodies apart, computes the force along its feed, and moves the
// parts aside. Internal: not installed.
#pragma once

#include <functional>

#include <kibori/body/bodies.h>
#include <kibori/run/carving_result.h>
#include <kibori/scene/scene.h>

namespace kibori {

// act(action) must change `bodies`. Adds ticks, totals and forces to `carving`. Errors: no body of
// that name, errors of act, a feed of more than 10^7 ticks.
Status run_cutter(const SceneCutter& with, const BodyList& bodies,
                  const std::function<Result<BodyChange>(const BodyAction&)>& act,
                  const Scene& scene, Carving& carving);

}  // namespace kibori
