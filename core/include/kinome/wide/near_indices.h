#pragma once

#include "kinome/wide/vectors.h"

namespace kinome::wide {
inline namespace HWY_NAMESPACE {

/// Vector of indices into columns. If all indices are close together, for example after compaction
/// with few gaps, loads use two vector loads and a permutation, which is several times faster than
/// a gather. Columns must be aligned to a vector's length and padded.
class NearIndices {
 public:
  KINOME_WIDE explicit NearIndices(const uint32_t* indices)
      : NearIndices(indices, [](auto index) { return index; }) {}
  /// `place` maps an index (Int or uint32_t) to its position in memory. Indices in an aligned group
  /// of kLanes must map to consecutive positions.
  template <class Place>
  KINOME_WIDE NearIndices(const uint32_t* indices, const Place& place) {
    const uint32_t first = indices[0] / kLanes * kLanes;
    const Uint beyond = Uint::load(indices) - first;
    is_near_ = all(beyond < static_cast<uint32_t>(2 * kLanes));
    at_ = is_near_ ? as_int(beyond) : place(Int::load(indices));
    low_ = place(first);
    // The second vector may not exist if no lane needs it.
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
  Int at_;  ///< index in memory, or among the values loaded from low_ and high_
  uint32_t low_, high_;
};

}  // namespace HWY_NAMESPACE
}  // namespace kinome::wide
