// SPDX-License-Identifier: MIT
// Sends each tick to other programs, for the option --publish. Ticks go over WebSocket (HOST:PORT)
// or as topics of ROS 2 over DDS ("dds" or "dds:DOMAIN"):
//
//   /kibori/tool_pose, /kibori/hand_pose           geometry_msgs/PoseStamped [m]
//   /kibori/wrench, /kibori/given_wrench           geometry_msgs/WrenchStamped [N, N m]
//
// The topics describe the first hand, in the frame kibori_world.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>

#include <kibori/report/tick_row.h>

namespace kibori {

class Publisher {
 public:
  // Errors: an invalid address, one that is in use, or those of DdsLink::open.
  static Result<std::unique_ptr<Publisher>> open(const std::vector<std::string>& where);
  ~Publisher();

  // A sentence that says where to read the ticks.
  std::string where() const;
  // Sets the description of the following ticks.
  void about(const Published& published);
  // add() and flush() never wait for readers. Call both on one thread.
  void add(const LiveTick& tick);
  // Sends the added ticks.
  void flush();

 private:
  struct State;
  explicit Publisher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori
