// SPDX-License-Identifier: MIT
// Sends every tick to other programs, for the option --publish. Ticks are sent over WebSocket
// (HOST:PORT), or as topics of ROS 2 over DDS ("dds" or "dds:DOMAIN"):
//
//   /kibori/tool_pose, /kibori/hand_pose           geometry_msgs/PoseStamped [m]
//   /kibori/wrench, /kibori/given_wrench           geometry_msgs/WrenchStamped [N, N m]
//
// The topics have the data of the first hand, in the frame kibori_world.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <kibori/base/result.h>

#include <kibori/report/tick_row.h>

namespace kibori {

class Publisher {
 public:
  // Opens all addresses in `where`. Errors: an address is invalid, or is in use; those of
  // DdsLink::open.
  static Result<std::unique_ptr<Publisher>> open(const std::vector<std::string>& where);
  ~Publisher();

  // Returns a sentence for the user: where the ticks can be read.
  std::string where() const;
  // Sets the description of the next ticks.
  void about(const Published& published);
  // Adds a tick. add() and flush() never wait for readers. Call both on one thread.
  void add(const LiveTick& tick);
  // Sends the added ticks.
  void flush();

 private:
  struct State;
  explicit Publisher(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kibori
