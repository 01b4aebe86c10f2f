// SPDX-License-Identifier: MIT
// What --publish asks for: ticks while they are made, over WebSocket (HOST:PORT) and as ROS 2's
// topics over DDS ("dds" or "dds:DOMAIN"):
//
//   /kibori/tool_pose, /kibori/hand_pose           geometry_msgs/PoseStamped [m]
//   /kibori/wrench, /kibori/given_wrench           geometry_msgs/WrenchStamped [N, N m]
//
// of the first hand, in the frame kibori_world.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>

#include <kibori/report/tick_row.h>

namespace kibori {

class Publisher {
 public:
  // Errors: a place that can't be, or is taken.
  static Result<std::unique_ptr<Publisher>> open(const std::vector<std::string>& where);
  ~Publisher();

  // A sentence on where ticks can be read.
  std::string where() const;
  // What ticks are of from now on.
  void about(const Published& published);
  // Neither waits for those who read. Always the same thread.
  void add(const LiveTick& tick);
  // What was added goes out.
  void flush();

 private:
  struct State;
  explicit Publisher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori
