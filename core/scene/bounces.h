#pragma once

#include <algorithm>

#include "kinome/emitter.h"

namespace kinome {

/// Returns true if two indirect emitters represent the bounce of the same emitter, which would
/// count twice.
inline bool have_same_bounce(const Emitter& a, const Emitter& b) {
  const auto of_a = a.children(), of_b = b.children();
  return of_a.empty() || of_b.empty() ||
         std::any_of(of_a.begin(), of_a.end(), [&](const auto& child) {
           return std::find(of_b.begin(), of_b.end(), child) != of_b.end();
         });
}

inline constexpr const char* kSameBounce =
    "two emitters represent the bounce of the same emitter, which would count twice: give each its "
    "own emitters, or remove one";

}  // namespace kinome
