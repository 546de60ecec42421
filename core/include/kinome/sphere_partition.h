#pragma once

#include <cstdint>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// The unit sphere in `size` cells of equal solid angle, 4 pi / size each: rings around y, cut into
/// nearly square pieces. Gives "samples spread uniformly on the sphere" (Åkerlund 2008, 3.4.1)
/// that are at once strata, with an inverse. Cells count from +y in rings, around y from -z toward
/// +x: phi = atan2(x, -z), as rows and columns of an environment map do. Thread-safe.
class KINOME_EXPORT SpherePartition {
 public:
  explicit SpherePartition(uint32_t size);
  uint32_t size() const { return size_; }
  float cell_solid_angle() const { return 4 * kPi / static_cast<float>(size_); }
  /// Centre (in area) of cell i; a unit vector.
  Vec3 centre(uint32_t i) const;
  /// Uniform within cell i; cell_of() of it is i for every u in [0, 1)².
  Vec3 sample(uint32_t i, const Vec2& u) const;
  /// The cell that holds the unit vector d.
  uint32_t cell_of(const Vec3& d) const;

  uint32_t ring_count() const { return static_cast<uint32_t>(first_.size()) - 1; }
  /// First cell of a ring, up to first_of_ring(ring_count()) == size(). Ring r spans
  /// y = 1 - 2 first_of_ring(r) / size() down to 1 - 2 first_of_ring(r + 1) / size(), and its cells
  /// equal shares of phi in [0, 2 pi).
  uint32_t first_of_ring(uint32_t ring) const { return first_[ring]; }

 private:
  uint32_t ring_of(uint32_t cell) const;
  /// The direction at (share of phi, cells north of it).
  Vec3 direction(double turn, double north) const;
  uint32_t size_;
  std::vector<uint32_t> first_;  ///< first cell of each ring; one more entry than rings
};

}  // namespace kinome
