#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "kinome/blocks.h"

namespace kinome {

/// Clears the upper halves of the vector registers. Call clear() before loops over code of the
/// baseline instruction set, in functions that code with wider vectors calls. While the upper
/// halves are in use, processors run SSE code several times slower.
class UpperHalves {
 public:
  static void clear() {
#if defined(__x86_64__)
    if (has_avx_) clear_avx();
#endif
  }

 private:
#if defined(__x86_64__)
  __attribute__((target("avx"))) static void clear_avx() { _mm256_zeroupper(); }
  inline static const bool has_avx_ = __builtin_cpu_supports("avx");
#endif
};

}  // namespace kinome
