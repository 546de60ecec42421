#pragma once

#include <cstdint>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// The unit sphere in `size` cells of equal solid angle, 4 pi / size each: rings around y, cut into
/// nearly square pieces. Gives "samples spread uniformly on the sphere" (Åkerlund 2008, 3.4.1)
/// that are at once strata, with an inverse. Thread-safe.
class KINOME_EXPORT SpherePartition {
 public:
  explicit SpherePartition(uint32_t size);
  uint32_t size() const { return size_; }
  float cell_solid_angle() const { return 4 * kPi / static_cast<float>(size_); }
  /// Centre (in area) of cell i; a unit vector.
  Vec3 centre(uint32_t i) const;
  /// Uniform within cell i.
  Vec3 sample(uint32_t i, const Vec2& u) const;
  /// The cell that holds the unit vector d.
  uint32_t cell_of(const Vec3& d) const;

 private:
  uint32_t ring_of(uint32_t cell) const;
  uint32_t size_;
  std::vector<uint32_t> first_;  ///< first cell of each ring; one more entry than rings
};

}  // namespace kinome
