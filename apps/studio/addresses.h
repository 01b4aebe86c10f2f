// SPDX-License-Identifier: MIT
// The network addresses of this machine. Internal to apps/studio.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>

namespace kibori::studio {

// Its IPv4 addresses in private networks (RFC 1918), as text. First the one that leads to the
// internet. Empty if there is none.
std::vector<std::string> private_addresses();

// A numeric address as browsers write it. Error: it is not the address of one interface.
Result<std::string> canonical_address(const std::string& text);

}  // namespace kibori::studio
