// SPDX-License-Identifier: MIT
#include <kibori/devices/dds_link.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include <Eigen/Geometry>
#include <time.h>

#include <kibori/devices/dds_plugin.h>
#include <kibori/devices/shared_library.h>

namespace kibori {
namespace {

constexpr uint32_t kMaxDomain = 232;
constexpr double kFarMm = 1e5;  // a hundred metres

// Paths of the plugin: next to the program (build tree), the install folder, and the loader's
// search path.
std::vector<std::string> plugin_places() {
  if (const char* const named = std::getenv("KIBORI_DDS")) return {named};
  std::vector<std::string> places;
  std::error_code error;
  const auto here = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
  if (!error)
    for (const char* const place : {"kibori_dds.so", "../" KIBORI_LIBDIR "/kibori/kibori_dds.so"})
      places.push_back((here / place).lexically_normal());
  for (const char* const prefix : {"/usr/local/", "/usr/"})
    places.push_back(std::string(prefix) + KIBORI_LIBDIR + "/kibori/kibori_dds.so");
  places.push_back("kibori_dds.so");
  return places;
}

}  // namespace

struct DdsLink::State {
  SharedLibrary library;
  const kibori_dds* functions = nullptr;
  void* link = nullptr;
  Topics topics;

  State() = default;
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (link) functions->close(link);
  }

  void take(int64_t ns, const double pose[7]) const {
    double norm2 = 0;
    for (int i = 0; i < 7; i++) {
      if (!std::isfinite(pose[i])) return;
      if (i >= 3) norm2 += pose[i] * pose[i];
    }
    const Vec3 tip = 1000 * Vec3(pose[0], pose[1], pose[2]);
    if (!(norm2 > 1e-6 && norm2 < 1e6) || !(tip.cwiseAbs().maxCoeff() < kFarMm)) return;
    const Eigen::Quaterniond turn(pose[6], pose[3], pose[4], pose[5]);
    topics.on_pose(ns, {tip, turn.normalized().toRotationMatrix()});
  }
};

DdsLink::DdsLink(std::unique_ptr<State> state) : state_(std::move(state)) {}
DdsLink::~DdsLink() = default;

Result<std::unique_ptr<DdsLink>> DdsLink::open(uint32_t domain, Topics topics) {
  auto state = std::make_unique<State>();
  Result<SharedLibrary> library = SharedLibrary::open(plugin_places());
  if (!library)
    return Error{"DDS: kibori_dds.so " + library.error() +
                 "; install the package kibori-dds, or build Kibori where Fast DDS (Debian: "
                 "libfastrtps-dev) is installed"};
  state->library = std::move(library).value();
  if (!state->library.find(KIBORI_DDS_ENTRY, state->functions))
    return Error{
        "DDS: kibori_dds.so belongs to another version of kibori; install both from one package"};
  state->topics = std::move(topics);
  const auto names = [](const std::vector<std::string>& of) {
    std::vector<const char*> pointers;
    pointers.reserve(of.size());
    for (const std::string& name : of) pointers.push_back(name.c_str());
    return pointers;
  };
  const auto poses = names(state->topics.poses), wrenches = names(state->topics.wrenches);
  char error[200] = "";
  state->link = state->functions->open(
      domain, poses.data(), static_cast<int>(poses.size()), wrenches.data(),
      static_cast<int>(wrenches.size()),
      state->topics.reads.empty() ? nullptr : state->topics.reads.c_str(),
      [](void* user, int64_t ns, const double pose[7]) {
        static_cast<const State*>(user)->take(ns, pose);
      },
      state.get(), error, sizeof error);
  if (!state->link) return Error{"DDS, domain " + std::to_string(domain) + ": " + error};
  return std::unique_ptr<DdsLink>(new DdsLink(std::move(state)));
}

bool DdsLink::write(size_t topic, const std::string& frame, int64_t ns, const Pose& pose) {
  const Eigen::Quaterniond turn(pose.frame);
  const double values[7] = {pose.tip.x() / 1000,
                            pose.tip.y() / 1000,
                            pose.tip.z() / 1000,
                            turn.x(),
                            turn.y(),
                            turn.z(),
                            turn.w()};
  return state_->functions->write_pose(state_->link, static_cast<int>(topic), ns, frame.c_str(),
                                       values) != 0;
}

bool DdsLink::write(size_t topic, const std::string& frame, int64_t ns, const Wrench& wrench) {
  double values[6];
  for (int i = 0; i < 3; i++) {
    values[i] = wrench.force[i];
    values[3 + i] = wrench.moment[i] / 1000;
  }
  return state_->functions->write_wrench(state_->link, static_cast<int>(topic), ns, frame.c_str(),
                                         values) != 0;
}

int64_t ns_since_1970() {
  timespec t;
  clock_gettime(CLOCK_REALTIME, &t);
  return t.tv_sec * int64_t{1000000000} + t.tv_nsec;
}

Result<uint32_t> parse_dds_domain(const std::string& text) {
  const char* const set = std::getenv("ROS_DOMAIN_ID");
  std::string domain_text =
      text == "dds" ? (set ? set : "0") : text.substr(std::min<size_t>(4, text.size()));
  uint32_t domain = 0;
  const auto [end, failed] =
      std::from_chars(domain_text.data(), domain_text.data() + domain_text.size(), domain);
  if (domain_text.empty() || failed != std::errc() ||
      end != domain_text.data() + domain_text.size() || domain > kMaxDomain)
    return Error{"'" + domain_text + "' is not a DDS domain; use a number from 0 to " +
                 std::to_string(kMaxDomain)};
  return domain;
}

}  // namespace kibori
