// SPDX-License-Identifier: MIT
// Finds the network addresses of this machine. Internal to apps/studio.
#pragma once

#include <string>
#include <vector>

#include <kibori/base/result.h>

namespace kibori::studio {

// Returns the IPv4 addresses of this machine in private networks (RFC 1918), as text. The address
// through which packets leave this machine is first. Empty if there is none.
std::vector<std::string> private_addresses();

// Returns a numeric address in the form that browsers write. Errors: it is not the address of an
// interface.
Result<std::string> canonical_address(const std::string& text);

}  // namespace kibori::studio
