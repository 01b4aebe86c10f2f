// SPDX-License-Identifier: MIT
// The union of several parts. Each part has at most one interval per ray, in its layer 0. The
// functions compute the intervals of the union, and find the part that made an end. Internal to
// `solid`.
#pragma once

#include <cstddef>

#include <kibori/solid/solid.h>

namespace kibori {

// Maximum number of parts per call.
inline constexpr size_t kMaxUnionParts = 8;

// Fills `out` with one interval per ray. It reaches from the first begin to the last end of all
// parts. The union of the parts must be convex.
void hull_spans(const SpanLayer* parts, size_t count, SpanLayer& out);

// Fills `out` with layer `layer` of the union. Intervals that touch or overlap are merged into one.
void union_spans(const SpanLayer* parts, size_t count, int layer, SpanLayer& out);

// Returns those `ends` of `of` that `part` made. `part` made an end if it has exactly the same
// number there as `of`.
EndMasks ends_made_by(const SpanLayer& part, const SpanLayer& of, const EndMasks& ends);

// Copies the normals of `part` to `of`, for these `ends`.
void take_normals(const SpanLayer& part, const EndMasks& ends, SpanLayer& of);

}  // namespace kibori
