// SPDX-License-Identifier: MIT
// What an experiment came to, as a message.
#pragma once

#include "apps/studio/session/experiment_session.h"

#include "apps/studio/messages.h"

namespace kibori::studio {

// Of very many ticks, those with the largest forces.
Trace trace_of(const ExperimentSession& run, const Carving& carving);

}  // namespace kibori::studio
