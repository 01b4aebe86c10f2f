// SPDX-License-Identifier: MIT
// Encodes the trace of an experiment (its ticks with their forces) as a message.
#pragma once

#include "apps/studio/session/experiment_session.h"

#include "apps/studio/messages.h"

namespace kibori::studio {

// Returns the trace. If there are too many ticks, they are divided into groups of neighbouring
// ticks. The trace has the tick with the largest force of each group.
Trace trace_of(const ExperimentSession& run, const Carving& carving);

}  // namespace kibori::studio
