#pragma once

#include <cstdint>
#include <vector>

#include "kinome/math.h"

namespace kinome {

/// Partition of the unit sphere into `size` cells of equal solid angle, 4 pi / size: rings around
/// y, divided into nearly square cells. The cells stratify "samples spread uniformly on the sphere"
/// (Åkerlund 2008, 3.4.1), and the mapping is invertible. Cells are numbered by rings from +y, and
/// within a ring from -z toward +x: phi = atan2(x, -z), like rows and columns of an environment
/// map. Thread-safe.
class KINOME_EXPORT SpherePartition {
 public:
  explicit SpherePartition(uint32_t size);
  uint32_t size() const { return size_; }
  float cell_solid_angle() const { return 4 * kPi / static_cast<float>(size_); }
  /// Centre of cell i by area, a unit vector.
  Vec3 centre(uint32_t i) const;
  /// Samples a unit vector uniformly in cell i. cell_of() of it is i for all u in [0, 1)².
  Vec3 sample(uint32_t i, const Vec2& u) const;
  /// Returns the cell that contains the unit vector d.
  uint32_t cell_of(const Vec3& d) const;

  uint32_t ring_count() const { return static_cast<uint32_t>(first_.size()) - 1; }
  /// First cell of a ring; first_of_ring(ring_count()) == size(). Ring r spans y from 1 - 2
  /// first_of_ring(r) / size() down to 1 - 2 first_of_ring(r + 1) / size(). Its cells divide phi in
  /// [0, 2 pi) equally.
  uint32_t first_of_ring(uint32_t ring) const { return first_[ring]; }

 private:
  uint32_t ring_of(uint32_t cell) const;
  /// Returns the direction with phi = 2 pi turn, and `north` cells north of it.
  Vec3 direction(double turn, double north) const;
  uint32_t size_;
  std::vector<uint32_t> first_;  ///< first cell of each ring; one more entry than rings
};

}  // namespace kinome
