// SPDX-License-Identifier: MIT
// Asserts for our own mistakes, in two tiers: KIBORI_CHECK is cheap and lives in release builds,
// KIBORI_DEBUG_CHECK may be slow and lives in debug builds only. Bad input is never asserted: see
// result.h.
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
