#pragma once

#include <vector>

#include "kinome/stats.h"
#include "transport/media/tracking/random_seeds.h"
#include "transport/media/tracking/tracking.h"
#include "transport/surfaces/surfaces.h"

namespace kinome::transport {

/// Part of a path's edge that is in a uniform medium.
struct MediumLeg {
  uint32_t path;
  uint32_t medium;          ///< number in MediaTable
  kinome::Vec3 o{0.f}, d{0, 0, 1};  ///< d is a unit vector
  float length = 0;
  kinome::Rgb throughput{0.f};  ///< throughput at o
};

/// Columns of paths whose next edges are traced.
struct PathState {
  const uint32_t* owner;  ///< sample of the block
  uint32_t* medium;       ///< number of the medium (MediaTable) at the ray's origin
  Columns3 throughput;
  float* optical_depth;  ///< optical depth to the next collision
  /// Channel of the extinction that `optical_depth` refers to; nullptr unless media are coloured.
  uint32_t* channel;
  float* scatterings;  ///< number of points where the path was scattered
  /// If this isn't nullptr, paths don't collide: throughputs are multiplied by transmittances, and
  /// the legs are appended to this vector. All media must then be uniform, and optical depths and
  /// channels are ignored.
  std::vector<MediumLeg>* legs = nullptr;
};

/// Edges of paths through media: traces rays to the next point that isn't an index-matched
/// boundary. Not thread-safe: use one per thread.
///
/// Distances to collisions are sampled from the extinction of one channel, which is drawn in
/// proportion to the path's throughput. The throughput is divided by the mean density over all
/// channels, with the same weights (balance heuristic). So the sum of the channels doesn't depend
/// on the sampled distance, if the albedo is 1. Miller et al. 2019 draw one channel for the whole
/// path with equal probabilities; its posterior probabilities are equal to these weights if the
/// medium and the surfaces are grey otherwise. A new draw at each point needs no state, can't
/// overflow, and adapts to the remaining channels.
class Segments {
 public:
  /// Allocates memory for at most `rays` rays. With `hides_emitters`, rays of paths that were never
  /// scattered pass surfaces that emit.
  Segments(const SceneTable& scene, const MediaTable& media, bool hides_emitters, size_t rays);

  /// Finds the next point of each ray. tmin must be 0, and d a unit vector. Collisions are set as
  /// hits (SceneTable). Updates the throughput, and sets the medium to the one before the point.
  void trace(RayHit16* rays, size_t count, const PathState& state, const RandomSeeds& seeds,
             RayKind kind, RenderCounters& counters);

 private:
  void trace_leg(RayHit16* rays, size_t count, const uint32_t* path, const PathState& state,
                 const RandomSeeds& seeds, RayKind kind, RenderCounters& counters);
  wide::Float distance_to_collision(wide::Int k, const PathState& state) const;
  void set_collisions(RayHit16* rays, size_t count, const uint32_t* path,
                      const PathState& state) const;
  void list_legs(const RayHit16* rays, size_t count, const uint32_t* path,
                 const PathState& state) const;
  void track(RayHit16* rays, size_t count, const uint32_t* path, const PathState& state,
             const RandomSeeds& seeds);
  void redraw_channels(size_t count, const uint32_t* path, const PathState& state,
                       const RandomSeeds& seeds) const;
  static void drop(size_t count, const uint32_t* path, const PathState& state);
  size_t pass(const RayHit16* rays, size_t count, const uint32_t* path, int next,
              const PathState& state);

  const SceneTable& scene_;
  const MediaTable& media_;
  /// Row of each shape that rays pass; rows().size() for others.
  std::vector<uint32_t> passed_row_of_;
  bool passes_ = false;
  Arena per_ray_;
  float* far_;  ///< remaining length of each ray
  /// Continuations of rays behind boundaries, and the indices of their paths.
  RayHit16* beyond_[2];
  uint32_t* path_[2];
  uint32_t* position_;  ///< index of each path's ray, during track()
  Surfaces met_;
  Tracking tracking_;
};

}  // namespace kinome::transport
