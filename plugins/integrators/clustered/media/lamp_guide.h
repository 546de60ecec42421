#pragma once

#include "clustered/media/sources/fog_sources.h"
#include "clustered/media/sources/weighted_sources.h"
#include "kinome/phase.h"
#include "transport/blocks/arena.h"

namespace kinome {

/// Guides paths through media toward sources at finite distances.
///
/// A medium scatters light of a source at distance r along a ray at an angle θ to its direction.
/// The integral of 1/r² along the ray is about 1 / (r sin(θ/2)), which phase samples find with a
/// large variance (joint importance sampling: Georgiev et al. 2013). The guide draws directions
/// with a density in proportion to 1 / sin(θ/2). Averaged over directions, such light falls as 1/r,
/// in proportion to which the guide selects positions. Not thread-safe: use one per thread.
class LampGuide {
 public:
  explicit LampGuide(const FogSources& sources);

  /// True if there are no sources at finite distances.
  bool is_empty() const { return count_ == 0; }
  /// Expected light at a point that was scattered at least once on its way, up to a factor that is
  /// the same for all points. Neglects attenuation.
  float light_at(const Vec3& p);
  /// Replaces a sample of a phase function by one from a mixture of it and the guide. `u1` and `u2`
  /// are uniform; u1 is independent of the sample. Returns the ratio of the phase function to the
  /// density of the mixture, and sets `pdf` to the phase function.
  float redirect(const Phase& phase, const MediumPoint& point, float u1, const Vec2& u2, Vec3& wo,
                 float& pdf);
  /// Density of the guide's directions at p, per solid angle. Call light_at(p) first.
  float density(const Vec3& p, const Vec3& d) const;

 private:
  size_t count_;
  transport::Arena arena_;
  Columns3 p_;
  float *intensity_, *radius2_;
  WeightedSources weight_;  ///< weights at the last point
};

}  // namespace kinome
