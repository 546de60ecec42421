#include "transport/surfaces/surfaces.h"

#include <algorithm>

#include "kinome/wide/surface_point.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Sets points in media at the ends of rays, as described at `Surfaces`.
void find_collisions(const RayHit16* rays, const SurfaceBlock& points) {
  for_lanes(points.count, [&](size_t i) {
    const GatheredRays ray(rays, points.ray + i);
    const wide::Vec3 d = ray.d(), zero(0.f);
    (ray.o() + d * ray.tmax()).store(points.p, i);
    const auto frame = FrameOf<wide::Vec3>::from_normal(-d);
    frame.s.store(points.s, i), frame.t.store(points.t, i), frame.n.store(points.sn, i);
    wide::Vec3(0.f, 0.f, 1.f).store(points.wi, i);
    zero.store(points.n, i), zero.store(points.dp_du, i), zero.store(points.dp_dv, i);
    Float(0.f).store(points.uv.x + i), Float(0.f).store(points.uv.y + i);
    Float(0.f).store(points.p_error + i);
    Uint(0).store(points.primitive + i);
  });
}

}  // namespace

/// Each shape that is hit pads its range.
size_t Surfaces::max_points(const SceneTable& scene, size_t rays) {
  return padded(rays) + kBlockLanes * std::min(scene.rows().size(), rays);
}

Surfaces::Surfaces(const SceneTable& scene, size_t rays)
    : scene_(scene),
      per_point_(max_points(scene, rays)),
      per_ray_(rays),
      points_(per_point_.points()),
      live_(per_point_.floats()),
      row_(per_ray_.indices()),
      missed_(per_ray_.indices()),
      next_(scene.rows().size()) {}

/// Counting sort: counts the hits of each row, sets where its range begins, then places each ray.
void Surfaces::sort(const RayHit16* rays, size_t count, const uint32_t* row_of) {
  find_rows(rays, count, row_of);
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
  write_rays(count);
  for (size_t i = missed_count_; missed_count_ > 0 && i < padded(missed_count_); ++i) {
    missed_[i] = missed_[missed_count_ - 1];
  }
}

/// Sets the row of each ray: rows().size() if it hit a surface that isn't requested, one more if it
/// hit nothing. Most vectors of rays hit a single shape or nothing.
void Surfaces::find_rows(const RayHit16* rays, size_t count, const uint32_t* row_of) {
  const auto no_row = static_cast<uint32_t>(scene_.rows().size());
  next_.clear();
  for_lanes(count, [&](size_t i) {
    const Uint shape = Uint::load(rays[i / 16].shape + i % 16);
    const Mask hit = (shape != kNoHit) & first_lanes(count - i);
    Uint row = no_row + 1;
    if (any(hit)) row = select(hit, gather(row_of, as_int(select(hit, shape))), row);
    row.store(row_ + i);
    const uint32_t first = row_[i];
    if (all(row == first)) {
      if (first < no_row) next_.add(first, kLanes);
      return;
    }
    for (size_t k = i; k < i + kLanes; ++k) {
      if (row_[k] < no_row) next_.add(row_[k]);
    }
  });
}

void Surfaces::write_rays(size_t count) {
  const auto no_row = static_cast<uint32_t>(scene_.rows().size());
  missed_count_ = 0;
  for_lanes(count, [&](size_t i) {
    const Uint row = Uint::load(row_ + i), ray = as_uint(iota()) + static_cast<uint32_t>(i);
    Mask left = first_lanes(count - i);
    const Mask missed = left & (row == no_row + 1);
    missed_count_ += store_selected(missed, ray, missed_ + missed_count_);
    left &= row < no_row;  // One row at a time, because a vector has few.
    while (any(left)) {
      const uint32_t one = row_[i + first_true(left)];
      const Mask of_row = left & (row == one);
      next_[one] +=
          static_cast<uint32_t>(store_only_selected(of_row, ray, points_.ray + next_[one]));
      left &= !of_row;
    }
  });
}

void Surfaces::find(const RayHit16* rays, size_t count, Which which) {
  find(rays, count,
       which == Which::kAll        ? scene_.row_of()
       : which == Which::kEmitting ? scene_.emitting_row_of()
                                   : scene_.passing_row_of());
}

void Surfaces::find(const RayHit16* rays, size_t count, const uint32_t* row_of) {
  sort(rays, count, row_of);
  for (const Range& range : ranges_) {
    const size_t end = range.first + range.count, last = range.first + padded(range.count);
    std::fill(live_ + range.first, live_ + end, 1.f);
    std::fill(live_ + end, live_ + last, 0.f);
    std::fill(points_.ray + end, points_.ray + last, points_.ray[end - 1]);
    std::fill(points_.shape + range.first, points_.shape + last, range.row->shape);
    const SurfaceBlock points = points_.part(range.first, range.count);
    if (range.row->shape) {
      range.row->shape->interaction_block(rays, points);
    } else {
      find_collisions(rays, points);
    }
    repeat_last(range);
  }
}

/// Fills the padding with valid points, because BSDFs are called for all ranges of one material at
/// once, with the padding between them.
void Surfaces::repeat_last(const Range& range) {
  const size_t end = range.first + range.count, last = range.first + padded(range.count);
  for_each_column(points_, points_, [&](const auto*, auto* column) {
    std::fill(column + end, column + last, column[end - 1]);
  });
}

}  // namespace kinome::transport
