#pragma once

#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/interaction.h"
#include "kinome/math.h"
#include "kinome/scene.h"

/// Checks of single objects for audit_plugins(). Each function returns a description of the fault
/// (see audit_words), or nullptr if there is none.
namespace kinome {

/// Point of a scene at which plugins are checked.
struct AuditPlace {
  const Scene& scene;
  const SurfaceInteraction* si;  ///< nullptr: the ray left the scene
  Vec3 d;                        ///< direction of the camera ray
  uint64_t seed;
  Vec3 p() const { return si ? si->p : Vec3(0.f); }
  /// Random number with index i, in [0, 1).
  float u(uint64_t i) const { return static_cast<float>(hash_words(seed, i) >> 40) * 0x1p-24f; }
  Vec2 u2(uint64_t i) const { return {u(i), u(i + 1)}; }
};

/// Finds values that are not finite, and densities that are negative or NaN.
const char* find_invalid_value(const Bsdf& bsdf, const AuditPlace& place);
const char* find_invalid_value(const Emitter& emitter, const AuditPlace& place);

/// Finds functions that disagree: samples with densities or values, batches with single values, an
/// environment with its grid. Requires that find_invalid_value() finds nothing.
const char* find_contradiction(const Bsdf& bsdf, const AuditPlace& place);
const char* find_contradiction(const Emitter& emitter, const AuditPlace& place);

/// Returns the fault of the first attempt if at least one of eight others fails, too. A single
/// attempt may fail because of rounding at the border of a surface or a texel. If this happens with
/// probability 1e-4, two attempts fail with probability 8e-8.
template <class Attempt>
const char* confirmed(const Attempt& fault_of_attempt) {
  constexpr uint64_t kAttempts = 9;
  const char* const fault = fault_of_attempt(uint64_t{0});
  for (uint64_t i = 1; fault && i < kAttempts; ++i) {
    if (fault_of_attempt(i)) return fault;
  }
  return nullptr;
}

/// Returns the index of the first random number of an attempt. Each attempt has 100 numbers; those
/// before the first attempt's are for the point itself.
inline constexpr uint64_t kNumbersPerAttempt = 100;
inline uint64_t first_number(uint64_t attempt) {
  return kNumbersPerAttempt * (1 + attempt);
}

}  // namespace kinome
