#pragma once

#include <span>
#include <vector>

#include "transport/blocks/arena.h"
#include "transport/blocks/bucket_counts.h"
#include "transport/surfaces/scene_table.h"

namespace kinome::transport {

/// Hits of the rays of a block: points sorted by material and shape. The points of a shape are a
/// range that begins at a multiple of 16; the rest of its last vector repeats its last point.
/// Reuses its memory from block to block. Not thread-safe: use one per thread.
///
/// Points in media (SceneTable) have a normal n of 0, so that rays leave exactly from p, and a
/// shading frame around the direction to the ray's origin.
class Surfaces {
 public:
  /// Points first … first + count - 1, all on one shape.
  struct Range {
    const SceneTable::Row* row;
    size_t first;
    size_t count;
  };
  enum class Which { kAll, kEmitting, kPassing };

  /// Maximum number of points of `rays` rays, padding included: if each hits a different shape.
  /// Columns of this length take memory only as far as blocks use them (arena.h).
  static size_t max_points(const SceneTable& scene, size_t rays);

  /// Allocates memory for blocks of at most `rays` rays.
  Surfaces(const SceneTable& scene, size_t rays);

  /// Finds the points of `count` traced rays on all surfaces, on those that emit, or on those that
  /// pass light straight.
  void find(const RayHit16* rays, size_t count, Which which);
  /// The same for surfaces whose row is in `row_of`, a column like SceneTable::row_of().
  void find(const RayHit16* rays, size_t count, const uint32_t* row_of);

  /// All points; `count` includes the padding between ranges.
  const SurfaceBlock& points() const { return points_; }
  std::span<const Range> ranges() const { return ranges_; }
  /// Number of points that scatter light, a multiple of 16. They are the first points.
  size_t scattering() const { return scattering_; }
  /// Number of points that reflect light, a multiple of 16. They are the first points, and include
  /// those that scatter.
  size_t reflecting() const { return reflecting_; }
  /// 1 for points, 0 for padding.
  const float* live() const { return live_; }
  /// Number of points that reflect, without padding.
  size_t live_reflecting() const { return live_reflecting_; }
  /// Indices of the rays that left the scene; padded with the last one.
  std::span<const uint32_t> missed() const { return {missed_, missed_count_}; }

 private:
  void sort(const RayHit16* rays, size_t count, const uint32_t* row_of);
  void find_rows(const RayHit16* rays, size_t count, const uint32_t* row_of);
  void write_rays(size_t count);
  void repeat_last(const Range& range);
  const SceneTable& scene_;
  Arena per_point_;
  Arena per_ray_;
  SurfaceBlock points_;
  float* live_;
  uint32_t* row_;  ///< row of each ray's shape
  uint32_t* missed_;
  size_t missed_count_ = 0;
  size_t scattering_ = 0;
  size_t reflecting_ = 0;
  size_t live_reflecting_ = 0;
  BucketCounts next_;  ///< for each row: number of hits, then the position of the next
  std::vector<Range> ranges_;
};

}  // namespace kinome::transport
