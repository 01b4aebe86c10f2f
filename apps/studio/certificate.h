// SPDX-License-Identifier: MIT
// The certificate by which devices of the network recognise the studio. The studio signs its own
// certificate, so a browser warns about it once. Then the user compares the fingerprint. Internal
// to apps/studio.
#pragma once

#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include <kibori/base/result.h>

namespace kibori::studio {

struct Certificate {
  std::string pem;          // the private key, then the certificate
  std::string fingerprint;  // SHA-256 of the certificate, as AA:BB:...
  std::string made;         // reason why a new one was made; empty: the old one is used
};

// Reads the certificate of `file`. Makes a new certificate and writes it to `file` in these cases:
// there is none; it is damaged; other users could read its key; it is not valid yet at `now`, or
// expires within a day; it does not name all `addresses`. Only the user may read the file. Errors:
// OpenSSL fails; the file cannot be written.
Result<Certificate> keep_certificate(const std::filesystem::path& file,
                                     const std::vector<std::string>& addresses,
                                     std::time_t now = std::time(nullptr));

}  // namespace kibori::studio
