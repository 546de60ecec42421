#pragma once

#include "clustered/points/point_lights.h"
#include "kinome/primary_rays.h"

namespace kinome {

/// Memory that a thread keeps from batch to batch.
struct PointLightScratch {
  PointSelection selection;
  std::vector<Ray> rays;  ///< waiting shadow rays, and whom they are for
  std::vector<uint32_t> owner;
  std::vector<Rgb> contribution;

  /// Rays into mirrors, and what they will count.
  struct Reflected {
    RayHit ray;
    uint32_t owner;
    Rgb weight;
  };
  std::vector<Reflected> reflected, traced;
  std::vector<RayHit> hits;
};

/// Shades a batch of primary rays.
class PointLightShader {
 public:
  PointLightShader(const Scene& scene, const ScenePointLights& lights,
                   const PointLightOptions& options, const Sampler& sampler,
                   const PrimaryBatch& primary, std::span<Rgb> radiance, RenderCounters& counters,
                   PointLightScratch& scratch);
  void shade_all();

 private:
  /// A surface seen by primary sample `owner`, directly or by way of mirrors.
  struct Vertex {
    const SurfaceInteraction& si;
    uint32_t owner;
    uint32_t depth;  ///< segments from the camera
    Rgb weight;
  };

  void shade(const Vertex& vertex);
  void evaluate(const Vertex& vertex, const PointLightSet& set, size_t first, size_t count);
  void sample_others(const Vertex& vertex);
  void reflect(const Vertex& vertex);
  void trace_reflected(uint32_t depth);
  uint32_t first_dimension(uint32_t depth) const;
  void add_shadow_ray(const Vertex& vertex, const Vec3& d, float distance, const Rgb& contribution);
  void trace_shadow_rays();
  void clear();

  const Scene& scene_;
  const ScenePointLights& lights_;
  const PointLightOptions& options_;
  const Sampler& sampler_;
  const PrimaryBatch& primary_;
  const std::span<Rgb> radiance_;
  RenderCounters& counters_;
  PointLightScratch& s_;
  double& evaluate_seconds_;
  double& shadow_seconds_;
};

}  // namespace kinome
