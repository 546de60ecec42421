#pragma once

#include <vector>

#include "kinome/bsdf.h"
#include "transport/arena.h"

namespace kinome {

/// Points of surfaces, each repeated for as many directions as BSDFs are to be asked for there. One
/// per thread.
class RepeatedPoints {
 public:
  /// For as many points as the arena's capacity.
  explicit RepeatedPoints(transport::Arena& arena);

  void clear();
  /// How many more there is room for; a multiple of 16.
  size_t room() const { return capacity_ - points_.count; }
  /// Adds `count` copies, and what fills the last vector, of point i of `from`, whose material is
  /// `bsdf`. Returns the number of the first one, a multiple of 16.
  size_t add(const SurfaceBlock& from, size_t i, const Bsdf& bsdf, size_t count);

  /// All points; count is a multiple of 16.
  const SurfaceBlock& points() const { return points_; }
  /// Asks each material for all its points at once.
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
