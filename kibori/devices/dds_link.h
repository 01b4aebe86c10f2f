// SPDX-License-Identifier: MIT
// Poses and wrenches over DDS, with the names and layout of ROS 2 (geometry_msgs/PoseStamped,
// WrenchStamped). Needs kibori_dds.so and Fast DDS at run time; open() fails without them.
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

// A connection to a DDS domain. It is closed by the destructor.
class DdsLink {
 public:
  struct Topics {
    std::vector<std::string> poses,
        wrenches;       // topics to write, with ROS 2 names, for example /kibori/tool_pose
    std::string reads;  // topic of poses to read; empty: none
    // Called for each pose [mm] with the sender's time [ns since 1970], on a thread of Fast DDS.
    // Invalid poses are dropped.
    std::function<void(int64_t ns, const Pose& pose)> on_pose;
  };
  // Errors: kibori_dds.so or Fast DDS is missing, or the domain (0 to 232) cannot be joined.
  static Result<std::unique_ptr<DdsLink>> open(uint32_t domain, Topics topics);
  ~DdsLink();

  // Writes a pose [mm] or a wrench [N, N mm] with its time [ns since 1970]. `topic` is the index in
  // `poses` or `wrenches`. Returns false if nothing was sent. Not for the servo thread.
  bool write(size_t topic, const std::string& frame, int64_t ns, const Pose& pose);
  bool write(size_t topic, const std::string& frame, int64_t ns, const Wrench& wrench);

 private:
  struct State;
  explicit DdsLink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// The system clock's time [ns since 1970].
int64_t ns_since_1970();

// Parses "dds" or "dds:DOMAIN". The default domain is the environment variable ROS_DOMAIN_ID, or 0.
// Errors: not a number from 0 to 232.
Result<uint32_t> parse_dds_domain(const std::string& text);

}  // namespace kibori
