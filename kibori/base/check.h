// SPDX-License-Identifier: MIT
// Assertions for programming errors. There are two kinds. KIBORI_CHECK is cheap and also runs in
// release builds. KIBORI_DEBUG_CHECK may be slow and runs in debug builds only. Bad input is not a
// programming error: return an Error instead (result.h).
#pragma once

#include <cstdio>
#include <cstdlib>

#define KIBORI_CHECK(condition)                                                                 \
  do {                                                                                          \
    if (!(condition)) [[unlikely]] {                                                            \
      std::fprintf(stderr, "kibori: internal check failed: %s (%s:%d)\n", #condition, __FILE__, \
                   __LINE__);                                                                   \
      std::abort();                                                                             \
    }                                                                                           \
  } while (false)

#ifdef NDEBUG
#define KIBORI_DEBUG_CHECK(condition) static_cast<void>(sizeof(!(condition)))
#else
#define KIBORI_DEBUG_CHECK(condition) KIBORI_CHECK(condition)
#endif
