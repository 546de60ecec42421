#pragma once

#include <memory>
#include <optional>

#include "kinome/emitter.h"

namespace kinome {

/// Base class of environments that define only their radiance. All integrators support them, with
/// importance sampling by a table of the radiance at directions 0.35 degrees apart. The density is
/// positive everywhere: light between the directions of the table is not lost, but so noisy that
/// images of few samples don't show it. An environment with sources smaller than the sun needs
/// functions of its own. Where the radiance isn't finite, it counts as 0 in the table.
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

  /// Radiance that arrives from the unit direction d, world space. Must be finite. Thread-safe.
  virtual Rgb radiance(const Vec3& d) const = 0;

  bool is_environment() const final { return true; }
  void prepare(const Aabb& scene_bounds) final;
  Rgb eval_environment(const Vec3& d) const final { return radiance(d); }
  float pdf_environment(const Vec3& d) const final;
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2& u) const final;
  void sample_direct_block(const Columns3& p, const Columns2& u, size_t count,
                           const DirectBlock& out) const final;
  void eval_environment_block(const Columns3& d, size_t count, const Columns3& radiances,
                              float* pdf) const final;
  std::optional<EmissionSample> sample_emission(const Vec2& position,
                                                const Vec2& direction) const final;
  std::optional<EmissionDensity> emission_density(const Vec3& d) const final;

 private:
  struct Tables;
  std::unique_ptr<Tables> tables_;
};

}  // namespace kinome
