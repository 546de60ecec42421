#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace kinome {

/// Flushes denormals to zero in this thread (FTZ and DAZ) for its lifetime. An operation with
/// denormals costs about 100 cycles, and they are too small to be visible in an image. All threads
/// that compute radiance use this class, so results do not depend on the thread.
class DenormalGuard {
 public:
#if defined(__SSE2__)
  DenormalGuard() : saved_(_mm_getcsr()) {
    _mm_setcsr(saved_ | kFlushToZero | kDenormalsAreZero);
  }
  ~DenormalGuard() {
    _mm_setcsr(saved_);
  }
#else
  DenormalGuard() = default;
#endif
  DenormalGuard(const DenormalGuard&) = delete;
  DenormalGuard& operator=(const DenormalGuard&) = delete;

#if defined(__SSE2__)
 private:
  static constexpr unsigned kFlushToZero = 0x8000;
  static constexpr unsigned kDenormalsAreZero = 0x0040;
  unsigned saved_;
#endif
};

}  // namespace kinome
