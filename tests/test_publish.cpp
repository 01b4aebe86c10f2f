// SPDX-License-Identifier: MIT
// Published ticks: a reader that does not read loses ticks, and their numbers show it. No other
// reader loses any. tests/test_publish.py tests the rest with separate programs.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <thread>

#include <nlohmann/json.hpp>

#include <kibori/net/web.h>

#include "apps/publish/publisher.h"
#include "apps/publish/tick_server.h"

namespace kibori::publish_tests {
namespace {

class Reader {
 public:
  explicit Reader(const std::string& address) {
    const size_t colon = address.rfind(':');
    Status step = client_.resolve(address.substr(0, colon), address.substr(colon + 1));
    if (step) step = client_.connect();
    if (step) step = client_.handshake();
    EXPECT_TRUE(step.ok()) << step.error();
  }
  // Its kind, then its bytes. Throws if the connection has ended.
  std::vector<uint8_t> message() {
    const Result<std::string> received = client_.receive();
    if (!received) throw std::runtime_error(received.error());
    return {received.value().begin(), received.value().end()};
  }
  // Numbers of the rows of the next message of ticks.
  std::vector<uint64_t> numbers() {
    std::vector<uint8_t> bytes;
    do bytes = message();
    while (bytes.at(0) != 97);
    std::vector<uint64_t> numbers((bytes.size() - 5) / sizeof(TickRow));
    EXPECT_EQ(bytes.size(), 5 + numbers.size() * sizeof(TickRow));
    for (size_t i = 0; i < numbers.size(); i++)
      std::memcpy(&numbers[i], bytes.data() + 5 + i * sizeof(TickRow), sizeof numbers[i]);
    return numbers;
  }

 private:
  net::WebSocketClient client_{std::chrono::minutes(2), 0};
};

std::unique_ptr<TickServer> server() {
  Result<std::unique_ptr<TickServer>> made = TickServer::listen("127.0.0.1:0");
  EXPECT_TRUE(made.ok()) << made.error();
  made.value()->about(about_rows({"a.kibori", "a hand", 1000, {}, {}}));
  return std::move(made).value();
}

TEST(Publish, ColumnsAreARow) {
  const auto columns = nlohmann::json::parse(about_rows({"a", "b", 1000, {}, {}})).at("columns");
  std::vector<bool> taken(sizeof(TickRow));
  for (const auto& column : columns) {
    const std::string type = column.at("type");
    const size_t each = type == "u8" ? 1 : 8, from = column.at("offset"),
                 to = from + each * column.at("count").get<size_t>();
    EXPECT_EQ(from % each, 0u);
    ASSERT_LE(to, taken.size());
    for (size_t i = from; i < to; i++) {
      EXPECT_FALSE(taken[i]) << column;
      taken[i] = true;
    }
  }
  EXPECT_EQ(std::count(taken.begin(), taken.end(), false), 0);
}

TEST(Publish, RepeatsItsDescription) {
  const auto publishing = server();
  Reader reader(publishing->address());
  std::vector<uint8_t> about = reader.message();
  EXPECT_EQ(about.at(0), 96);
  EXPECT_NE(std::string(about.begin(), about.end()).find("a.kibori"), std::string::npos);
  std::vector<TickRow> rows(3);
  for (size_t i = 0; i < rows.size(); i++) rows[i].tick = i;
  publishing->publish(rows);
  publishing->publish({});
  publishing->about(about_rows({"b.kibori", "a hand", 1000, {}, {}}));
  publishing->publish(rows);
  EXPECT_EQ(reader.numbers(), (std::vector<uint64_t>{0, 1, 2}));
  about = reader.message();
  EXPECT_EQ(about.at(0), 96);
  EXPECT_NE(std::string(about.begin(), about.end()).find("b.kibori"), std::string::npos);
  EXPECT_EQ(reader.numbers(), (std::vector<uint64_t>{0, 1, 2}));
}

TEST(Publish, AReaderThatPausesLosesOnlyTicksAndIsNotified) {
  const auto publishing = server();
  Reader slow(publishing->address()), quick(publishing->address());
  constexpr size_t kMessages = 600, kRows = 1000;  // 150 MB
  EXPECT_EQ(quick.message().at(0), 96);
  uint64_t expected = 0;
  std::vector<TickRow> rows(kRows);
  for (size_t m = 0; m < kMessages; m++) {
    for (size_t i = 0; i < kRows; i++) rows[i].tick = m * kRows + i;
    publishing->publish(rows);
    for (const uint64_t number : quick.numbers()) ASSERT_EQ(number, expected++);
  }
  EXPECT_EQ(expected, kMessages * kRows);
  // The slow reader gets the messages that were queued for it, in order, and then new ones. It may
  // also lose new ones. So the server publishes until the slow reader has received one.
  uint64_t last = 0, gaps = 0, received = 0;
  bool first = true;
  std::jthread more([&](const std::stop_token& stop) {
    for (size_t m = kMessages; !stop.stop_requested(); m++) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      for (size_t i = 0; i < kRows; i++) rows[i].tick = m * kRows + i;
      publishing->publish(rows);
    }
  });
  while (last < kMessages * kRows)
    for (const uint64_t number : slow.numbers()) {
      ASSERT_TRUE(first || number > last);
      if (first) {
        EXPECT_EQ(number, 0u);
      }
      gaps += !first && number > last + 1;
      last = number;
      first = false;
      received++;
    }
  EXPECT_GE(gaps, 1u);
  EXPECT_LT(received, last);
}

TEST(Publish, AtItsEndAllIsRead) {
  for (int round = 0; round < 20; round++) {
    auto publishing = server();
    Reader reader(publishing->address());
    EXPECT_EQ(reader.message().at(0), 96);
    std::vector<TickRow> rows(2000);
    for (int i = 0; i < 4; i++) publishing->publish(rows);
    const std::jthread end([&] { publishing.reset(); });
    size_t received = 0;
    EXPECT_THROW(for (;;) received += reader.numbers().size(), std::runtime_error);
    EXPECT_EQ(received, 8000u);
  }
  // A reader that never reads does not block the shutdown.
  auto publishing = server();
  Reader reader(publishing->address());
  EXPECT_EQ(reader.message().at(0), 96);
  std::vector<TickRow> rows(4000);
  for (int i = 0; i < 20; i++) publishing->publish(rows);
  publishing.reset();
}

TEST(Publish, ReadersConnectAndDisconnect) {
  const auto publishing = server();
  std::vector<TickRow> rows(10);
  for (int round = 0; round < 50; round++) {
    Reader one(publishing->address());
    auto two = std::make_unique<Reader>(publishing->address());
    EXPECT_EQ(one.message().at(0), 96);
    EXPECT_EQ(two->message().at(0), 96);
    publishing->publish(rows);
    if (round % 2) two.reset();
    publishing->publish(rows);
    EXPECT_EQ(one.numbers().size(), 10u);
    EXPECT_EQ(one.numbers().size(), 10u);
  }
}

TEST(Publish, TheSecondHandHasARowOfItsOwn) {
  LiveTick tick;
  tick.number = 7;
  tick.removed_mm3 = 2;
  tick.computed.force = Vec3(1, 2, 3);
  tick.force_scale = 0.5;
  tick.second.emplace();
  tick.second->removed_mm3 = 3;
  tick.second->tool.tip = Vec3(4, 5, 6);
  std::vector<TickRow> rows;
  append_rows(tick, rows);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].hand, 1);
  EXPECT_EQ(rows[1].hand, 2);
  EXPECT_EQ(rows[0].tick, 7u);
  EXPECT_EQ(rows[1].tick, 7u);
  EXPECT_EQ(rows[0].force_n, (std::array<double, 3>{2, 4, 6}));  // on the tool
  EXPECT_EQ(rows[1].removed_mm3, 3);
  EXPECT_EQ(rows[1].tool_pose, (std::array<double, 7>{4, 5, 6, 0, 0, 0, 1}));
}

}  // namespace
}  // namespace kibori::publish_tests
