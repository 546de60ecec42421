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
  const auto repeat = [&](const auto* source, auto* column) {
    std::fill_n(column + first, length, source[i]);
  };
  const auto repeat_three = [&](const Columns3& source, const Columns3& columns) {
    repeat(source.x, columns.x), repeat(source.y, columns.y), repeat(source.z, columns.z);
  };
  repeat_three(from.p, points_.p), repeat_three(from.n, points_.n);
  repeat_three(from.s, points_.s), repeat_three(from.t, points_.t);
  repeat_three(from.sn, points_.sn), repeat_three(from.wi, points_.wi);
  repeat_three(from.dp_du, points_.dp_du), repeat_three(from.dp_dv, points_.dp_dv);
  repeat(from.uv.x, points_.uv.x), repeat(from.uv.y, points_.uv.y);
  repeat(from.p_error, points_.p_error);
  repeat(from.primitive, points_.primitive), repeat(from.ray, points_.ray);
  repeat(from.shape, points_.shape);
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
