#include "clustered/points/repeated_points.h"

#include <algorithm>

namespace kinome {

RepeatedPoints::RepeatedPoints(transport::Arena& arena)
    : capacity_(arena.capacity()), points_(arena.points()) {}

void RepeatedPoints::clear() {
  points_.count = 0;
  ranges_.clear();
}

size_t RepeatedPoints::add(const SurfaceBlock& from, size_t i, const Bsdf& bsdf, size_t count) {
  const size_t first = points_.count, length = padded(count);
  transport::for_each_column(from, points_, [&](const auto* source, auto* column) {
    std::fill_n(column + first, length, source[i]);
  });
  points_.count += length;
  if (ranges_.empty() || ranges_.back().bsdf != &bsdf) ranges_.push_back({&bsdf, first, 0});
  ranges_.back().count += length;
  return first;
}

void RepeatedPoints::shade(const BsdfQuery& query, const BsdfAnswer& answer) const {
  for (const Range& range : ranges_) {
    range.bsdf->shade_block(points_.part(range.first, range.count), query.from(range.first),
                            answer.from(range.first));
  }
}

}  // namespace kinome
