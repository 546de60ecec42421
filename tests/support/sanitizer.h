#pragma once

namespace kinome::test {

/// Whether this is built with a sanitizer. It finds in few repetitions what it finds in many, each
/// of which takes ten times as long: tests that repeat the same lines for the sake of statistics
/// repeat them less often then.
#ifdef KINOME_HAS_SANITIZER
inline constexpr bool kHasSanitizer = true;
#else
inline constexpr bool kHasSanitizer = false;
#endif

}  // namespace kinome::test
