#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace kinome {

/// Flushes denormals to zero in this thread (FTZ and DAZ) until its end. Denormals cost a hundred
/// cycles each and carry nothing that a picture could show; every thread that computes radiance
/// does the same, so that results cannot depend on which thread computed them.
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
