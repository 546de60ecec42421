#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kinome/emitter.h"

namespace kinome {

/// Chooses the emitter that a path from the eye samples at its end. Probabilities depend on the
/// unshadowed light from each emitter, estimated by one sample. A part depends on flux, for light
/// that this sample misses. Immutable; thread-safe.
class SourceChoice {
 public:
  /// Maximum number of emitters that are sampled. If there are more, only flux determines the
  /// choice.
  static constexpr size_t kMaxSampledEmitters = 16;

  SourceChoice() = default;
  /// `fluxes` of the sources must be positive, with a finite sum. `radius` is that of the scene.
  SourceChoice(std::vector<const Emitter*> sources, const std::vector<double>& fluxes,
               float radius);

  /// Choice at one position. Must not outlive the SourceChoice.
  class At {
   public:
    /// Probability of a source.
    float probability(uint32_t source) const {
      return choice_.samples_sources() ? probabilities_[source] : choice_.shares_[source];
    }
    /// u in [0, 1).
    uint32_t pick(float u) const;

   private:
    friend class SourceChoice;
    explicit At(const SourceChoice& choice) : choice_(choice) {}
    const SourceChoice& choice_;
    std::array<float, kMaxSampledEmitters> probabilities_;  // uninitialised if !samples_sources()
  };
  /// `normal` is a unit vector on the side that reflects the light.
  At at(const Vec3& place, const Vec3& normal) const;

 private:
  /// True if sources are sampled. A single source needs no choice.
  bool samples_sources() const {
    return sources_.size() > 1 && sources_.size() <= kMaxSampledEmitters;
  }
  float light_at(uint32_t source, const Vec3& place, const Vec3& normal) const;

  std::vector<const Emitter*> sources_;
  std::vector<float> shares_;  ///< fractions of the flux
  std::vector<double> ends_;  ///< running sums of the shares
  std::vector<float> skies_;  ///< mean irradiance of each environment; 0 for other sources
};

}  // namespace kinome
