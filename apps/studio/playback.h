// SPDX-License-Identifier: MIT
// Answers the requests of pages about a milling job. Internal to apps/studio.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "apps/studio/session/playback_session.h"

namespace kibori::studio {

// Runs a job into the new document `to`, and opens the document. Any thread. Errors: those of the
// job; the document cannot be written.
Result<std::unique_ptr<Session>> keep_playback(const PlaybackFiles& files,
                                               const MillRequest& request,
                                               const std::filesystem::path& to,
                                               const SessionOptions& how);
// Copies the document `from` to the new file `to`, and opens the copy. Any thread.
Result<std::unique_ptr<Session>> open_copy(const std::filesystem::path& from,
                                           const std::filesystem::path& to,
                                           const SessionOptions& how);

// Returns lines of a program as JSON, from the line with index `from` on. Returns nullopt if there
// is no such program.
std::optional<std::string> program_lines(const PlaybackSession& playback, double program,
                                         double from);
// Returns the force and the power over the time so far, as JSON. Returns nullopt if `parts` is not
// a valid number of parts.
std::optional<std::string> force_curve(const PlaybackSession& playback, double parts);
// Returns, as JSON, what the page must ask before the job can begin.
std::string needs_json(const PlaybackNeeds& needs, const std::string& import);

}  // namespace kibori::studio
