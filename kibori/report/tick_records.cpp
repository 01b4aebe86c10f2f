// SPDX-License-Identifier: MIT
#include <kibori/report/tick_records.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

#include <hdf5.h>

#include <kibori/base/file.h>
#include <kibori/base/json.h>
#include <kibori/run/documents.h>
#include <kibori/report/tick_row.h>
#include <kibori/document/body_codec.h>
#include <kibori/document/codec.h>
#include <kibori/formats/mcap.h>

namespace kibori {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kRowsAtOnce = 4096;

std::array<double, 3> three(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

// Name of a material's column.
std::string column_name(const std::string& material) {
  std::string name = "removed_";
  // Keeps the bytes of non-ASCII letters.
  for (const char c : material) {
    const auto byte = static_cast<unsigned char>(c);
    name += byte >= 0x80 || std::isalnum(byte) ? c : '_';
  }
  return name + "_mm3";
}

void append(std::string& to, double number) {
  // Independent of the locale.
  char text[40];
  const auto written = std::to_chars(text, text + sizeof text, number);
  to.append(",").append(text, written.ptr);
}

}  // namespace

Result<TickRecords> about_ticks(const Document& document, StepId to) {
  if (Status rows = document.check_rows(to); !rows) return Error{rows.error()};
  const Result<std::vector<StepId>> path = document.path_to(to);
  if (!path) return Error{path.error()};
  TickRecords records;
  Json steps = Json::array();
  for (const StepId id : path.value()) {
    const Step& step = document.steps().at(id);
    Json one{{"step", id}, {"label", step.label}, {"made_s_since_1970", step.made_s}};
    if (step.stock) {
      const Result<std::string> stock = document.stock();
      one["kind"] = "stock";
      one["stock"] = parse_json(stock ? stock.value() : "{}");
    } else if (step.action) {
      const Result<BodyAction> action = document.action(id);
      if (!action) return Error{action.error()};
      one["kind"] = "bodies";
      one["action"] = parse_json(action_to_json(action.value()));
    } else {
      const Result<StrokeSettings> settings = document.settings(id);
      if (!settings) return Error{settings.error()};
      // for_tick_records computes the forces again. So this only checks that those in the document
      // are undamaged.
      const auto check_only = [](const std::vector<Wrench>&) -> Status { return Ok{}; };
      if (Status forces = document.for_forces(id, check_only); !forces)
        return Error{forces.error()};
      one["kind"] = "stroke";
      one["ticks"] = step.ticks;
      one["removed_mm3"] = step.removed_mm3;
      one["settings"] = parse_json(settings_to_json(settings.value()));
      records.milled |= !settings.value().program.empty();
      for (const Material& material : settings.value().materials)
        if (std::find(records.materials.begin(), records.materials.end(), material.name) ==
            records.materials.end())
          records.materials.push_back(material.name);
    }
    steps.push_back(std::move(one));
  }
  const Json about{
      {"program", "kibori"},
      {"version", KIBORI_VERSION},
      {"format", 1},
      {"document", std::filesystem::path(document.name()).filename().string()},
      {"lattice", parse_json(lattice_to_json(document.lattice()))},
      {"materials", records.materials},
      {"units", "mm, s, N, N mm, mm3; quaternions x, y, z, w"},
      {"clock",
       "time_s counts ticks from the first stroke's beginning; strokes follow one another"},
      {"steps", std::move(steps)}};
  records.about = about.dump(-1, ' ', false, Json::error_handler_t::replace);
  return records;
}

namespace {

// Data of a stroke that fill_record needs.
struct StrokeContext {
  const StrokeSettings& settings;
  const TickRecords& records;
  Pose body_pose;  // pose of the body that it carves
  double cell_mm3;
  std::vector<size_t> column;  // index into records.materials, by the stroke's material

  // The document stores everything in the body's own coordinates.
  Wrench to_world(const Wrench& wrench) const {
    return {body_pose.frame * wrench.force, body_pose.frame * wrench.moment};
  }
};

std::vector<size_t> columns_of(const std::vector<Material>& materials, const TickRecords& records) {
  std::vector<size_t> column;
  for (const Material& material : materials)
    column.push_back(static_cast<size_t>(
        std::find(records.materials.begin(), records.materials.end(), material.name) -
        records.materials.begin()));
  return column;
}

Result<std::vector<Wrench>> given_forces(const Document& document, StepId step) {
  std::vector<Wrench> given;
  const Status read = document.for_given(step, [&](const std::vector<Wrench>& forces) -> Status {
    given.insert(given.end(), forces.begin(), forces.end());
    return Ok{};
  });
  if (!read) return Error{read.error()};
  return given;
}

// Fills a tick's record, except for its step, its time and the given force.
void fill_record(TickRecord& record, const ReplayedTick& tick, const StrokeContext& stroke) {
  const RecordedTick& recorded = *tick.recorded;
  const StrokeSettings& s = stroke.settings;
  record.hand = recorded.second ? 2 : 1;
  record.line = recorded.line;
  const auto* const move = std::get_if<MoveTick>(&recorded.what);
  record.mode = !(move && move->edits)        ? Mode::off
                : recorded.second && s.second ? s.second->mode
                                              : s.mode;
  record.tool = record.hand_pose = tick.result.pose;
  if (move) {
    record.hand_pose.tip += move->stretch_mm;
    record.hand_pose.frame = rotation(move->stretch_rad) * record.tool.frame;
  }
  record.tool = stroke.body_pose.to_world(record.tool);
  record.hand_pose = stroke.body_pose.to_world(record.hand_pose);
  record.computed = stroke.to_world(tick.result.wrench);
  record.removed_mm3 = record.mode == Mode::touch ? 0 : tick.result.removed_mm3;
  record.points = tick.result.points;
  record.removed_of.assign(stroke.records.materials.size(), 0);
  if (!tick.removed || record.mode == Mode::touch) return;
  const double sign = record.mode == Mode::deposit ? -1 : 1;
  tick.removed->for_parts([&](int material, const RemovedPart& part) {
    const size_t at = std::min(static_cast<size_t>(material), stroke.column.size() - 1);
    record.removed_of[stroke.column[at]] += sign * stroke.cell_mm3 * part.volume();
  });
}

// Calls `use` for the ticks of a stroke that begins at `begun_s`. Sets `begun_s` to the time of its
// end.
Status for_stroke_records(const Document& document, StepId id, const TickRecords& records,
                          Workbench& bench, double& begun_s,
                          const std::function<Status(const TickRecord&)>& use) {
  const Result<StrokeSettings> settings = document.settings(id);
  if (!settings) return Error{settings.error()};
  const Result<std::vector<Wrench>> given = given_forces(document, id);
  if (!given) return Error{given.error()};
  const Body* const body = bench.bodies().find(settings.value().body);
  const StrokeContext stroke{settings.value(), records, body ? body->pose : Pose{},
                             std::pow(document.lattice().pitch_mm, 3),
                             columns_of(settings.value().materials, records)};
  Status used = Ok{};
  size_t count = 0;
  double ended_s = begun_s;
  TickRecord record;
  record.step = id;
  Status carved = document.replay(id, bench, std::nullopt, [&](const ReplayedTick& tick) {
    if (!used) return;
    fill_record(record, tick, stroke);
    record.time_s = begun_s + tick.time_s;
    ended_s = std::max(ended_s, record.time_s);
    const Vec3 none = Vec3::Constant(kNothing);
    record.given =
        count < given.value().size() ? stroke.to_world(given.value()[count]) : Wrench{none, none};
    count++;
    used = use(record);
  });
  begun_s = ended_s;
  return carved ? used : carved;
}

}  // namespace

Status for_tick_records(const Document& document, StepId to, const TickRecords& records,
                        const std::function<Status(const TickRecord&)>& use) {
  const Result<std::vector<StepId>> path = document.path_to(to);
  if (!path) return Error{path.error()};
  Result<std::unique_ptr<TriDexel>> model = document.load_at(path.value().front());
  if (!model) return Error{model.error()};
  Workbench bench(*model.value());
  double begun_s = 0;
  for (const StepId id : path.value()) {
    const Step& step = document.steps().at(id);
    if (step.stock) continue;
    const Status done = step.action
                            ? document.replay(id, bench, std::nullopt, {})
                            : for_stroke_records(document, id, records, bench, begun_s, use);
    if (!done) return done;
  }
  return Ok{};
}

Status write_ticks_csv(const std::filesystem::path& path, const Document& document, StepId to) {
  const Result<TickRecords> records = about_ticks(document, to);
  if (!records) return Error{records.error()};
  NewFile file(path);
  file.write("# " + records.value().about + "\n");
  std::string line =
      "step,time_s,hand,mode,x_mm,y_mm,z_mm,qx,qy,qz,qw,hand_x_mm,hand_y_mm,hand_z_mm,hand_qx,"
      "hand_qy,hand_qz,hand_qw,fx_N,fy_N,fz_N,mx_Nmm,my_Nmm,mz_Nmm,given_fx_N,given_fy_N,"
      "given_fz_N,given_mx_Nmm,given_my_Nmm,given_mz_Nmm,removed_mm3,points";
  if (records.value().milled) line += ",line";
  std::vector<std::string> columns;
  for (const std::string& material : records.value().materials) {
    std::string column = column_name(material);
    // Column names may become equal when characters are replaced.
    if (std::find(columns.begin(), columns.end(), column) != columns.end())
      column.append("_").append(std::to_string(columns.size() + 1));
    columns.push_back(column);
    line.append(",").append(column);
  }
  file.write(line + "\n");
  const Status done =
      for_tick_records(document, to, records.value(), [&](const TickRecord& tick) -> Status {
        line = std::to_string(tick.step);
        append(line, tick.time_s);
        line.append(tick.hand == 2 ? ",2," : ",1,").append(name_of(tick.mode));
        for (const Pose* pose : {&tick.tool, &tick.hand_pose})
          for (const double number : numbers_of(*pose)) append(line, number);
        for (const Wrench* wrench : {&tick.computed, &tick.given})
          for (const Vec3* v : {&wrench->force, &wrench->moment})
            for (const double number : three(*v)) append(line, number);
        append(line, tick.removed_mm3);
        append(line, static_cast<double>(tick.points));
        if (records.value().milled) append(line, tick.line);
        for (const double number : tick.removed_of) append(line, number);
        line += '\n';
        file.write(line);
        return Ok{};
      });
  return done ? file.commit() : done;
}

namespace {

Json json_of(const Vec3& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }
Json json_of(const Pose& pose) {
  const std::array<double, 7> q = numbers_of(pose);
  return {{"position", {{"x", q[0]}, {"y", q[1]}, {"z", q[2]}}},
          {"orientation", {{"x", q[3]}, {"y", q[4]}, {"z", q[5]}, {"w", q[6]}}}};
}
Json json_of(const Wrench& wrench) {
  return {{"force", json_of(wrench.force)}, {"moment", json_of(wrench.moment)}};
}

// JSON Schema of a tick, and of a step's beginning.
const char* const kTickSchema = R"({"type":"object","properties":{
"step":{"type":"integer"},"time_s":{"type":"number"},"hand":{"type":"integer"},"mode":{"type":"string"},
"tool":{"type":"object","description":"mm"},"hand_pose":{"type":"object","description":"mm"},
"computed":{"type":"object","description":"force [N], moment [N mm]"},
"given":{"type":["object","null"],"description":"force [N], moment [N mm], where it was kept"},
"removed_mm3":{"type":"number"},"points":{"type":"integer"},
"line":{"type":"integer","description":"of the milling program"},
"removed_of_mm3":{"type":"object","description":"by material"}}})";
const char* const kEventSchema =
    R"({"type":"object","properties":{"event":{"type":"string"},"step":{"type":"integer"}}})";

}  // namespace

Status write_ticks_mcap(const std::filesystem::path& path, const Document& document, StepId to) {
  const Result<TickRecords> records = about_ticks(document, to);
  if (!records) return Error{records.error()};
  McapWriter writer(path, "kibori");
  const uint16_t ticks = writer.add_channel("/kibori/tick", "kibori.Tick", kTickSchema),
                 events = writer.add_channel("/kibori/event", "kibori.Event", kEventSchema);
  writer.add_metadata("kibori", {{"recording", records.value().about}});
  StepId last = 0;
  const Status done =
      for_tick_records(document, to, records.value(), [&](const TickRecord& tick) -> Status {
        const auto time_ns = static_cast<uint64_t>(std::llround(1e9 * tick.time_s));
        if (std::exchange(last, tick.step) != tick.step)
          writer.write(events, time_ns, Json{{"event", "stroke"}, {"step", tick.step}}.dump());
        Json json{{"step", tick.step},
                  {"time_s", tick.time_s},
                  {"hand", tick.hand},
                  {"mode", name_of(tick.mode)},
                  {"tool", json_of(tick.tool)},
                  {"hand_pose", json_of(tick.hand_pose)},
                  {"computed", json_of(tick.computed)},
                  {"given", nullptr},
                  {"removed_mm3", tick.removed_mm3},
                  {"points", tick.points},
                  {"removed_of_mm3", Json::object()}};
        if (tick.line > 0) json["line"] = tick.line;
        if (tick.given.force.allFinite()) json["given"] = json_of(tick.given);
        for (size_t i = 0; i < tick.removed_of.size(); i++)
          json["removed_of_mm3"][records.value().materials[i]] = tick.removed_of[i];
        writer.write(ticks, time_ns, json.dump(-1, ' ', false, Json::error_handler_t::replace));
        return Ok{};
      });
  return done ? writer.commit() : done;
}

namespace {

// A growing data set with rows of `width` numbers. With rank 1, it has one number per row and no
// second dimension.
class Column {
 public:
  Column(hid_t group, const char* name, hsize_t width, hid_t type, int rank)
      : width_(width), rank_(rank) {
    const hsize_t dims[] = {0, width}, max_dims[] = {H5S_UNLIMITED, width},
                  chunk[] = {kRowsAtOnce, width};
    const hid_t space = H5Screate_simple(rank, dims, max_dims), how = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(how, rank, chunk);
    H5Pset_deflate(how, 4);
    set_ = H5Dcreate2(group, name, type, space, H5P_DEFAULT, how, H5P_DEFAULT);
    H5Pclose(how);
    H5Sclose(space);
  }
  Column(const Column&) = delete;
  Column& operator=(const Column&) = delete;
  ~Column() {
    if (set_ >= 0) H5Dclose(set_);
  }
  template <class Numbers>
  void add(const Numbers& numbers) {
    waiting_.insert(waiting_.end(), std::begin(numbers), std::end(numbers));
    if (waiting_.size() >= kRowsAtOnce * width_) flush();
  }
  // Returns true if all rows are written.
  bool flush() {
    if (set_ < 0) return false;
    if (waiting_.empty()) return good_;
    const hsize_t rows = waiting_.size() / width_, all[] = {rows_ + rows, width_},
                  from[] = {rows_, 0}, block[] = {rows, width_};
    good_ &= H5Dset_extent(set_, all) >= 0;
    const hid_t space = H5Dget_space(set_), memory = H5Screate_simple(rank_, block, nullptr);
    good_ &= H5Sselect_hyperslab(space, H5S_SELECT_SET, from, nullptr, block, nullptr) >= 0 &&
             H5Dwrite(set_, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, waiting_.data()) >= 0;
    H5Sclose(memory);
    H5Sclose(space);
    rows_ += rows;
    waiting_.clear();
    return good_;
  }

 private:
  hid_t set_ = -1;
  hsize_t width_, rows_ = 0;
  int rank_;
  std::vector<double> waiting_;
  bool good_ = true;
};

bool add_attribute(hid_t to, const char* name, const std::string& text) {
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const hid_t attribute = H5Acreate2(to, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  const char* const data = text.c_str();
  const bool written = attribute >= 0 && H5Awrite(attribute, type, &data) >= 0;
  if (attribute >= 0) H5Aclose(attribute);
  H5Sclose(space);
  H5Tclose(type);
  return written;
}

Status fill_hdf5(hid_t file, const Document& document, StepId to, const TickRecords& records,
                 bool& written) {
  // `about` is a data set, because an attribute holds at most 64 kB of text.
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  const hid_t about = H5Dcreate2(file, "about", type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const char* const text = records.about.c_str();
  written = about >= 0 && H5Dwrite(about, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &text) >= 0;
  if (about >= 0) H5Dclose(about);
  H5Sclose(space);
  H5Tclose(type);
  std::string modes, materials;
  for (const std::string_view& mode : names_of(Mode())) {
    if (!modes.empty()) modes += ',';
    modes += mode;
  }
  for (const std::string& material : records.materials) {
    if (!materials.empty()) materials += ',';
    materials += material;
  }
  written = add_attribute(file, "modes", modes) && written;
  written = add_attribute(file, "materials", materials) && written;
  const hid_t ticks = H5Gcreate2(file, "ticks", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  if (ticks < 0) {
    written = false;
    return Ok{};
  }
  Status done = Ok{};
  {
    const auto whole = H5T_STD_I64LE;
    const auto real = H5T_IEEE_F64LE;
    const hsize_t kinds = std::max<size_t>(1, records.materials.size());
    const auto numbers = [&](const char* name, hid_t of) { return Column(ticks, name, 1, of, 1); };
    const auto rows_of = [&](const char* name, hsize_t width) {
      return Column(ticks, name, width, real, 2);
    };
    Column step = numbers("step", whole), time = numbers("time_s", real),
           hand = numbers("hand", whole), mode = numbers("mode", whole),
           tool = rows_of("tool_pose", 7), hand_pose = rows_of("hand_pose", 7),
           force = rows_of("force_N", 3), moment = rows_of("moment_Nmm", 3),
           given_force = rows_of("given_force_N", 3), given_moment = rows_of("given_moment_Nmm", 3),
           removed = numbers("removed_mm3", real), points = numbers("points", whole),
           removed_of = rows_of("removed_of_mm3", kinds);
    std::optional<Column> line;
    if (records.milled) line.emplace(ticks, "line", 1, whole, 1);
    const auto one = [](double number) { return std::array<double, 1>{number}; };
    done = for_tick_records(document, to, records, [&](const TickRecord& tick) -> Status {
      step.add(one(static_cast<double>(tick.step)));
      time.add(one(tick.time_s));
      hand.add(one(tick.hand));
      mode.add(one(static_cast<double>(tick.mode)));
      tool.add(numbers_of(tick.tool));
      hand_pose.add(numbers_of(tick.hand_pose));
      force.add(three(tick.computed.force));
      moment.add(three(tick.computed.moment));
      given_force.add(three(tick.given.force));
      given_moment.add(three(tick.given.moment));
      removed.add(one(tick.removed_mm3));
      points.add(one(static_cast<double>(tick.points)));
      if (line) line->add(one(tick.line));
      removed_of.add(tick.removed_of);
      return Ok{};
    });
    for (Column* column : {&step, &time, &hand, &mode, &tool, &hand_pose, &force, &moment,
                           &given_force, &given_moment, &removed, &points, &removed_of})
      written = column->flush() && written;
    if (line) written = line->flush() && written;
  }
  H5Gclose(ticks);
  return done;
}

}  // namespace

Status write_ticks_hdf5(const std::filesystem::path& path, const Document& document, StepId to) {
  const Result<TickRecords> records = about_ticks(document, to);
  if (!records) return Error{records.error()};
  const Result<std::shared_ptr<TemporaryFolder>> folder = TemporaryFolder::make();
  if (!folder) return Error{folder.error()};
  const std::filesystem::path made = folder.value()->path() / "ticks.h5";
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are reported below
  const hid_t file = H5Fcreate(made.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  bool written = file >= 0;
  Status done = Ok{};
  if (file >= 0) {
    done = fill_hdf5(file, document, to, records.value(), written);
    written = H5Fclose(file) >= 0 && written;
  }
  if (!done) return done;
  if (!written) return Error{path.string() + ": cannot be written to the temporary folder"};
  const Result<std::vector<char>> bytes = read_file(made);
  if (!bytes) return Error{bytes.error()};
  NewFile whole(path);
  whole.write(bytes.value().data(), bytes.value().size());
  return whole.commit();
}

}  // namespace kibori
