// SPDX-License-Identifier: MIT
// Turns an HTTP request into a page's WebSocket. Internal to apps/studio.
#pragma once

#include <memory>

#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "apps/studio/server_state.h"

namespace kibori::studio {

// Accepts the WebSocket that `request` asks for. The connection then belongs to a page.
void accept_websocket(boost::beast::tcp_stream stream,
                      boost::beast::http::request<boost::beast::http::empty_body> request,
                      Server::State& server, std::shared_ptr<Guest> guest);

}  // namespace kibori::studio
