#pragma once

#include <cstdint>

namespace kinome {

/// Parts of a BSDF, as a set.
enum class Lobe : uint32_t { kNone = 0, kDiffuse = 1, kGlossy = 2, kDelta = 4, kAll = 7 };
constexpr Lobe operator|(Lobe a, Lobe b) {
  return static_cast<Lobe>(static_cast<uint32_t>(a) | static_cast<uint32_t>(b));
}
constexpr Lobe operator&(Lobe a, Lobe b) {
  return static_cast<Lobe>(static_cast<uint32_t>(a) & static_cast<uint32_t>(b));
}
constexpr bool any(Lobe a) {
  return a != Lobe::kNone;
}

}  // namespace kinome
