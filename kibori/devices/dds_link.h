// SPDX-License-Identifier: MIT
// Sends and receives poses and wrenches over DDS. The names and the layout of messages are those of
// ROS 2 (geometry_msgs/PoseStamped, WrenchStamped). open() needs kibori_dds.so and Fast DDS.
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

// A connection to a DDS domain. The destructor closes it.
class DdsLink {
 public:
  struct Topics {
    std::vector<std::string> poses,
        wrenches;       // topics to write, with ROS 2 names (/kibori/tool_pose)
    std::string reads;  // topic of the poses to read; empty: none
    // Called for new poses [mm] with the sender's time [ns since 1970], on a thread of Fast DDS. If
    // several poses are waiting, only the newest counts. Invalid poses are dropped.
    std::function<void(int64_t ns, const Pose& pose)> on_pose;
  };
  // Joins a domain (0 to 232). Errors: kibori_dds.so or Fast DDS is missing; kibori_dds.so is of
  // another version; Fast DDS cannot join the domain or create a reader or writer.
  static Result<std::unique_ptr<DdsLink>> open(uint32_t domain, Topics topics);
  ~DdsLink();

  // Write a pose [mm] or a wrench [N, N mm] with its time [ns since 1970]. `topic` is an index of
  // Topics::poses or Topics::wrenches. `frame` is the name of the coordinate frame. Return false if
  // nothing was sent. Not for the servo thread.
  bool write(size_t topic, const std::string& frame, int64_t ns, const Pose& pose);
  bool write(size_t topic, const std::string& frame, int64_t ns, const Wrench& wrench);

 private:
  struct State;
  explicit DdsLink(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

// Returns the time of the system clock [ns since 1970].
int64_t ns_since_1970();

// Parses "dds" or "dds:DOMAIN". Without DOMAIN, returns the value of the environment variable
// ROS_DOMAIN_ID, or 0. Errors: the domain is not a number from 0 to 232.
Result<uint32_t> parse_dds_domain(const std::string& text);

}  // namespace kibori
