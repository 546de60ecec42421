#include "surfaces.h"

#include <algorithm>

namespace kinome::transport {

/// Each shape that is hit pads its range.
size_t Surfaces::most_points(const SceneTable& scene, size_t rays) {
  return padded(rays) + kBlockLanes * std::min(scene.rows().size(), rays);
}

Surfaces::Surfaces(const SceneTable& scene, size_t rays)
    : scene_(scene),
      per_point_(most_points(scene, rays)),
      per_ray_(rays),
      points_(per_point_.points()),
      live_(per_point_.floats()),
      row_(per_ray_.indices()),
      missed_(per_ray_.indices()),
      next_(scene.rows().size()) {}

/// By counting: how many hits each row has, where its range begins, then each ray to its place.
void Surfaces::sort(const RayHit16* rays, size_t count, Which which) {
  const auto rows = static_cast<uint32_t>(scene_.rows().size());
  const uint32_t missed = rows, left_out = rows + 1;
  next_.clear();
  for (size_t i = 0; i < count; ++i) {
    const uint32_t shape = rays[i / 16].shape[i % 16];
    uint32_t row = shape == kNoHit ? missed : scene_.row_of(shape);
    if (which == Which::kEmitting && row < rows && !scene_.rows()[row].emitter) row = left_out;
    row_[i] = row;
    if (row < rows) next_.add(row);
  }
  ranges_.clear();
  scattering_ = reflecting_ = 0;
  live_reflecting_ = 0;
  uint32_t at = 0;
  for (const uint32_t row : next_.used()) {
    const uint32_t hits = next_[row];
    next_[row] = at;
    ranges_.push_back({&scene_.rows()[row], at, hits});
    at += static_cast<uint32_t>(padded(hits));
    if (row >= scene_.reflecting()) continue;
    reflecting_ = at;
    if (row < scene_.scattering()) scattering_ = at;
    live_reflecting_ += hits;
  }
  points_.count = at;
  missed_count_ = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t row = row_[i];
    if (row < rows) {
      points_.ray[next_[row]++] = i;
    } else if (row == missed) {
      missed_[missed_count_++] = i;
    }
  }
  for (size_t i = missed_count_; missed_count_ > 0 && i < padded(missed_count_); ++i) {
    missed_[i] = missed_[missed_count_ - 1];
  }
}

void Surfaces::find(const RayHit16* rays, size_t count, Which which) {
  sort(rays, count, which);
  for (const Range& range : ranges_) {
    const size_t end = range.first + range.count, last = range.first + padded(range.count);
    std::fill(live_ + range.first, live_ + end, 1.f);
    std::fill(live_ + end, live_ + last, 0.f);
    std::fill(points_.ray + end, points_.ray + last, points_.ray[end - 1]);
    std::fill(points_.shape + range.first, points_.shape + last, range.row->shape);
    range.row->shape->interaction_block(rays, points_.part(range.first, range.count));
    repeat_last(range);
  }
}

/// Points of one material are asked for together, with what lies between their ranges: that must be
/// points, too.
void Surfaces::repeat_last(const Range& range) {
  const size_t end = range.first + range.count, last = range.first + padded(range.count);
  const auto repeat = [&](auto* column) { std::fill(column + end, column + last, column[end - 1]); };
  for (const Columns3& c : {points_.p, points_.n, points_.s, points_.t, points_.sn, points_.dp_du,
                            points_.dp_dv, points_.wi}) {
    repeat(c.x), repeat(c.y), repeat(c.z);
  }
  repeat(points_.uv.x), repeat(points_.uv.y);
  repeat(points_.p_error);
  repeat(points_.primitive);
}

}  // namespace kinome::transport
