#pragma once

#include <memory>

#include "kinome/emitter.h"

namespace kinome {

/// Base of environments of which only the radiance is known. A table of the radiance, probed at
/// 0.7 degrees, makes them importance-sampled, and all integrators support them. The density is
/// positive everywhere, so that light between the probed directions is not lost, only noisy.
///
///     class Dawn final : public kinome::Sky {
///       kinome::Rgb radiance(const kinome::Vec3& d) const override { … }
///     };
///
/// Thread-safe if radiance() is.
class KINOME_EXPORT Sky : public Emitter {
 public:
  Sky();
  ~Sky() override;

  /// Radiance that arrives from the unit direction d, world space. Must be finite.
  virtual Rgb radiance(const Vec3& d) const = 0;

  bool is_environment() const final { return true; }
  void prepare(const Aabb& scene_bounds) final;
  Rgb eval_environment(const Vec3& d) const final { return radiance(d); }
  float pdf_environment(const Vec3& d) const final;
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const final;
  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const final;
  std::optional<EmissionDensity> emission_density(const Vec3& d) const final;

 private:
  struct Tables;
  std::unique_ptr<Tables> tables_;
};

}  // namespace kinome
