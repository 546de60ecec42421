#pragma once

#include "clustered/points/light_cut.h"
#include "clustered/points/point_lights.h"
#include "clustered/points/repeated_points.h"
#include "kinome/sampler.h"
#include "transport/blocks/numbers.h"
#include "transport/surfaces/shading.h"

namespace kinome {

/// Directions sampled from the glossy lobes of points, for several points at a time. Each point
/// gets as many as the sampler has samples. Not thread-safe: use one per thread.
class LobeSamples {
 public:
  /// Dimensions of the sampler that the directions of a point take.
  static constexpr uint32_t kDimensions = 4;

  explicit LobeSamples(const Sampler& sampler);

  void clear();
  bool has_room() const { return points_.room() >= padded(count_); }
  /// Adds point i, with the random numbers of its sample. Requires has_room(). Returns the point's
  /// number here.
  size_t add(const LitPoints& points, size_t i, const Bsdf& bsdf);
  /// Samples the directions of all added points.
  void draw();
  /// Returns the directions of a point, world space. Those below the horizon are left out, as is
  /// light from there. (In the thesis, 4.2.2, the horizon test covers the diffuse lobe instead.)
  LobeDirections directions(size_t number) const;

 private:
  const Sampler& sampler_;
  size_t count_;  ///< number of directions of a point
  transport::Arena arena_;
  RepeatedPoints points_;
  float* u1_;
  Columns2 u2_;
  BsdfAnswer answer_;
  transport::Arena found_arena_;
  Columns3 found_;  ///< valid directions, those of each point in succession
  struct Point {
    size_t first;
    size_t found;
  };
  std::vector<Point> list_;
};

}  // namespace kinome
