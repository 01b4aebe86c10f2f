// SPDX-License-Identifier: MIT
// Child processes and their limits, with scripts in place of LinuxCNC's rs274.
// tests/test_mill_cli.py tests the same through the command line.
#include <kibori/mill/rs274.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <kibori/base/child.h>
#include <kibori/base/file.h>

namespace kibori::rs274_tests {
namespace {

class Rs274 : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = TemporaryFolder::make().value();
    const char* const path = std::getenv("PATH");
    path_ = path ? path : "";
    setenv("PATH", (folder_->path().string() + ":/usr/bin:/bin").c_str(), 1);
  }
  void TearDown() override { setenv("PATH", path_.c_str(), 1); }

  // A script with this name in PATH.
  std::filesystem::path script(const std::string& name, const std::string& text) const {
    const auto file = folder_->path() / name;
    std::ofstream(file) << "#!/bin/sh\n" << text << "\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file;
  }
  std::filesystem::path program(const std::string& text) const {
    const auto file = folder_->path() / "p.ngc";
    std::ofstream(file) << text;
    return file;
  }
  // The error of a program that needs rs274.
  std::string error(const std::string& rs274, const Rs274Limits& limits = {}) const {
    script("rs274", rs274);
    const auto opened = open_program(program("G21\n#1=2\nG1 X#1 F100\n"), {}, {}, limits);
    return opened ? "" : opened.error();
  }
  static bool no_child_left() { return waitpid(-1, nullptr, WNOHANG) < 0; }

  std::shared_ptr<TemporaryFolder> folder_;
  std::string path_;
};

TEST_F(Rs274, ChildOutputAndStatus) {
  const auto file = script("child", "cat; pwd; echo \"$1|$2\"; echo wrong >&2; exit 7");
  std::string text;
  ChildOptions options;
  options.folder = folder_->path();
  options.output = [&](std::string_view more) {
    text += more;
    return Status(Ok{});
  };
  const auto ended = run_child(file, {"a b", "$(id);*"}, options);
  ASSERT_TRUE(ended) << ended.error();
  EXPECT_EQ(ended.value().kind, ChildEnd::Kind::exited);
  EXPECT_EQ(ended.value().code, 7);
  EXPECT_EQ(text, std::filesystem::canonical(folder_->path()).string() + "\na b|$(id);*\n");
  EXPECT_EQ(ended.value().errors, "wrong\n");
  EXPECT_FALSE(run_child(folder_->path() / "missing", {}, options));
  options.output = [](std::string_view) { return Status(Error{"full"}); };
  EXPECT_EQ(run_child(script("talks", "exec yes"), {}, options).error(), "full");
  EXPECT_TRUE(no_child_left());
}

TEST_F(Rs274, ChildLimits) {
  ChildOptions options;
  options.max_seconds = 0.3;
  options.max_output = 1 << 20;
  const auto kind = [&](const std::string& text) {
    return run_child(script("child", text), {}, options).value().kind;
  };
  using Kind = ChildEnd::Kind;
  EXPECT_EQ(kind("exec sleep 1000"), Kind::too_slow);
  EXPECT_EQ(kind("sleep 1000 & sleep 1000"), Kind::too_slow);
  EXPECT_EQ(kind("trap '' TERM INT; while :; do :; done"), Kind::too_slow);
  EXPECT_EQ(kind("exec >&- 2>&-; exec sleep 1000"), Kind::too_slow);
  options.max_seconds = 60;
  EXPECT_EQ(kind("exec yes"), Kind::too_much);
  EXPECT_EQ(kind("kill -SEGV $$"), Kind::crashed);
  EXPECT_EQ(kind("kill -KILL $$"), Kind::crashed);
  // Much on standard error neither fills memory nor blocks the child.
  const auto loud = run_child(script("child", "yes | head -c 3000000 >&2; exit 1"), {}, options);
  EXPECT_EQ(loud.value().errors.size(), 4096u);
  EXPECT_EQ(loud.value().code, 1);
  EXPECT_TRUE(no_child_left());
}

TEST_F(Rs274, ChildEndsWithItsCaller) {
  // A process that starts a child and is killed. The child would run for a long time.
  const auto mark = folder_->path() / "pid";
  const auto file = script("child", "echo $$ > '" + mark.string() + "'; exec sleep 1000");
  const pid_t caller = fork();
  if (caller == 0) {
    static_cast<void>(run_child(file, {}, {}));
    _exit(0);
  }
  pid_t child = 0;
  while (!(std::ifstream(mark) >> child)) std::this_thread::yield();
  kill(caller, SIGKILL);
  waitpid(caller, nullptr, 0);
  // An ended child is gone, or is a zombie until its parent collects its status.
  const auto ended = [&] {
    std::ifstream stat("/proc/" + std::to_string(child) + "/stat");
    std::string number, name, state;
    return !(stat >> number >> name >> state) || state == "Z" || state == "X";
  };
  while (!ended()) std::this_thread::yield();
}

TEST_F(Rs274, ErrorsAreOneSentence) {
  const std::string name = (folder_->path() / "p.ngc").string();
  EXPECT_EQ(error("echo executing >&2; echo 'Bad thing' >&2; echo 'N3 G1 X[1' >&2; exit 1"),
            name + ":3: LinuxCNC's rs274 refuses it: Bad thing");
  EXPECT_EQ(error("echo 'Unable to open file <x.ngc>' >&2; echo 'o<x> call' >&2; exit 1"),
            name + ": LinuxCNC's rs274 refuses it: Unable to open file <x.ngc>: o<x> call");
  EXPECT_NE(error("exit 3").find("ends with status 3"), std::string::npos);
  EXPECT_NE(error("kill -SEGV $$").find("signal 11"), std::string::npos);
  EXPECT_NE(error("exec sleep 1000", {0.2, 1 << 20}).find("loop that does not end"),
            std::string::npos);
  EXPECT_NE(error("exec yes", {60, 1 << 20}).find("more than 1 MB"), std::string::npos);
}

TEST_F(Rs274, OnlyProgramsThatNeedIt) {
  script("rs274", "exit 1");
  for (const char* text : {"G21 G1 X1 F100\n", "", "(#1 [2] o100)\nG0 X1\n", "G1 X1 X2\n",
                           "    1 N1  STRAIGHT_FEED(1.0, 2.0, 0, 0, 0, 0)\n"})
    EXPECT_TRUE(open_program(program(text), {}, {})) << text;
  for (const char* text : {"#1=2\n", "G0 X[1+2]\n", "o100 sub\n", "G41 D1\n", "M73\n", "G76\n"})
    EXPECT_FALSE(open_program(program(text), {}, {})) << text;
  std::filesystem::remove(folder_->path() / "rs274");
  setenv("PATH", folder_->path().c_str(), 1);
  const auto opened = open_program(program("G21\n#1=2\n"), {}, {});
  ASSERT_TRUE(opened) << opened.error();
  std::vector<CanonMove> moves;
  const auto next = opened.value()->next(moves);
  ASSERT_FALSE(next);
  EXPECT_NE(next.error().find("p.ngc:2: a parameter (#)"), std::string::npos);
  EXPECT_NE(next.error().find("linuxcnc-uspace"), std::string::npos);
}

TEST_F(Rs274, MovesHaveTheLinesOfTheProgram) {
  script("rs274", "cp program.ngc tool.tbl rs274ngc.var \"" + folder_->path().string() +
                      "\"\ncat <<'END'\n    1 N..... USE_LENGTH_UNITS(CANON_UNITS_MM)\n"
                      "    2 N3     STRAIGHT_TRAVERSE(1.0, 0.0, 0.0, 0.0, 0.0, 0.0)\n"
                      "    3 N..... STRAIGHT_FEED(2.0, 0.0, 0.0, 0.0, 0.0, 0.0)\n"
                      "    4 N12    STRAIGHT_FEED(3.0, 0.0, 0.0, 0.0, 0.0, 0.0)\n    5 N13    "
                      "PROGRAM_END()\nEND");
  MillTool tool;
  tool.number = 4;
  tool.cutter = Flat{12.7, 20};
  InterpreterOptions controller;
  controller.machine_zero = AxisPosition{Vec3(0, 0, 25.4), Vec3::Zero()};
  controller.work_offsets[1].xyz_mm = Vec3(254, 0, 0);
  auto opened =
      open_program(program("%\nN7 G21\no1 sub\r\n/ G1 X#1\n\nN010G0X[1]\n"), controller, {tool});
  ASSERT_TRUE(opened) << opened.error();
  std::vector<CanonMove> moves;
  while (opened.value()->next(moves).value()) continue;
  std::vector<int> lines;
  for (const CanonMove& move : moves) lines.push_back(move.line);
  EXPECT_EQ(lines, (std::vector<int>{3, 3, 12, 13}));
  const auto text = [&](const char* name) {
    const auto bytes = read_file(folder_->path() / name).value();
    return std::string(bytes.begin(), bytes.end());
  };
  EXPECT_EQ(text("program.ngc"), "%\nN2 G21\no1 sub\n/N4 G1 X#1\n\nN6 G0X[1]\nM2\n");
  EXPECT_EQ(text("tool.tbl"), "T4 P1 D1.000000000 Z0 ;\n");
  EXPECT_NE(text("rs274ngc.var").find("5223 -1.000000000\n"), std::string::npos);
  EXPECT_NE(text("rs274ngc.var").find("5241 10.000000000\n"), std::string::npos);
}

TEST(Rs274Lines, Numbers) {
  EXPECT_EQ(with_line_number("G1 X1", 5), "N5 G1 X1");
  EXPECT_EQ(with_line_number("  n 1 2 G1", 5), "N5 G1");
  EXPECT_EQ(with_line_number("/N3 G1", 5), "/N5 G1");
  EXPECT_EQ(with_line_number("(LOGOPEN,/etc/passwd)", 5), "");
  EXPECT_EQ(with_line_number("G1 (a;b) X1 ;(py,x)", 5), "N5 G1  X1 ");
  EXPECT_EQ(with_line_number("o1 call (LOG,x)", 5), "o1 call ");
  EXPECT_EQ(with_line_number("G1 (no end", 5), "N5 G1 (no end");
  for (const char* line : {"", "  ", "%", "o<a> call", " O12 if [1]", "N7"})
    EXPECT_EQ(with_line_number(line, 5), line);
  const std::string longest(253, 'x');
  EXPECT_EQ(with_line_number(longest, 5), longest);
}

}  // namespace
}  // namespace kibori::rs274_tests
