#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kinome/emitter.h"

namespace kinome {

/// Which source of light a path from the eye asks at the place where it ends: by what each sends
/// there if nothing hides it, as far as one look at it tells, and by flux, for what that look
/// misses. Immutable; thread-safe.
class SourceChoice {
 public:
  /// Every place looks at every source. If there are more than these, flux alone decides.
  static constexpr size_t kMostLooks = 16;

  SourceChoice() = default;
  /// fluxes: of the sources, positive; their sum is finite. radius: of the scene.
  SourceChoice(std::vector<const Emitter*> sources, const std::vector<double>& fluxes,
               float radius);

  /// The choice at one place. Must not outlive the SourceChoice.
  class At {
   public:
    /// Probability of a source.
    float probability(uint32_t source) const {
      return choice_.looks() ? probabilities_[source] : choice_.shares_[source];
    }
    /// u in [0, 1).
    uint32_t pick(float u) const;

   private:
    friend class SourceChoice;
    explicit At(const SourceChoice& choice) : choice_(choice) {}
    const SourceChoice& choice_;
    std::array<float, kMostLooks> probabilities_;  // left alone where there are no looks
  };
  /// normal: unit, on the side that light is reflected on.
  At at(const Vec3& place, const Vec3& normal) const;

 private:
  /// There is nothing to choose from a single source.
  bool looks() const { return sources_.size() > 1 && sources_.size() <= kMostLooks; }
  float light_at(uint32_t source, const Vec3& place, const Vec3& normal) const;

  std::vector<const Emitter*> sources_;
  std::vector<float> shares_;  ///< of the flux
  std::vector<double> ends_;  ///< running sums of the shares
  std::vector<float> skies_;  ///< of environments: mean irradiance; 0 for all others
};

}  // namespace kinome
