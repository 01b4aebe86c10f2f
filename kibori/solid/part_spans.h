// SPDX-License-Identifier: MIT
// Of parts with at most one interval a ray each (layer 0 of what they say of a tile): the intervals
// of their union, and which part made which end. Internal to `solid`.
#pragma once

#include <cstddef>

#include <kibori/solid/solid.h>

namespace kibori {

// The most that are asked for at a time.
inline constexpr size_t kMostParts = 8;

// Fills `out` with one interval a ray, from where the first part begins to where the last one ends:
// that of a union that is convex.
void hull_spans(const SpanLayer* parts, size_t count, SpanLayer& out);

// Fills layer `layer` of the union: the parts' intervals, merged where they meet.
void union_spans(const SpanLayer* parts, size_t count, int layer, SpanLayer& out);

// Those of `ends` that `part` made: it has the very same number there as `of`.
EndMasks ends_made_by(const SpanLayer& part, const SpanLayer& of, const EndMasks& ends);

// Gives the `ends` of `of` the normals that `part` has there.
void take_normals(const SpanLayer& part, const EndMasks& ends, SpanLayer& of);

}  // namespace kibori
