#pragma once

#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/interaction.h"
#include "kinome/math.h"
#include "kinome/scene.h"

/// What audit_plugins() asks of single objects: each function returns what is wrong, or nullptr.
namespace kinome {

/// Where plugins are asked.
struct AuditPlace {
  const Scene& scene;
  const SurfaceInteraction* si;  ///< nullptr: the ray left the scene
  Vec3 d;                        ///< of the ray
  uint64_t seed;
  Vec3 p() const { return si ? si->p : Vec3(0.f); }
  float u(uint64_t i) const { return static_cast<float>(hash_words(seed, i) >> 40) * 0x1p-24f; }
  Vec2 u2(uint64_t i) const { return {u(i), u(i + 1)}; }
};

/// Values that aren't finite, densities that are negative or no numbers.
const char* nonsense_of(const Bsdf& bsdf, const AuditPlace& place);
const char* nonsense_of(const Emitter& emitter, const AuditPlace& place);

/// Answers that contradict one another: samples and densities, samples and values, batches and
/// single values, an environment and its grid. To be asked where there is no nonsense.
const char* contradiction_of(const Bsdf& bsdf, const AuditPlace& place);
const char* contradiction_of(const Emitter& emitter, const AuditPlace& place);

/// What the first try finds wrong, if one of eight others does so, too. A single try may fail by
/// rounding, where a surface or a texel ends: where that is one in 10^4, two fail at 8 in 10^8 of
/// the places.
template <class Try>
const char* confirmed(const Try& fault_of_try) {
  constexpr uint64_t kTries = 9;
  const char* const fault = fault_of_try(uint64_t{0});
  for (uint64_t i = 1; fault && i < kTries; ++i) {
    if (fault_of_try(i)) return fault;
  }
  return nullptr;
}

/// Random numbers of tries, each with a hundred of its own, apart from those of the place.
inline constexpr uint64_t kTryNumbers = 100;
inline uint64_t first_number(uint64_t attempt) {
  return kTryNumbers * (1 + attempt);
}

}  // namespace kinome
