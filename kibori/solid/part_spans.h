// SPDX-License-Identifier: MIT
// The union of parts with at most one interval per ray each (layer 0 of each part). It computes the
// intervals of the union, and finds the part that made an end. Internal to `solid`.
#pragma once

#include <cstddef>

#include <kibori/solid/solid.h>

namespace kibori {

// Maximum number of parts per call.
inline constexpr size_t kMaxUnionParts = 8;

// Fills `out` with one interval per ray, from the first begin to the last end of the parts. The
// union must be convex.
void hull_spans(const SpanLayer* parts, size_t count, SpanLayer& out);

// Fills layer `layer` of the union. Parts that meet are merged into one interval.
void union_spans(const SpanLayer* parts, size_t count, int layer, SpanLayer& out);

// The subset of `ends` that `part` made: `part` has exactly the same number there as `of`.
EndMasks ends_made_by(const SpanLayer& part, const SpanLayer& of, const EndMasks& ends);

// Copies the normals of `part` to the `ends` of `of`.
void take_normals(const SpanLayer& part, const EndMasks& ends, SpanLayer& of);

}  // namespace kibori
