// SPDX-License-Identifier: MIT
// Makes a milling job of the files that a page uploads. The files are: a program; a program with
// its tools and stock; a project of CAMotics; or a job file with its files. All files are in one
// folder. A job cannot name files outside of it.
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

// Files that can be a part of a job, in addition to meshes and documents. A mesh or a document is
// the stock.
inline constexpr std::array<std::string_view, 13> kProgramsRead{
    ".nc", ".ngc", ".gcode", ".tap", ".cnc",  ".ncc",     ".gc",
    ".g",  ".gz",  ".canon", ".tbl", ".toml", ".camotics"};

struct PlaybackFiles {
  std::shared_ptr<TemporaryFolder> folder;
  std::vector<std::string> names;  // names of the files in `folder`
  std::filesystem::path path(const std::string& name) const { return folder->path() / name; }
};

// Values that the user states if the files do not have them.
struct PlaybackChoice {
  std::optional<Box> stock;
  std::optional<double> pitch_mm, diameter_mm;  // diameter: of all tools
  bool ball = false;
  std::optional<std::string> material;
};

// Values that the files do not have.
struct PlaybackNeeds {
  std::string name;                   // name of the job
  std::vector<std::string> programs;  // names of files
  bool stock = false, tool = false, pitch = false;
  Box suggested_stock;
  double longest_mm = 0;  // longest side of the block in the files; 0: no block
  bool any() const { return stock || tool || pitch; }
};

// Maximum size of the texts of all programs [bytes]. The texts stay in memory.
inline constexpr uint64_t kMaxPlaybackText = uint64_t{1} << 26;
// Diameter and number of teeth of tools, if the files have no tool table.
inline constexpr double kUsualDiameter = 6;
inline constexpr int kUsualTeeth = 2;

// Divides an upload into the files of a job. `list` is JSON with a name and a size for each file,
// in the order of their contents. If `list` is empty, the upload is the file `name`. Errors: a name
// is not plain, or occurs twice; the sizes do not add up; the folder is full.
Result<PlaybackFiles> unpack_job(std::shared_ptr<TemporaryFolder> folder,
                                 const std::filesystem::path& upload, const std::string& name,
                                 const std::string& list);
// Reads the whole job, without its meshes. Errors: there is no program; the job names a file
// outside the folder, or a missing file; those of the readers and of the programs.
Result<PlaybackNeeds> playback_needs(const PlaybackFiles& files);
// Makes the request of a job with these choices. If there is no tool table, writes one into the
// folder. Errors: those of playback_needs; a choice is not positive.
Result<MillRequest> playback_request(const PlaybackFiles& files, const PlaybackChoice& choice);

// Replaces the paths of the folder in a sentence by the names of the files.
std::string without_folder(const PlaybackFiles& files, std::string sentence);

}  // namespace kibori
