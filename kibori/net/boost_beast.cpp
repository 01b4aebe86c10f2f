// SPDX-License-Identifier: MIT
// The implementation of Boost.Beast, compiled once for all users
// (BOOST_BEAST_SEPARATE_COMPILATION).
#include <boost/beast/src.hpp>
