// SPDX-License-Identifier: MIT
#include "apps/publish/publisher.h"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include <kibori/devices/dds_link.h>

#include "apps/publish/tick_server.h"

namespace kibori {
namespace {

constexpr size_t kWaitingTicks = 8192;  // queue limit for DDS; further ticks are dropped

// Writes topics on its own thread. Each topic takes Fast DDS about 10 us.
class TopicWriter {
 public:
  explicit TopicWriter(std::unique_ptr<DdsLink> link)
      : link_(std::move(link)), thread_([this] { run(); }) {}
  ~TopicWriter() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }
  TopicWriter(const TopicWriter&) = delete;
  TopicWriter& operator=(const TopicWriter&) = delete;

  void add(const std::vector<LiveTick>& ticks) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      for (const LiveTick& tick : ticks)
        if (waiting_.size() < kWaitingTicks) waiting_.push_back(tick);
    }
    changed_.notify_one();
  }

 private:
  void run() {
    std::deque<LiveTick> now;
    for (;;) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [&] { return stopping_ || !waiting_.empty(); });
        if (waiting_.empty()) return;
        now.swap(waiting_);
      }
      for (const LiveTick& tick : now) {
        const std::string frame = "kibori_world";
        const auto since_ns = static_cast<int64_t>(1e9 * tick.time_s);
        // Each tick gives an estimate of the servo's start time. Ticks that are written late give a
        // late estimate, so take the earliest. If the tick numbers begin again, another servo has
        // started.
        const int64_t begun_ns = ns_since_1970() - since_ns;
        if (begun_ns_ == 0 || tick.number < last_ || begun_ns < begun_ns_) begun_ns_ = begun_ns;
        last_ = tick.number;
        const int64_t ns = begun_ns_ + since_ns;
        link_->write(0, frame, ns, tick.tool);
        link_->write(1, frame, ns, tick.hand);
        link_->write(0, frame, ns,
                     Wrench{tick.computed.force / tick.force_scale,
                            tick.computed.moment / tick.force_scale});
        link_->write(1, frame, ns, tick.given);
      }
      now.clear();
    }
  }

  std::unique_ptr<DdsLink> link_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<LiveTick> waiting_;
  bool stopping_ = false;
  int64_t begun_ns_ = 0;  // estimated start of the servo [ns since 1970]; owned by thread_
  uint64_t last_ = 0;
  std::thread thread_;
};

}  // namespace

struct Publisher::State {
  std::vector<std::unique_ptr<TickServer>> servers;
  std::vector<std::unique_ptr<TopicWriter>> topics;
  std::string where;
  std::vector<TickRow> rows;
  std::vector<LiveTick> ticks;  // for `topics`, until flush()
};

Publisher::Publisher(std::unique_ptr<State> state) : state_(std::move(state)) {}
Publisher::~Publisher() { flush(); }

Result<std::unique_ptr<Publisher>> Publisher::open(const std::vector<std::string>& where) {
  auto state = std::make_unique<State>();
  for (const std::string& place : where) {
    std::string target_text;
    if (place == "dds" || place.starts_with("dds:")) {
      const Result<uint32_t> domain = parse_dds_domain(place);
      if (!domain) return Error{domain.error()};
      Result<std::unique_ptr<DdsLink>> link =
          DdsLink::open(domain.value(), {{"/kibori/tool_pose", "/kibori/hand_pose"},
                                         {"/kibori/wrench", "/kibori/given_wrench"},
                                         {},
                                         {}});
      if (!link) return Error{link.error()};
      state->topics.push_back(std::make_unique<TopicWriter>(std::move(link).value()));
      target_text = "DDS topics /kibori/..., domain " + std::to_string(domain.value());
    } else {
      Result<std::unique_ptr<TickServer>> server = TickServer::listen(place);
      if (!server) return Error{server.error()};
      target_text = "ws://" + server.value()->address();
      state->servers.push_back(std::move(server).value());
    }
    state->where += (state->where.empty() ? "" : " and ") + target_text;
  }
  return std::unique_ptr<Publisher>(new Publisher(std::move(state)));
}

std::string Publisher::where() const { return "Ticks are published at " + state_->where; }

void Publisher::about(const Published& published) {
  flush();
  for (const auto& server : state_->servers) server->about(about_rows(published));
}

void Publisher::add(const LiveTick& tick) {
  if (!state_->servers.empty()) append_rows(tick, state_->rows);
  if (!state_->topics.empty()) state_->ticks.push_back(tick);
}

void Publisher::flush() {
  for (const auto& server : state_->servers) server->publish(state_->rows);
  if (!state_->ticks.empty())
    for (const auto& topics : state_->topics) topics->add(state_->ticks);
  state_->rows.clear();
  state_->ticks.clear();
}

}  // namespace kibori
