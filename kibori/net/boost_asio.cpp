// SPDX-License-Identifier: MIT
// The implementation of Boost.Asio, compiled once for all users (BOOST_ASIO_SEPARATE_COMPILATION).
#include <boost/asio/impl/src.hpp>
