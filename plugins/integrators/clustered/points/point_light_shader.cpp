#include "clustered/points/point_light_shader.h"

#include <algorithm>

#include "kinome/wide/vectors.h"
#include "transport/camera.h"

namespace kinome {

using transport::Vertices;

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
      mirrors_(scene, sampler, {0, 1, Lobe::kDelta}, rays),
      arena_(rays),
      per_point_(transport::Surfaces::most_points(scene, rays)),
      owner_{per_point_.indices(), per_point_.indices()},
      throughput_{per_point_.three(), per_point_.three()} {
  if (options.hide_emitters && scene.scene().environment()) straight_ = arena_.floats();
}

uint32_t PointLightShader::first_dimension(uint32_t depth) const {
  const size_t per_vertex =
      kMirrorDimensions + kChooseDimensions * lights_.sets.size() + 2 * lights_.others.size();
  return transport::kCameraDimensions + (depth - 1) * static_cast<uint32_t>(per_vertex);
}

/// Adds the light of points that are `depth` edges from the camera.
void PointLightShader::light_points(const PixelSamples& samples, const Vertices& vertices,
                                    uint32_t depth, const Columns3& radiance,
                                    RenderCounters& counters) {
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

/// Adds the emitted light that perfect mirrors among `vertices` reflect, to which light points can't
/// contribute. Returns the surfaces that they reflect.
Vertices PointLightShader::reflect(const PixelSamples& samples, const Vertices& vertices,
                                   uint32_t dimension, const Columns3& radiance,
                                   RenderCounters& counters) {
  using namespace wide;
  {
    const StageTimer timer(counters.stage_seconds["shade"]);
    mirrors_.sample(samples, vertices, std::nullopt, dimension);
  }
  mirrors_.trace(vertices, transport::Surfaces::Which::kAll, radiance, counters);
  const StageTimer timer(counters.stage_seconds["bounce"]);
  const transport::Surfaces& met = mirrors_.met();
  current_ = 1 - current_;
  Vertices next{&met, owner_[current_], throughput_[current_]};
  next.straight = vertices.straight;
  for_lanes(met.reflecting(), [&](size_t i) {
    const Int from = as_int(gather(mirrors_.from(), Int::load(met.points().ray + i)));
    gather(vertices.owner, from).store(owner_[current_] + i);
    gather(mirrors_.carried(), from).store(next.throughput, i);
  });
  return next;
}

void PointLightShader::add(const PixelSamples& samples, const transport::Surfaces& seen,
                           const Columns3& radiance, RenderCounters& counters) {
  Vertices vertices{&seen, seen.points().ray, {}};
  if (straight_) {
    std::fill_n(straight_, samples.count(), 1.f);
    vertices.straight = straight_;
  }
  for (uint32_t depth = 1; depth < options_.max_depth; ++depth) {
    if (vertices.surfaces->scattering() > 0) {
      light_points(samples, vertices, depth, radiance, counters);
    }
    if (!has_mirrors_ || vertices.surfaces->reflecting() == 0) return;
    vertices = reflect(samples, vertices, first_dimension(depth), radiance, counters);
  }
}

}  // namespace kinome
