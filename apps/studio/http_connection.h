// SPDX-License-Identifier: MIT
// HTTP connections. A connection requests files, uploads a file, or becomes the WebSocket of a
// page. Internal to apps/studio.
#pragma once

#include "apps/studio/server_state.h"

namespace kibori::studio {

// Answers the requests of a connection until it ends. It runs on the server's thread.
void serve_http(net::Socket socket, Server::State& server, Entrance& entrance);

}  // namespace kibori::studio
