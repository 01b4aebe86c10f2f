// SPDX-License-Identifier: MIT
// Poses and wrenches over DDS, named and laid out as ROS 2 does (geometry_msgs/PoseStamped,
// WrenchStamped), through kibori_dds.so and Fast DDS, where they are installed.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>
#include <kibori/geometry/vec.h>
#include <kibori/haptics/force.h>

namespace kibori {

class DdsLink {
 public:
  struct Topics {
    std::vector<std::string> poses,
        wrenches;       // that are written, as ROS 2 calls them: /kibori/tool
    std::string reads;  // poses; empty: none
    // Each pose that comes [mm], and when it was so as its sender says [ns since 1970], on a thread
    // of Fast DDS. Poses that are none are left out.
    std::function<void(int64_t ns, const Pose& pose)> on_pose;
  };
  // Errors: kibori_dds.so or Fast DDS is not there, or the domain (0 to 232) can't be joined.
  static Result<std::unique_ptr<DdsLink>> open(uint32_t domain, Topics topics);
  ~DdsLink();

  // By the place of the topic in `poses` or `wrenches`; when it was so [ns since 1970], mm, N, N
  // mm. Not for the servo path. false: it did not go out.
  bool write(size_t topic, const std::string& frame, int64_t ns, const Pose& pose);
  bool write(size_t topic, const std::string& frame, int64_t ns, const Wrench& wrench);

 private:
  struct State;
  explicit DdsLink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

int64_t ns_since_1970();

// The domain of "dds" or "dds:DOMAIN": ROS_DOMAIN_ID, or 0, where none is said. Errors: it is no
// number from 0 to 232.
Result<uint32_t> parse_dds_domain(const std::string& text);

}  // namespace kibori
