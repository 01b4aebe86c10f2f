// SPDX-License-Identifier: MIT
#include <kibori/run/milling_session.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <kibori/mill/interpreter.h>
#include <kibori/run/milling_run.h>

namespace kibori {
namespace {

// Name of the program that consists of the lines of apply().
constexpr const char* kCommands = "commands";

}  // namespace

struct MillSession::State {
  State(TriDexel& model, const MillOptions& options)
      : controller(options.machine.controller), interpreter(controller), run(model, options) {}

  InterpreterOptions controller;
  Interpreter interpreter;
  MillRun run;
  bool applies = false;  // true: the last program consists of the lines of apply()
  bool moved = false;    // true: run() was called, so the position is known
  size_t warnings = 0;   // number of the interpreter's warnings that the summary already has
};

MillSession::MillSession(TriDexel& model, const MillOptions& options)
    : state_(std::make_unique<State>(model, options)) {}
MillSession::~MillSession() = default;

Result<std::unique_ptr<MillSession>> MillSession::begin(TriDexel& model,
                                                        const MillOptions& options) {
  std::unique_ptr<MillSession> session(new MillSession(model, options));
  if (Status ok = session->state_->run.begin(); !ok) return Error{ok.error()};
  return session;
}

Status MillSession::set_tool(const MillTool& tool) {
  if (tool.number < 1 || tool.number > 99999)
    return Error{"the number of a tool must be 1 to 99999"};
  if (Status ok = check_tool(tool.cutter); !ok) return ok;
  return state_->run.set_tool(tool);
}

// Counts a line. The first line after begin() or run() begins a program.
void MillSession::begin_line() {
  State& s = *state_;
  if (!s.applies) {
    s.run.begin_program(kCommands);
    s.interpreter = Interpreter(s.controller);
    if (s.moved) s.interpreter.set_position(s.run.at());
    s.warnings = 0;
    s.applies = true;
    line_ = 0;
  }
  line_++;
}

Error MillSession::at_line(const std::string& why) const {
  return Error{std::string(kCommands) + ":" + std::to_string(line_) + ": " + why};
}

Status MillSession::apply(std::string_view text, const std::optional<AxisPosition>& from) {
  begin_line();
  const Result<GcodeLine> words = parse_gcode(text);
  return words ? execute(words.value(), from) : Status(at_line(words.error()));
}

Status MillSession::apply(const GcodeLine& line, const std::optional<AxisPosition>& from) {
  begin_line();
  return execute(line, from);
}

Status MillSession::execute(const GcodeLine& line, const std::optional<AxisPosition>& from) {
  State& s = *state_;
  Interpreter next = s.interpreter;
  if (next.ended()) {  // after M2 a new program begins
    next = Interpreter(s.controller);
    next.set_position(s.run.at());
    s.warnings = 0;
  }
  if (from) next.set_position(*from);
  std::vector<CanonMove> moves;
  if (Status ok = next.run(line, line_, moves); !ok) return at_line(ok.error());
  if (from) s.run.put(*from);
  for (const CanonMove& move : moves)
    if (Status ok = s.run.step(move); !ok) {
      s.interpreter.set_position(s.run.at());
      return ok;
    }
  s.interpreter = std::move(next);
  const auto& warnings = s.interpreter.warnings();
  s.run.add_warnings({warnings.begin() + static_cast<std::ptrdiff_t>(s.warnings), warnings.end()});
  s.warnings = warnings.size();
  return Ok{};
}

Status MillSession::run(const std::filesystem::path& program) {
  state_->applies = false;
  state_->moved = true;
  line_ = 0;
  Status done = state_->run.run(program);
  settle();
  return done;
}

const AxisPosition& MillSession::at() const { return state_->run.at(); }
Pose MillSession::pose() const { return state_->run.pose(); }
size_t MillSession::program() const { return state_->run.program(); }
void MillSession::settle() { state_->run.end(false); }
const std::vector<MillCollision>& MillSession::collisions() {
  settle();
  return state_->run.collisions();
}
MillSummary MillSession::summary() {
  settle();
  return state_->run.summary();
}

}  // namespace kibori
