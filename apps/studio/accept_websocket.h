// SPDX-License-Identifier: MIT
// From a request over HTTP to the WebSocket of a page. Internal to apps/studio.
#pragma once

#include <memory>

#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>

#include "apps/studio/server_state.h"

namespace kibori::studio {

// The connection, which asked for a WebSocket by this request, is a page's from now on.
void accept_websocket(boost::beast::tcp_stream stream,
                      boost::beast::http::request<boost::beast::http::empty_body> request,
                      Server::State& server, std::shared_ptr<Guest> guest);

}  // namespace kibori::studio
