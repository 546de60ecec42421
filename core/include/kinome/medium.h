#pragma once

#include <memory>

#include "kinome/color.h"
#include "kinome/columns.h"
#include "kinome/phase.h"
#include "kinome/volume.h"

namespace kinome {

/// Coefficients of a medium at a point, per unit of length in world space.
struct MediumCoefficients {
  Rgb extinction{0.f};  ///< sigma_t
  Rgb scattering{0.f};  ///< sigma_s; at most sigma_t
};

/// Coefficients at the points of a block. The columns of a colour may be the same column three
/// times if the medium isn't coloured.
struct MediumBlock {
  Columns3 extinction;
  Columns3 scattering;  ///< nullptr if not needed
};

/// Participating medium that fills the inside or the outside of shapes. It has no boundary of its
/// own except box(). Integrators sample distances and estimate transmittances.
class KINOME_EXPORT Medium : public Object {
 public:
  /// Coefficients at the world-space point p, for rays of the unit direction d. They are valid in
  /// box(), and 0 outside. `d` has no effect unless phase().is_oriented().
  virtual MediumCoefficients coefficients(const Vec3& p, const Vec3& d) const = 0;
  /// Block version; points outside of box() may get any values. The columns of `d` may be nullptr
  /// unless phase().is_oriented(). Default: point by point.
  virtual void coefficients_block(const Columns3& p, const Columns3& d, size_t count,
                                  const MediumBlock& out) const;
  const Phase& phase() const { return *phase_; }

  /// World-space box outside of which the medium is empty; infinite if it isn't bounded.
  virtual Aabb box() const { return {Vec3(-kInfinity), Vec3(kInfinity)}; }
  /// True if the coefficients are the same everywhere, and don't depend on the direction.
  virtual bool is_uniform() const { return false; }
  /// True if the channels of the extinction may differ.
  bool is_coloured() const { return is_coloured_; }
  /// False if emitters must not be sampled at collisions, because shadow rays rarely leave the
  /// medium. Phase samples then find all light.
  bool samples_emitters() const { return samples_emitters_; }

  /// Number of voxels along the axes of box(), for choosing the size of blocks.
  virtual glm::uvec3 resolution() const { return glm::uvec3(1); }
  /// Bounds on the extinction, over all points of box(), channels and directions.
  float min_extinction() const { return min_extinction_; }
  float max_extinction() const { return max_extinction_; }
  /// The same for each block of a grid; see Volume::extremes(). Default: min_extinction() and
  /// max_extinction().
  virtual void extremes(const BlockGrid& blocks, float* lo, float* hi) const;

  /// True if optical_depth_block() is implemented.
  virtual bool has_optical_depth() const { return false; }
  /// Integrates the extinction along segments o + t d, 0 <= t <= length, in box(), exactly up to
  /// rounding errors.
  virtual void optical_depth_block(const Columns3& o, const Columns3& d, const float* length,
                                   size_t count, const Columns3& out) const;

 protected:
  Medium() = default;
  std::shared_ptr<const Phase> phase_;
  bool is_coloured_ = false;
  bool samples_emitters_ = true;
  float min_extinction_ = 0;
  float max_extinction_ = 0;
};

}  // namespace kinome
