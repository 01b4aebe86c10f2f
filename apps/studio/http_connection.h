// SPDX-License-Identifier: MIT
// One connection, while it asks for files, brings one, or becomes a page's WebSocket. Internal to
// apps/studio.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <kibori/base/file.h>

#include "apps/studio/server_state.h"
#include "apps/studio/session/stock_scene.h"

namespace kibori::studio {

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  HttpConnection(boost::asio::ip::tcp::socket socket, Server::State& server);
  void read();

 private:
  using Status = boost::beast::http::status;
  void answer();
  // The key, for who has the token.
  void let_in();
  // A file to carve, into the temporary folder. A document is opened at once; of anything else the
  // answer says what it seems to be (JSON of import_report.h, and its id), and it waits there.
  void take_import();
  void open_brought();
  bool may_import();
  void look_at_import();
  // Requests on this page's import: preview, drop, make a document.
  void send_preview();
  void drop_import();
  void make_import();
  void make_body(const Import& import, const FileStock& how);
  // null, and answered, where the page or the file is not there.
  const Import* waiting();
  void send_export();
  void send_thumbnail();
  void send_spline();
  void send_file(const std::filesystem::path& path);
  void respond(Status status, std::string body, const char* type = "text/plain; charset=utf-8");
  // `body` lives as long as the program.
  void say_bundled(std::string_view body, const char* type);
  template <class Body>
  void write(boost::beast::http::response<Body>& response);
  void close();
  void drain();

  boost::beast::tcp_stream stream_;
  Server::State& server_;
  std::shared_ptr<Guest> guest_;
  std::shared_ptr<void> room_;  // for what is brought
  boost::beast::flat_buffer buffer_{16384};
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::file_body>> import_;
  std::shared_ptr<TemporaryFolder> folder_;  // of what is brought
  std::string name_;                         // of that file
  std::string target_;
  bool keep_alive_ = false;
  std::string body_;
  boost::beast::http::response<boost::beast::http::span_body<const char>> response_;
  boost::beast::http::response<boost::beast::http::file_body> file_response_;
};

}  // namespace kibori::studio
