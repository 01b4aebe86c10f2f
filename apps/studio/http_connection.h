// SPDX-License-Identifier: MIT
// HTTP connections. Each one requests files, uploads one, or becomes a page's WebSocket. Internal
// to apps/studio.
#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "apps/studio/server_state.h"

namespace kibori::studio {

// Answers the requests of a connection until it ends. Runs on the server's thread.
void serve_http(boost::asio::ip::tcp::socket socket, Server::State& server);

}  // namespace kibori::studio
