#pragma once

#include "clustered/points/point_selection.h"
#include "clustered/points/repeated_points.h"
#include "kinome/light_points.h"
#include "kinome/scene.h"
#include "transport/shadows/occlusion.h"

namespace kinome {

/// Pairs of surface points and light points: the light that each surface point reflects from its
/// light points, and a shadow ray for each pair with light. Processes about 2000 pairs at a time.
/// Not thread-safe: use one per thread.
class LightPairs {
 public:
  /// `max_geometry_term`: see PointLightOptions.
  LightPairs(const Scene& scene, float max_geometry_term);

  /// Adds light from the light points chosen for point i of `points`, whose material is `bsdf`,
  /// times `weight`, to the radiance of sample `owner`. The last pairs are added by finish().
  void add(const SurfaceBlock& points, size_t i, const Bsdf& bsdf, uint32_t owner,
           const Rgb& weight, const LightPoints& lights, const PointSelection& chosen,
           const Columns3& radiance, RenderCounters& counters);
  void finish(const Columns3& radiance, RenderCounters& counters);

 private:
  static constexpr size_t kCapacity = 2048;

  void see(const LightPoints& lights, const Rgb& weight, size_t first, size_t count);
  void see_distant(const LightPoints& lights, const Rgb& weight, size_t first, size_t count);
  void see_local(const LightPoints& lights, const Rgb& weight, size_t first, size_t count);
  void find_intensities(const LightPoints& lights, size_t first, size_t count);
  void find_origins(const LightPoints& lights, size_t first, size_t count);

  const Scene& scene_;
  const float max_geometry_term_;
  transport::Arena arena_;
  RepeatedPoints points_;
  uint32_t* owner_;
  uint32_t* light_;  ///< index of the light point
  float* share_;     ///< weight of the light point
  float* live_;      ///< 1, or 0 if the pair is padding
  Columns3 d_;       ///< toward the light
  float* distance_;
  Columns3 arriving_;  ///< factor of f cos; after shading, the reflected light
  Columns3 wo_;
  BsdfAnswer answer_;
  Ray16* rays_;
  transport::Occlusion occlusion_;
};

}  // namespace kinome
