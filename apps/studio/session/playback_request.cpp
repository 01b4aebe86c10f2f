// SPDX-License-Identifier: MIT
#include "apps/studio/session/playback_request.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <utility>
#include <variant>

#include <kibori/base/json.h>
#include <kibori/formats/mesh_format.h>
#include <kibori/mill/program_survey.h>
#include <kibori/run/documents.h>
#include <kibori/run/milling_job.h>

#include "apps/studio/session/stock_scene.h"

namespace kibori {
namespace {

namespace fs = std::filesystem;

// Of one upload, and bytes of a name.
constexpr size_t kMaxFiles = 64, kMaxName = 200;
constexpr uint64_t kMaxTableBytes = uint64_t{1} << 24;

// The files by their use.
struct Sorted {
  std::vector<fs::path> programs;  // or one job file, or a job of CAMotics
  fs::path tools, machine, stock;
  bool is_job() const { return programs.size() == 1 && ending_of(programs.front()) == ".toml"; }
};

// The use of a TOML file, by its first table of a known name.
enum class TomlUse { job, tools, machine };
Result<TomlUse> use_of(const fs::path& path) {
  const Result<std::vector<char>> bytes = read_file(path, kMaxTableBytes);
  if (!bytes) return Error{bytes.error()};
  const std::string_view text(bytes.value().data(), bytes.value().size());
  const auto has = [&](std::string_view table) {
    return text.starts_with(table) || text.find("\n" + std::string(table)) != text.npos;
  };
  if (has("[[setup]]")) return TomlUse::job;
  if (has("[[tool]]")) return TomlUse::tools;
  if (has("[machine]")) return TomlUse::machine;
  return TomlUse::job;
}

Status set_once(fs::path& file, const fs::path& to, const char* what) {
  if (!file.empty())
    return Error{file.filename().string() + " and " + to.filename().string() + ": both are " +
                 what + "; choose one of them"};
  file = to;
  return Ok{};
}

Result<Sorted> sort_files(const PlaybackFiles& files) {
  Sorted sorted;
  fs::path job;
  for (const std::string& name : files.names) {
    const fs::path path = files.path(name);
    const std::string ending = ending_of(path);
    Status ok = Ok{};
    if (ending == ".toml") {
      const Result<TomlUse> use = use_of(path);
      if (!use) return Error{use.error()};
      ok = use.value() == TomlUse::job     ? set_once(job, path, "job files")
           : use.value() == TomlUse::tools ? set_once(sorted.tools, path, "tables of tools")
                                           : set_once(sorted.machine, path, "machine files");
    } else if (ending == ".camotics") {
      ok = set_once(job, path, "jobs");
    } else if (ending == ".tbl") {
      ok = set_once(sorted.tools, path, "tables of tools");
    } else if (is_one_of(kMeshesRead, ending) || is_document(path)) {
      ok = set_once(sorted.stock, path, "the stock");
    } else if (is_one_of(kProgramsRead, ending)) {
      sorted.programs.push_back(path);
    } else {
      ok = Error{name + ": is not a program, a table of tools, a machine file or a stock"};
    }
    if (!ok) return Error{ok.error()};
  }
  // A job names its files itself.
  if (!job.empty()) sorted = {{job}, {}, {}, {}};
  if (sorted.programs.empty())
    return Error{"there is no program among the files; choose a program, or a job with its files"};
  return sorted;
}

// A job may only name files of its folder.
Status check_inside(const PlaybackFiles& files, const fs::path& job, const fs::path& named) {
  if (named.empty()) return Ok{};
  const std::string name = named.filename().string();
  const bool inside = named.lexically_normal().parent_path() == files.folder->path();
  if (inside && std::find(files.names.begin(), files.names.end(), name) != files.names.end())
    return Ok{};
  const std::string wanted = named.lexically_relative(files.folder->path()).string();
  return Error{job.filename().string() + ": names the file " +
               sanitize_message(inside || wanted.empty() ? name : wanted) +
               (inside ? "; choose it together with the job"
                       : "; move it next to the job, and choose both together")};
}

Status check_job(const PlaybackFiles& files, const fs::path& path) {
  std::vector<fs::path> named;
  if (ending_of(path) == ".camotics") {
    Result<MillProject> project = read_camotics(path);
    if (!project) return Error{project.error()};
    named = project.value().programs;
  } else {
    const Result<MillJob> job = read_mill_job(path);
    if (!job) return Error{job.error()};
    if (const auto* stock = std::get_if<fs::path>(&job.value().stock)) named.push_back(*stock);
    for (const MillJobSetup& setup : job.value().setups) {
      named.insert(named.end(), setup.programs.begin(), setup.programs.end());
      named.insert(named.end(), setup.fixtures.begin(), setup.fixtures.end());
      named.insert(named.end(), {setup.tools, setup.machine, setup.target});
    }
  }
  for (const fs::path& file : named)
    if (Status ok = check_inside(files, path, file); !ok) return ok;
  return Ok{};
}

// The request without choices.
Result<MillRequest> request_of(const PlaybackFiles& files) {
  Result<Sorted> sorted = sort_files(files);
  if (!sorted) return Error{sorted.error()};
  const Sorted& s = sorted.value();
  for (const fs::path& path : s.programs)
    if (ending_of(path) == ".toml" || ending_of(path) == ".camotics")
      if (Status ok = check_job(files, path); !ok) return Error{ok.error()};
  MillRequest request;
  request.programs = s.programs;
  request.tools = s.tools;
  request.machine = s.machine;
  if (!s.stock.empty()) request.stock = s.stock;
  return request;
}

bool is_camotics(const MillRequest& request) {
  return ending_of(request.programs.front()) == ".camotics";
}

// Any block, to plan a job whose stock is unknown.
constexpr double kAnySide = 10;

Status write_tools(const fs::path& path, const std::set<int>& numbers, double diameter, bool ball) {
  NewFile file(path);
  for (const int number : numbers) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "[[tool]]\nnumber = %d\ncutter = { shape = \"%s\", radius = %.9g, length = %.9g "
                  "}\nteeth = %d\n",
                  number, ball ? "ballnose" : "flat", 0.5 * diameter, 10 * diameter, kUsualTeeth);
    file.write(text);
  }
  return file.commit();
}

struct Surveyed {
  MillPlan plan;
  std::vector<ProgramSurvey> surveys;
  std::set<int> tools;
};

// Plans the job and reads its programs. A block stands in for an unknown stock.
Result<Surveyed> survey(MillRequest request) {
  const bool is_job = ending_of(request.programs.front()) == ".toml";
  bool unknown = !request.stock && !is_job;
  if (unknown && is_camotics(request)) {
    const Result<MillProject> project = read_camotics(request.programs.front());
    if (!project) return Error{project.error()};
    unknown = !project.value().workpiece_mm;
  }
  if (unknown) request.stock = Box{Vec3(Vec3::Zero()), Vec3(Vec3::Constant(kAnySide))};
  Result<MillPlan> plan = plan_milling(request);
  if (!plan) return Error{plan.error()};
  Surveyed surveyed{std::move(plan).value(), {}, {}};
  if (unknown) surveyed.plan.stock.reset();
  for (const MillSetup& setup : surveyed.plan.setups)
    for (const fs::path& program : setup.programs) {
      Result<ProgramSurvey> read = survey_program(program);
      if (!read) return Error{read.error()};
      surveyed.tools.insert(read.value().tools.begin(), read.value().tools.end());
      surveyed.surveys.push_back(std::move(read).value());
    }
  if (surveyed.tools.empty()) surveyed.tools.insert(1);
  return surveyed;
}

bool knows_tools(const MillPlan& plan) {
  return std::all_of(plan.setups.begin(), plan.setups.end(),
                     [](const MillSetup& setup) { return !setup.options.tools.tools.empty(); });
}

Result<PlaybackNeeds> needs_of(const PlaybackFiles& files) {
  Result<MillRequest> request = request_of(files);
  if (!request) return Error{request.error()};
  const Result<Surveyed> read = survey(request.value());
  if (!read) return Error{read.error()};
  const MillPlan& plan = read.value().plan;
  PlaybackNeeds needs;
  needs.name = request.value().programs.front().stem().string();
  for (const MillSetup& setup : plan.setups)
    for (const fs::path& program : setup.programs)
      needs.programs.push_back(program.filename().string());
  needs.stock = !plan.stock;
  needs.tool = !knows_tools(plan);
  if (needs.tool && ending_of(request.value().programs.front()) == ".toml")
    return Error{needs.name + ".toml: names no tools; add tools = \"tools.toml\" to it"};
  if (needs.stock) {
    const std::optional<Box> stock = suggested_stock(read.value().surveys, 0.5 * kUsualDiameter);
    if (!stock) return Error{needs.programs.front() + ": has no feed move, so it mills nothing"};
    needs.suggested_stock = *stock;
  } else if (const Box* const block = std::get_if<Box>(&*plan.stock)) {
    needs.longest_mm = block->size().maxCoeff();
    needs.pitch = plan.pitch_mm && needs.longest_mm > kMaxRays * *plan.pitch_mm;
  }
  return needs;
}

Result<MillRequest> chosen(const PlaybackFiles& files, const PlaybackChoice& choice) {
  Result<MillRequest> request = request_of(files);
  if (!request) return request;
  MillRequest& made = request.value();
  made.pitch_mm = choice.pitch_mm;
  made.material = choice.material;
  if (choice.stock) made.stock = *choice.stock;
  if (!choice.diameter_mm) return request;
  const Result<Surveyed> read = survey(made);
  if (!read) return Error{read.error()};
  // A name that no file of the user has: it has no ending before .toml.
  made.tools = files.path(" tools.toml");
  if (Status ok = write_tools(made.tools, read.value().tools, *choice.diameter_mm, choice.ball);
      !ok)
    return Error{ok.error()};
  return request;
}

// True for a name that can be a file of the folder, and is no other file there.
bool is_plain(const std::string& name, const PlaybackFiles& files) {
  return !name.empty() && name.size() <= kMaxName && name.front() != '.' && name.front() != ' ' &&
         name.find('/') == name.npos && name.find('\0') == name.npos &&
         std::find(files.names.begin(), files.names.end(), name) == files.names.end();
}

Status copy_part(std::FILE* from, uint64_t bytes, const fs::path& to) {
  NewFile file(to);
  std::vector<char> chunk(size_t{1} << 16);
  while (bytes > 0) {
    const size_t got = std::fread(chunk.data(), 1, std::min<uint64_t>(bytes, chunk.size()), from);
    if (got == 0) return Error{"the upload is incomplete; choose the files again"};
    file.write(chunk.data(), got);
    bytes -= got;
  }
  return file.commit();
}

}  // namespace

Result<PlaybackFiles> unpack_job(std::shared_ptr<TemporaryFolder> folder, const fs::path& upload,
                                 const std::string& name, const std::string& list) {
  PlaybackFiles files{std::move(folder), {}};
  const auto bad = [](const std::string& wrong) {
    return Error{sanitize_message(wrong) + ": is not a name of a file for a job; rename it"};
  };
  if (list.empty()) {
    if (!is_plain(name, files)) return bad(name);
    std::error_code failed;
    fs::rename(upload, files.path(name), failed);
    if (failed) return Error{"the temporary folder is full"};
    files.names = {name};
    return files;
  }
  const Json json = parse_json(list);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> from(std::fopen(upload.c_str(), "rb"),
                                                             &std::fclose);
  if (!from || !json.is_array() || json.empty() || json.size() > kMaxFiles)
    return Error{"a job has 1 to " + std::to_string(kMaxFiles) + " files; choose fewer"};
  for (const Json& one : json) {
    const bool complete = one.is_object() && one.contains("name") && one["name"].is_string() &&
                          one.contains("size") && one["size"].is_number_unsigned();
    if (!complete) return Error{"the list of files is damaged; reload the page"};
    const std::string called = one["name"].get<std::string>();
    if (!is_plain(called, files)) return bad(called);
    if (Status ok = copy_part(from.get(), one["size"].get<uint64_t>(), files.path(called)); !ok)
      return Error{ok.error()};
    files.names.push_back(called);
  }
  std::error_code ignored;
  if (!is_one_of(files.names, upload.filename().string())) fs::remove(upload, ignored);
  return files;
}

Result<PlaybackNeeds> playback_needs(const PlaybackFiles& files) {
  Result<PlaybackNeeds> needs = needs_of(files);
  return needs ? std::move(needs) : Error{without_folder(files, needs.error())};
}

Result<MillRequest> playback_request(const PlaybackFiles& files, const PlaybackChoice& choice) {
  if (choice.stock && !(choice.stock->size().array() > 0).all())
    return Error{"the stock needs a lower corner that is below its upper corner on each axis"};
  for (const std::optional<double>& size : {choice.pitch_mm, choice.diameter_mm})
    if (size && !(*size > 0)) return Error{"the pitch and the diameter must be positive"};
  Result<MillRequest> request = chosen(files, choice);
  return request ? std::move(request) : Error{without_folder(files, request.error())};
}

std::string without_folder(const PlaybackFiles& files, std::string sentence) {
  const std::string folder = files.folder->path().string() + "/";
  for (size_t at = 0; (at = sentence.find(folder, at)) != std::string::npos;)
    sentence.erase(at, folder.size());
  return sentence;
}

}  // namespace kibori
