// SPDX-License-Identifier: MIT
// The surfaces of a list of bodies, at their poses, joined for pictures and exports.
#pragma once

#include <span>

#include <kibori/body/bodies.h>
#include <kibori/surface/surface.h>

namespace kibori {

// True if pictures and exports of `among` show the body. Invisible bodies are left out. Protected
// bodies (templates, masks) overlap the others' material: they are shown only if all are protected.
bool is_shown(const Body& body, std::span<const Body> among);

// The surfaces of all shown bodies, at their poses [mm], as one surface. Results do not depend on
// `threads`.
Surface surface_of(std::span<const Body> bodies, int threads);

}  // namespace kibori
