// SPDX-License-Identifier: MIT
// The certificate by which devices of the network recognise the studio. The studio signs it itself,
// so a browser warns about it once. The user then compares its fingerprint. Internal to
// apps/studio.
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
  std::string made;         // why a new one was made; empty: the old one is used
};

// Reads the certificate of `file`, or makes one and writes it there. Only the user may read the
// file. Makes a new certificate if there is none, or if it is damaged or others could read its key.
// Also makes a new one if the old one is not yet valid at `now`, expires within a day, or does not
// name all `addresses`. Errors: OpenSSL fails, or the file cannot be written.
Result<Certificate> keep_certificate(const std::filesystem::path& file,
                                     const std::vector<std::string>& addresses,
                                     std::time_t now = std::time(nullptr));

}  // namespace kibori::studio
