#pragma once

namespace kinome::test {

/// True in builds with a sanitizer. Tests that repeat the same code for their statistics repeat it
/// less often then: the sanitizer makes each repetition ten times slower, and more repetitions find
/// no more errors.
#ifdef KINOME_HAS_SANITIZER
inline constexpr bool kHasSanitizer = true;
#else
inline constexpr bool kHasSanitizer = false;
#endif

}  // namespace kinome::test
