#include "transport/paths/paths.h"

#include <algorithm>

#include "kinome/wide/vectors.h"
#include "transport/paths/coverage.h"

namespace kinome::transport {

using namespace wide;

Paths::Paths(const SceneTable& scene, const Sampler& sampler, const PathSettings& settings,
             size_t rays)
    : scene_(scene),
      length_(settings.length),
      hides_environment_(transport::hides_environment(settings, scene.scene())),
      light_(scene, sampler, LightSamples{}, rays),
      arena_(Surfaces::max_points(scene, rays)),
      owner_{arena_.indices(), arena_.indices()},
      throughput_{arena_.three(), arena_.three()},
      straight_(arena_.floats()) {
  const bool meets_light = scene.scene().environment() || scene.scene().has_surface_emitters();
  if (!scene.has_null_lobe() || !meets_light || length_.max_depth <= 2) return;
  for (Origins& origins : origins_) {
    origins = {arena_.three(), arena_.floats(), arena_.floats()};
  }
}

/// Adds direct light at points that are `depth` edges from the camera, and traces the next edges.
void Paths::extend(const PixelSamples& samples, const Vertices& vertices, uint32_t depth,
                   const RadianceByLength& light, RenderCounters& counters) {
  const Scene& scene = scene_.scene();
  // The last edge is the one to the light.
  const Columns3& radiance = depth < light.longest ? light.radiance : light.beyond;
  const bool is_last = depth + 1 >= length_.max_depth;
  const uint32_t first = kCameraDimensions + kPointDimensions * (depth - 1);
  const bool traces = !is_last || scene.has_surface_emitters();
  {
    const StageTimer timer(counters.stage_seconds["shade"]);
    std::optional<uint32_t> bsdf;
    if (traces || scene.environment()) bsdf = bsdf_dimension(depth);
    light_.sample(samples, vertices, first, bsdf);
    if (traces && depth >= length_.rr_depth) {
      light_.play_roulette(samples, vertices, first + 2 * DirectLight::kDimensions);
    }
  }
  add_emitter_samples(vertices, depth, light, counters);
  if (traces) {
    light_.trace(vertices, is_last ? Surfaces::Which::kEmitting : Surfaces::Which::kAll, radiance,
                 counters);
  } else if (scene.environment()) {
    light_.add_environment(vertices, radiance, counters);
  }
}

void Paths::add_emitter_samples(const Vertices& vertices, uint32_t depth,
                                const RadianceByLength& light, RenderCounters& counters) {
  // Each surface that light passes is an edge.
  const uint32_t max_passes = std::min(kMaxPasses, length_.max_depth - (depth + 1));
  if (!vertices.origins.pdf || max_passes == 0) {
    light_.add_emitter_samples(vertices, depth < light.longest ? light.radiance : light.beyond,
                               counters);
    return;
  }
  const float max_direct_passes = static_cast<float>(light.longest) - static_cast<float>(depth + 1);
  light_.add_passing_emitter_samples(
      vertices, {light.radiance, light.beyond, max_direct_passes, max_passes}, counters);
}

Origins Paths::first_origins(const Vertices& vertices, int buffer) const {
  const Origins& origins = origins_[buffer];
  if (!origins.pdf) return {};
  for_lanes(vertices.surfaces->reflecting(), [&](size_t i) {
    wide::Vec3(0.f).store(origins.p, i);
    Float(kInfinity).store(origins.pdf + i);
    Float(0.f).store(origins.passes + i);
  });
  return origins;
}

/// Returns the points that the BSDF samples of `vertices` hit.
Vertices Paths::next(const Vertices& vertices, int buffer) {
  const Surfaces& met = light_.met();
  const uint32_t* const ray = met.points().ray;
  for_lanes(met.reflecting(), [&](size_t i) {
    const Int from = as_int(gather(light_.from(), Int::load(ray + i)));
    gather(vertices.owner, from).store(owner_[buffer] + i);
    gather(light_.carried(), from).store(throughput_[buffer], i);
    if (!vertices.origins.pdf) return;
    const Origins& origins = light_.next_origins();
    gather(origins.p, from).store(origins_[buffer].p, i);
    gather(origins.pdf, from).store(origins_[buffer].pdf + i);
    gather(origins.passes, from).store(origins_[buffer].passes + i);
  });
  return {&met,
          owner_[buffer],
          throughput_[buffer],
          vertices.shown_share,
          vertices.shown_share_later,
          vertices.straight,
          origins_[buffer]};
}

void Paths::add(const PixelSamples& samples, const Surfaces& seen, const RadianceByLength& light,
                RenderCounters& counters) {
  Vertices vertices{&seen, seen.points().ray, {}};
  if (hides_environment_) {
    std::fill_n(straight_, samples.count(), 1.f);
    vertices.straight = straight_;
  }
  go_on(samples, vertices, 1, light, counters);
}

void Paths::go_on(const PixelSamples& samples, const Vertices& begin, uint32_t depth,
                  const RadianceByLength& light, RenderCounters& counters) {
  if (depth + 1 > length_.max_depth || scene_.scene().emitters().empty()) return;
  Vertices vertices = begin;
  vertices.origins = first_origins(begin, (depth + 1) % 2);
  for (; vertices.surfaces->reflecting() > 0; ++depth) {
    extend(samples, vertices, depth, light, counters);
    if (depth + 1 >= length_.max_depth) return;
    const StageTimer timer(counters.stage_seconds["bounce"]);
    vertices = next(vertices, depth % 2);
  }
}

}  // namespace kinome::transport
