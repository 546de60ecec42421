#pragma once

#include <span>
#include <vector>

#include "arena.h"
#include "bucket_counts.h"
#include "scene_table.h"

namespace kinome::transport {

/// What the rays of a block hit: points sorted by material and shape. The points of a shape are a
/// range that begins at a multiple of 16; the rest of its last vector repeats its last point. Keeps
/// its memory from block to block: make one per thread. Not thread-safe.
class Surfaces {
 public:
  /// Points first … first + count - 1, of one shape.
  struct Range {
    const SceneTable::Row* row;
    size_t first;
    size_t count;
  };
  enum class Which { kAll, kEmitting, kPassing };

  /// Points that `rays` rays may make, padding included: where each hits a shape of its own.
  /// Columns of so many take memory only as far as blocks come to fill them (arena.h).
  static size_t most_points(const SceneTable& scene, size_t rays);

  /// For blocks of at most `rays` rays.
  Surfaces(const SceneTable& scene, size_t rays);

  /// Of `count` rays that have been traced: those that hit any surface, one that emits, or one that
  /// passes light straight.
  void find(const RayHit16* rays, size_t count, Which which);

  /// All points, count including the padding between ranges.
  const SurfaceBlock& points() const { return points_; }
  std::span<const Range> ranges() const { return ranges_; }
  /// Of points that scatter light: a prefix of those that reflect; a multiple of 16.
  size_t scattering() const { return scattering_; }
  /// Of points that reflect: a prefix of all; a multiple of 16.
  size_t reflecting() const { return reflecting_; }
  /// 1 where a point is one, 0 where it is padding.
  const float* live() const { return live_; }
  /// How many of the points that reflect are no padding.
  size_t live_reflecting() const { return live_reflecting_; }
  /// Numbers of the rays that left the scene; padded with the last.
  std::span<const uint32_t> missed() const { return {missed_, missed_count_}; }

 private:
  void sort(const RayHit16* rays, size_t count, Which which);
  void find_rows(const RayHit16* rays, size_t count, Which which);
  void place_rays(size_t count);
  void repeat_last(const Range& range);
  const SceneTable& scene_;
  Arena per_point_;
  Arena per_ray_;
  SurfaceBlock points_;
  float* live_;
  uint32_t* row_;  ///< of each ray
  uint32_t* missed_;
  size_t missed_count_ = 0;
  size_t scattering_ = 0;
  size_t reflecting_ = 0;
  size_t live_reflecting_ = 0;
  BucketCounts next_;  ///< of each row: hits, then the place of the next
  std::vector<Range> ranges_;
};

}  // namespace kinome::transport
