#pragma once

#include "kinome/wide/vectors.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Indices into columns, a vector of them. Where they lie close together, as of neighbours most of
/// which are left, two loads and a permutation take the place of a gather, in a fraction of its
/// time. Columns begin at a multiple of a vector's length, and are padded.
class NearIndices {
 public:
  KINOME_WIDE explicit NearIndices(const uint32_t* indices)
      : NearIndices(indices, [](auto index) { return index; }) {}
  /// `place` of an index, an Int or an uint32_t, is where in memory it has its value: the values of
  /// an aligned vector of indices must follow one another.
  template <class Place>
  KINOME_WIDE NearIndices(const uint32_t* indices, const Place& place) {
    const uint32_t first = indices[0] / kLanes * kLanes;
    const Uint beyond = Uint::load(indices) - first;
    is_near_ = all(beyond < static_cast<uint32_t>(2 * kLanes));
    at_ = is_near_ ? as_int(beyond) : place(Int::load(indices));
    low_ = place(first);
    // What no lane needs may not be there.
    high_ = all(beyond < static_cast<uint32_t>(kLanes)) ? low_ : place(first + uint32_t{kLanes});
  }

  KINOME_WIDE Float in(const float* p) const { return values<Float>(p); }
  KINOME_WIDE Uint in(const uint32_t* p) const { return values<Uint>(p); }
  KINOME_WIDE Vec2 in(const Columns2& c) const { return {in(c.x), in(c.y)}; }
  KINOME_WIDE Vec3 in(const Columns3& c) const { return {in(c.x), in(c.y), in(c.z)}; }

 private:
  template <class T>
  KINOME_WIDE T values(const auto* p) const {
    return is_near_ ? pick(T::load(p + low_), T::load(p + high_), at_) : gather(p, at_);
  }
  bool is_near_;
  Int at_;  ///< where, or which of the values that begin at low_ and at high_
  uint32_t low_, high_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
