// SPDX-License-Identifier: MIT
// Answers to pages about a milling job. Internal to apps/studio.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "apps/studio/session/playback_session.h"

namespace kibori::studio {

// Runs a job into a new document and opens it. Any thread. Errors: those of the job and the file.
Result<std::unique_ptr<Session>> keep_playback(const PlaybackFiles& files,
                                               const MillRequest& request,
                                               const std::filesystem::path& to,
                                               const SessionOptions& how);
// Copies a document to a new file and opens that. Any thread.
Result<std::unique_ptr<Session>> open_copy(const std::filesystem::path& from,
                                           const std::filesystem::path& to,
                                           const SessionOptions& how);

// JSON for the page. Lines of a program from an index on; nullopt: there is no such program.
std::optional<std::string> program_lines(const PlaybackSession& playback, double program,
                                         double from);
// Force and power over the time so far; nullopt: not a number of parts.
std::optional<std::string> force_curve(const PlaybackSession& playback, double parts);
// What the page must ask before a job can begin.
std::string needs_json(const PlaybackNeeds& needs, const std::string& import);

}  // namespace kibori::studio
