// SPDX-License-Identifier: MIT
// Encodes the result of an experiment as a message.
#pragma once

#include "apps/studio/session/experiment_session.h"

#include "apps/studio/messages.h"

namespace kibori::studio {

// If there are too many ticks, it divides them into groups of successive ticks. It keeps the tick
// with the largest force of each group.
Trace trace_of(const ExperimentSession& run, const Carving& carving);

}  // namespace kibori::studio
