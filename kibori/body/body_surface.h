// SPDX-License-Identifier: MIT
// Joins the surfaces of several bodies at their poses, for pictures and exports.
#pragma once

#include <span>

#include <kibori/body/bodies.h>
#include <kibori/surface/surface.h>

namespace kibori {

// True if pictures and exports of the bodies `among` show this body. They leave out invisible
// bodies. Protected bodies (templates, masks) overlap the material of other bodies, so they are
// shown only if all bodies are protected.
bool is_shown(const Body& body, std::span<const Body> among);

// Returns the surfaces of all shown bodies at their poses [mm], as one surface. The result does not
// depend on `threads`.
Surface surface_of(std::span<const Body> bodies, int threads);

}  // namespace kibori
