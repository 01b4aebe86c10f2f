// SPDX-License-Identifier: MIT
// Pairs devices of the network with the studio. The terminal shows a code. The first device that
// sends this code gets a session: a secret that it keeps in a cookie. Internal to apps/studio.
//
// A code has 6 characters from an alphabet of 32, so there are 10^9 codes. After 5 wrong codes, the
// code is void, and no device can pair for a minute. A device that guesses without pause needs 400
// years on average. So an attacker in the network can delay a pairing, but cannot pair.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace kibori::studio {

class Pairing {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr auto kCodeTime = std::chrono::minutes(5);
  static constexpr int kWrongCodes = 5;
  static constexpr auto kWait = std::chrono::seconds(60);

  enum class Outcome {
    paired,
    wrong,
    expired,  // there was no valid code
    wait,     // there were too many wrong codes
  };
  struct Answer {
    Outcome outcome;
    std::string session;           // set if paired
    std::chrono::seconds wait{0};  // set if the device must wait
  };

  // Makes a code and passes it to `on_code`. Does nothing if there is a valid code, or if devices
  // must wait.
  void offer(Clock::time_point now);
  // Checks a code. Upper and lower case, spaces and hyphens make no difference. If there is no
  // valid code, offers one.
  Answer enter(std::string_view code, Clock::time_point now);
  // Returns true if a device has this session. All sessions end with the studio.
  bool is_session(std::string_view session) const;

  std::function<void(const std::string& code)> on_code;

 private:
  bool valid(Clock::time_point now) const { return !code_.empty() && now < ends_; }

  std::string code_;
  Clock::time_point ends_, free_at_{};
  int wrong_ = 0;
  std::vector<std::string> sessions_;
};

}  // namespace kibori::studio
