// SPDX-License-Identifier: MIT
// Loads a vendor's library at run time. So Kibori does not link or ship proprietary code.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <dlfcn.h>

#include <kibori/base/result.h>

namespace kibori {

class SharedLibrary {
 public:
  SharedLibrary() = default;
  ~SharedLibrary() {
    if (handle_) dlclose(handle_);
  }
  SharedLibrary(SharedLibrary&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  SharedLibrary& operator=(SharedLibrary&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }

  // Opens the first of these libraries that can be loaded. Errors: none can be loaded; the message
  // lists the names.
  static Result<SharedLibrary> open(const std::vector<std::string>& names) {
    SharedLibrary library;
    std::string tried;
    for (const std::string& name : names) {
      library.handle_ = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
      if (library.handle_) return library;
      tried += (tried.empty() ? "" : ", ") + name;
    }
    return Error{"not found (looked for " + tried + ")"};
  }
  // Looks up a function. Returns false if the library does not have it.
  template <class F>
  bool find(const char* name, F*& function) const {
    function = reinterpret_cast<F*>(dlsym(handle_, name));
    return function != nullptr;
  }

 private:
  void* handle_ = nullptr;
};

}  // namespace kibori
