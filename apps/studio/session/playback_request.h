// SPDX-License-Identifier: MIT
// From the files that a page brings to a milling job: a program alone, a program with its tools and
// stock, a job of CAMotics, or a job file. All files are in one folder. A job cannot name others.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <kibori/base/file.h>
#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/run/milling_plan.h>

namespace kibori {

// Files that make a job: programs, jobs and tables. A mesh or a document among them is the stock.
inline constexpr std::array<std::string_view, 13> kProgramsRead{
    ".nc", ".ngc", ".gcode", ".tap", ".cnc",  ".ncc",     ".gc",
    ".g",  ".gz",  ".canon", ".tbl", ".toml", ".camotics"};

struct PlaybackFiles {
  std::shared_ptr<TemporaryFolder> folder;
  std::vector<std::string> names;  // in it
  std::filesystem::path path(const std::string& name) const { return folder->path() / name; }
};

// What the user states if the files do not.
struct PlaybackChoice {
  std::optional<Box> stock;
  std::optional<double> pitch_mm, diameter_mm;  // of all tools
  bool ball = false;
  std::optional<std::string> material;
};

// What the files leave open.
struct PlaybackNeeds {
  std::string name;                   // of the job
  std::vector<std::string> programs;  // names of files
  bool stock = false, tool = false, pitch = false;
  Box suggested_stock;
  double longest_mm = 0;  // of the stock, if the files state a block
  bool any() const { return stock || tool || pitch; }
};

// Maximum text of all programs [bytes]. It stays in memory.
inline constexpr uint64_t kMaxPlaybackText = uint64_t{1} << 26;
// Diameter of tools that no table lists, and number of their teeth.
inline constexpr double kUsualDiameter = 6;
inline constexpr int kUsualTeeth = 2;

// Divides an upload into the files of a job. `list`: JSON, a name and a size for each file, in the
// order of their content; empty: the upload is the file `name`. Errors: a name that is not plain, or
// appears twice; sizes that do not add up; the folder is full.
Result<PlaybackFiles> unpack_job(std::shared_ptr<TemporaryFolder> folder,
                                 const std::filesystem::path& upload, const std::string& name,
                                 const std::string& list);
// Reads the whole job, without meshes. Errors: one sentence: those of the readers and programs; no
// program; a job that names a file outside the folder, or one that is missing.
Result<PlaybackNeeds> playback_needs(const PlaybackFiles& files);
// The job with these choices. It writes a table of tools into the folder if there is none. Errors:
// those above; a choice that is not positive.
Result<MillRequest> playback_request(const PlaybackFiles& files, const PlaybackChoice& choice);

// Names of files of the folder, instead of their paths, in a sentence.
std::string without_folder(const PlaybackFiles& files, std::string sentence);

}  // namespace kibori
