#include "clustered/points/point_light_shader.h"

#include <algorithm>

#include "transport/camera.h"

namespace kinome {
namespace {

/// Number of dimensions of the sampler for mirror reflection, rounded up.
constexpr uint32_t kMirrorDimensions = 4;

}  // namespace

PointLightShader::PointLightShader(const transport::SceneTable& scene,
                                   const ScenePointLights& lights,
                                   const PointLightOptions& options, const Sampler& sampler,
                                   size_t rays)
    : lights_(lights),
      options_(options),
      has_mirrors_(std::any_of(
          scene.rows().begin(), scene.rows().end(),
          [](const auto& row) { return any(row.bsdf->lobes() & Lobe::kDelta); })),
      pairs_(scene.scene(), options.max_geometry_term),
      single_lights_(scene, sampler, rays),
      mirrors_(scene, sampler, rays),
      arena_(rays) {
  if (options.hide_emitters && scene.scene().environment()) straight_ = arena_.floats();
}

uint32_t PointLightShader::first_dimension(uint32_t depth) const {
  const size_t per_vertex =
      kMirrorDimensions + kChooseDimensions * lights_.sets.size() + 2 * lights_.others.size();
  return transport::kCameraDimensions + (depth - 1) * static_cast<uint32_t>(per_vertex);
}

/// Adds the light of points that are `depth` edges from the camera.
void PointLightShader::light_points(const PixelSamples& samples,
                                    const transport::Vertices& vertices, uint32_t depth,
                                    const Columns3& radiance, RenderCounters& counters) {
  const SurfaceBlock& points = vertices.surfaces->points();
  uint32_t dimension = first_dimension(depth) + kMirrorDimensions;
  for (size_t s = 0; s < lights_.sets.size(); ++s, dimension += kChooseDimensions) {
    const PointLightSet& set = lights_.sets[s];
    if (depth + (set.is_indirect ? 2 : 1) > options_.max_depth) continue;
    set.choose({samples, *vertices.surfaces, vertices.owner, dimension}, counters,
               [&](size_t i, const Bsdf& bsdf, const PointSelection& chosen) {
                 const Rgb weight = vertices.throughput.x ? vertices.throughput.at(i) : Rgb(1.f);
                 pairs_.add(points, i, bsdf, vertices.owner[i], weight, set.points, chosen,
                            radiance, counters);
               });
  }
  pairs_.finish(radiance, counters);
  single_lights_.add(samples, vertices, lights_.others, dimension, radiance, counters);
}

void PointLightShader::add(const PixelSamples& samples, const transport::Surfaces& seen,
                           const Columns3& radiance, RenderCounters& counters) {
  transport::Vertices vertices{&seen, seen.points().ray, {}};
  if (straight_) {
    std::fill_n(straight_, samples.count(), 1.f);
    vertices.straight = straight_;
  }
  for (uint32_t depth = 1; depth < options_.max_depth; ++depth) {
    if (vertices.surfaces->scattering() > 0) {
      light_points(samples, vertices, depth, radiance, counters);
    }
    if (!has_mirrors_ || vertices.surfaces->reflecting() == 0) return;
    vertices = mirrors_.reflect(samples, vertices, first_dimension(depth), radiance, counters);
  }
}

}  // namespace kinome
