// SPDX-License-Identifier: MIT
// Connections over HTTP: each asks for files, brings one, or becomes a page's WebSocket. Internal
// to apps/studio.
#pragma once

#include <boost/asio/ip/tcp.hpp>

#include "apps/studio/server_state.h"

namespace kibori::studio {

// Answers what comes over a connection until that ends. On the server's thread.
void serve_http(boost::asio::ip::tcp::socket socket, Server::State& server);

}  // namespace kibori::studio
