// SPDX-License-Identifier: MIT
// The Boost.Asio objects inside a Loop and a Socket, for sources that use Asio directly. Internal.
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>

#include <kibori/net/web.h>

namespace kibori::net {

struct Loop::State {
  boost::asio::io_context io{1};
};

struct Socket::State {
  explicit State(boost::asio::generic::stream_protocol::socket connected)
      : socket(std::move(connected)) {}
  boost::asio::generic::stream_protocol::socket socket;
};

}  // namespace kibori::net
