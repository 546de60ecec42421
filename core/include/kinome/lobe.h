#pragma once

#include <cstdint>

namespace kinome {

/// Parts of a BSDF, as a set. kNull is no part of its own: the lobe of a sample is kDelta | kNull
/// if the light goes straight through the surface as through a hole, which leaves the film's alpha
/// to what is behind it.
enum class Lobe : uint32_t {
  kNone = 0,
  kDiffuse = 1,
  kGlossy = 2,
  kDelta = 4,
  kAll = 7,
  kNull = 8
};
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
