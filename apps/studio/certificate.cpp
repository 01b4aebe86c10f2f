// SPDX-License-Identifier: MIT
#include "apps/studio/certificate.h"

#include <cstdint>
#include <cstdio>
#include <memory>

#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <kibori/base/file.h>

namespace kibori::studio {
namespace {

constexpr std::time_t kDay = 24 * 60 * 60;
// Browsers refuse certificates that are valid for more than 398 days.
constexpr std::time_t kValidDays = 397;
constexpr uint64_t kMaxPemBytes = 1 << 16;

template <auto free_it>
struct Free {
  template <class T>
  void operator()(T* object) const {
    free_it(object);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using X509Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Memory = std::unique_ptr<BIO, Free<BIO_free_all>>;

std::string fingerprint_of(const X509* certificate) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned size = 0;
  if (X509_digest(certificate, EVP_sha256(), digest, &size) != 1) return {};
  std::string text;
  for (unsigned i = 0; i < size; i++) {
    char byte[4];
    std::snprintf(byte, sizeof byte, i == 0 ? "%02X" : ":%02X", digest[i]);
    text += byte;
  }
  return text;
}

bool add_extension(X509* certificate, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx_nodb(&context);
  X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
  const std::unique_ptr<X509_EXTENSION, Free<X509_EXTENSION_free>> extension(
      X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str()));
  return extension && X509_add_ext(certificate, extension.get(), -1) == 1;
}

// Refuses encrypted keys. Without this callback, OpenSSL asks in the terminal for the password.
int no_password(char*, int, int, void*) { return -1; }

// Empty if OpenSSL failed, for example without memory.
Certificate make_certificate(const std::vector<std::string>& addresses, std::time_t now) {
  const Key key(EVP_EC_gen("P-256"));
  const X509Certificate made(X509_new());
  if (!key || !made) return {};
  X509* const x = made.get();
  uint64_t serial = 0;
  if (RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) != 1) return {};
  std::string names;
  for (const std::string& address : addresses) names += (names.empty() ? "IP:" : ",IP:") + address;
  std::time_t from = now - kDay, to = now + kValidDays * kDay;  // the device's clock may be slow
  X509_NAME* const name = X509_get_subject_name(x);
  const bool complete =
      X509_set_version(x, X509_VERSION_3) == 1 &&
      ASN1_INTEGER_set_uint64(X509_get_serialNumber(x), serial >> 1) == 1 &&
      ASN1_TIME_set(X509_getm_notBefore(x), from) && ASN1_TIME_set(X509_getm_notAfter(x), to) &&
      X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC,
                                 reinterpret_cast<const unsigned char*>("Kibori studio"), -1, -1,
                                 0) == 1 &&
      X509_set_issuer_name(x, name) == 1 && X509_set_pubkey(x, key.get()) == 1 &&
      add_extension(x, NID_basic_constraints, "critical,CA:FALSE") &&
      add_extension(x, NID_key_usage, "critical,digitalSignature") &&
      add_extension(x, NID_ext_key_usage, "serverAuth") &&
      add_extension(x, NID_subject_alt_name, names) && X509_sign(x, key.get(), EVP_sha256()) > 0;
  const Memory memory(BIO_new(BIO_s_mem()));
  if (!complete || !memory ||
      PEM_write_bio_PrivateKey(memory.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) !=
          1 ||
      PEM_write_bio_X509(memory.get(), x) != 1)
    return {};
  char* text = nullptr;
  const long size = BIO_get_mem_data(memory.get(), &text);
  return {std::string(text, static_cast<size_t>(size)), fingerprint_of(x), {}};
}

// Reads the certificate in `file`. If it cannot be used, `pem` is empty and `made` says why.
Certificate read_certificate(const std::filesystem::path& file,
                             const std::vector<std::string>& addresses, std::time_t now) {
  const auto no = [](const std::string& why) { return Certificate{{}, {}, why}; };
  struct stat status {};
  if (lstat(file.c_str(), &status) != 0) return no("there was none yet");
  if (!S_ISREG(status.st_mode) || status.st_uid != geteuid() || (status.st_mode & 0077) != 0)
    return no("other users could read the key of the old one");
  const auto bytes = read_file(file, kMaxPemBytes);
  if (!bytes) return no("the old one could not be read");
  const std::string pem(bytes.value().begin(), bytes.value().end());
  const Memory memory(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  const Key key(memory ? PEM_read_bio_PrivateKey(memory.get(), nullptr, no_password, nullptr)
                       : nullptr);
  const X509Certificate read(memory ? PEM_read_bio_X509(memory.get(), nullptr, nullptr, nullptr)
                                    : nullptr);
  if (!key || !read || X509_check_private_key(read.get(), key.get()) != 1)
    return no("the old one was damaged");
  std::time_t tomorrow = now + kDay;
  if (X509_cmp_time(X509_get0_notAfter(read.get()), &tomorrow) <= 0)
    return no("the old one expires");
  if (X509_cmp_time(X509_get0_notBefore(read.get()), &now) >= 0)
    return no("the old one is not valid yet");
  for (const std::string& address : addresses)
    if (X509_check_ip_asc(read.get(), address.c_str(), 0) != 1)
      return no("the old one does not name the address " + address);
  return {pem, fingerprint_of(read.get()), {}};
}

}  // namespace

Result<Certificate> keep_certificate(const std::filesystem::path& file,
                                     const std::vector<std::string>& addresses, std::time_t now) {
  Certificate kept = read_certificate(file, addresses, now);
  if (!kept.pem.empty()) return kept;
  Certificate made = make_certificate(addresses, now);
  if (made.pem.empty()) return Error{"OpenSSL cannot make a certificate for the studio"};
  made.made = kept.made;
  const std::string wrong = file.string() + ": the certificate of the studio cannot be stored";
  std::error_code failed;
  std::filesystem::create_directories(file.parent_path(), failed);
  // make_sibling() creates a file that only this user can read. The rename then replaces the old
  // file at once.
  const Result<std::filesystem::path> fresh = make_sibling(file);
  if (!fresh) return Error{fresh.error()};
  std::FILE* const out = std::fopen(fresh.value().c_str(), "wb");
  bool written = out && std::fwrite(made.pem.data(), 1, made.pem.size(), out) == made.pem.size();
  if (out) written = std::fclose(out) == 0 && written;
  if (written) std::filesystem::rename(fresh.value(), file, failed);
  if (written && !failed) return made;
  std::filesystem::remove(fresh.value(), failed);
  return Error{wrong + "; check the folder and the disk"};
}

}  // namespace kibori::studio
