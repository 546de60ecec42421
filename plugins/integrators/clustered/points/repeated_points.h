#pragma once

#include <vector>

#include "kinome/bsdf.h"
#include "transport/blocks/arena.h"

namespace kinome {

/// Surface points, each repeated once for each direction for which its BSDF is evaluated. Not
/// thread-safe: use one per thread.
class RepeatedPoints {
 public:
  /// `arena`: its capacity is the maximum number of points.
  explicit RepeatedPoints(transport::Arena& arena);

  void clear();
  /// Number of points that can still be added; a multiple of 16.
  size_t room() const { return capacity_ - points_.count; }
  /// Adds `count` copies of point i of `from`, whose material is `bsdf`, and pads the last vector
  /// with more copies. Returns the index of the first one, a multiple of 16.
  size_t add(const SurfaceBlock& from, size_t i, const Bsdf& bsdf, size_t count);

  /// All points; count is a multiple of 16.
  const SurfaceBlock& points() const { return points_; }
  /// Evaluates the BSDFs, with one call for each run of points on one material.
  void shade(const BsdfQuery& query, const BsdfAnswer& answer) const;

 private:
  struct Range {
    const Bsdf* bsdf;
    size_t first;
    size_t count;
  };
  size_t capacity_;
  SurfaceBlock points_;
  std::vector<Range> ranges_;
};

}  // namespace kinome
