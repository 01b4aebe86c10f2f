// SPDX-License-Identifier: MIT
// Encodes the result of an experiment as a message.
#pragma once

#include "apps/studio/session/experiment_session.h"

#include "apps/studio/messages.h"

namespace kibori::studio {

// Keeps only the ticks with the largest forces if there are too many.
Trace trace_of(const ExperimentSession& run, const Carving& carving);

}  // namespace kibori::studio
