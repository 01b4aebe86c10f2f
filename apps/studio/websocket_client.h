// SPDX-License-Identifier: MIT
// One open page: its messages, and the data that it has received. Internal to apps/studio.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/studio/method.h"
#include "apps/studio/print_map.h"
#include "apps/studio/remains_map.h"
#include "apps/studio/server_state.h"

namespace kibori::studio {

class WebSocketClient : public std::enable_shared_from_this<WebSocketClient> {
 public:
  // `admits` returns true if a page with this key may enter.
  WebSocketClient(std::unique_ptr<net::WebSocket> socket, Server::State& server,
                  std::shared_ptr<Guest> guest, std::function<bool(std::string_view key)> admits);
  ~WebSocketClient();

  // Completes the handshake, and reads messages from then on.
  void accept();
  void send(std::vector<uint8_t> message);
  void notify(const std::string& text) { send(encode(Notice{text})); }
  // Forgets what the page has received. Call this when another document is shown, or none.
  void restart();
  // Marks chunks that have changed since the page received them.
  void changed(const std::vector<Session::ChunkPlace>& chunks) {
    dirty_.insert(chunks.begin(), chunks.end());
  }
  void offer_bodies();
  void offer_chunks();
  void offer_history();
  void got(uint32_t frame) {
    if (frame == frame_) got_ = frame;
  }
  // Returns the method view of this page.
  MethodView& method() { return method_; }
  // Show or hide a coloured map on this page: remaining material or print problems.
  void show_remains(bool shown);
  void show_faults(bool shown, const PrintCheckOptions& options);
  // Updates the map for the current bodies.
  void follow_map();
  void offer_method(MethodView::Clock::time_point now);
  size_t waiting_bytes() const { return waiting_bytes_; }
  // Returns the id of this connection. The page sends the id with its HTTP requests, so that the
  // server knows which page sent them. It is not the key with which a page enters.
  const std::string& key() const { return key_; }

 private:
  struct Before {
    bool operator()(const Session::ChunkPlace& a, const Session::ChunkPlace& b) const {
      if (a.body != b.body) return a.body < b.body;
      return std::lexicographical_compare(a.at.data(), a.at.data() + 3, b.at.data(),
                                          b.at.data() + 3);
    }
  };
  void show(BodyId body);
  void repaint();
  double active_volume_mm3() const;
  void forget(BodyId body);
  void read();
  void greet();
  // Closes the connection with a code of RFC 6455. The reason is that the page has no valid key, or
  // that there are too many pages.
  void refuse(uint16_t why);
  void write();
  void drop();
  void leave();

  const std::unique_ptr<net::WebSocket> socket_;
  net::Timer first_;  // runs out if the page does not send Hello
  Server::State& server_;
  const std::string key_;
  std::shared_ptr<Guest> guest_;
  const std::function<bool(std::string_view key)> admits_;
  std::deque<std::vector<uint8_t>> queue_;
  size_t waiting_bytes_ = 0;
  std::set<Session::ChunkPlace, Before> dirty_;
  // The hash of each chunk when it was last sent.
  std::map<Session::ChunkPlace, uint64_t, Before> sent_;
  uint64_t sent_bodies_ = 0;  // the last Session::bodies_revision() that was sent
  std::string sent_list_;
  std::map<BodyId, Pose> shown_bodies_;  // bodies whose chunks the page has or will get
  uint32_t frame_ = 0, got_ = 0;
  bool more_ = false;  // Chunks::more of the last frame
  size_t sent_steps_ = 0;
  Session::Versions sent_versions_;
  MethodView method_;
  enum class Map { none, remains, faults } wants_ = Map::none;
  PrintCheckOptions print_;
  std::unique_ptr<SurfaceMap> map_;
  std::vector<uint8_t> sent_map_;
  bool greeted_ = false, closed_ = false;
};

}  // namespace kibori::studio
