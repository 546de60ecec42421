#pragma once

#include "clustered/points/light_cut.h"
#include "clustered/points/point_lights.h"
#include "clustered/points/repeated_points.h"
#include "kinome/sampler.h"
#include "transport/numbers.h"
#include "transport/shading.h"

namespace kinome {

/// Directions of the glossy lobes of points, as many of each as a sampler has samples, drawn for
/// several points at a time. One per thread.
class LobeSamples {
 public:
  /// Dimensions of the sampler that the directions of a point take.
  static constexpr uint32_t kDimensions = 4;

  explicit LobeSamples(const Sampler& sampler);

  void clear();
  bool has_room() const { return points_.room() >= padded(count_); }
  /// Adds point i, for the numbers of its sample; there must be room. Returns its number here.
  size_t add(const LitPoints& points, size_t i, const Bsdf& bsdf);
  /// Of all points that were added.
  void draw();
  /// Those of a point, in world space; those below the horizon are left out, as their light is
  /// (thesis, 4.2.2 covers the diffuse lobe by the horizon test instead).
  LobeDirections directions(size_t number) const;

 private:
  const Sampler& sampler_;
  size_t count_;  ///< directions of a point
  transport::Arena arena_;
  RepeatedPoints points_;
  float* u1_;
  Columns2 u2_;
  BsdfAnswer answer_;
  transport::Arena found_arena_;
  Columns3 found_;  ///< those of each point one after the other
  struct Point {
    size_t first;
    size_t found;
  };
  std::vector<Point> list_;
};

}  // namespace kinome
