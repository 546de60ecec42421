#pragma once

#include <cstdint>

namespace kinome {

/// Set of BSDF lobes. kNull is only a flag: the lobe of a sample is kDelta | kNull if the light
/// passes straight through the surface as through a hole. The film's alpha is then that of what is
/// behind the surface.
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
