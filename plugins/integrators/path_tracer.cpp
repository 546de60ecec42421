#include "path_tracer.h"

namespace kinome {
namespace {

/// Dimensions of the sampler for a surface point: an emitter sample, a BSDF sample, the roulette.
constexpr uint32_t kPointDimensions = 2 * kLightDimensions + 1;

}  // namespace

void PathTracer::play_roulette(const Sampler& sampler, uint32_t dimension) {
  std::vector<BsdfDirection>& directions = light_.directions();
  size_t count = 0;
  for (BsdfDirection direction : directions) {
    const float survival = survival_probability(direction.weight);
    if (sampler.value_1d(*points_[direction.point].key, dimension) >= survival) continue;
    direction.weight /= survival;
    directions[count++] = direction;
  }
  directions.resize(count);
}

/// From points_, which lie `depth` edges from the camera, to the next ones.
void PathTracer::extend_paths(const PathSettings& settings, const DirectLight::Context& context,
                              uint32_t depth, std::span<Rgb> radiance) {
  const Scene& scene = context.scene;
  auto& stages = context.counters.stage_seconds;
  const bool is_last = depth + 1 >= settings.length.max_depth;
  const uint32_t dimension = kPrimaryDimensions + kPointDimensions * (depth - 1);
  {
    const StageTimer timer(stages["shade"]);
    light_.begin(points_);
    light_.sample_emitters(context, dimension);
    if (!is_last || scene.has_surface_emitters()) {
      light_.sample_bsdfs(context, dimension + kLightDimensions);
      if (depth >= settings.length.rr_depth) {
        play_roulette(context.sampler, dimension + 2 * kLightDimensions);
      }
      light_.make_bsdf_rays(context);
    } else if (scene.environment()) {
      light_.sample_bsdfs(context, dimension + kLightDimensions);
      light_.find_environment(context);
    }
  }
  {
    const StageTimer timer(stages["shadow"]);
    light_.trace_shadow_rays(context, radiance);
  }
  const StageTimer timer(stages["bounce"]);
  if (is_last) {
    light_.trace_bsdf_rays(context, radiance);
    points_.clear();
    return;
  }
  next_surfaces_.clear();
  next_points_.clear();
  light_.trace_bsdf_rays(
      context, radiance, [this](const BsdfDirection& direction, const SurfaceInteraction& si) {
        if (si.shape->bsdf().lobes() == Lobe::kNone) return;
        const ShadingPoint& from = points_[direction.point];
        next_surfaces_.push_back(si);
        next_points_.push_back({nullptr, from.key, direction.weight, from.owner});
      });
  std::swap(points_, next_points_);
  std::swap(surfaces_, next_surfaces_);
  for (size_t i = 0; i < points_.size(); ++i) points_[i].si = &surfaces_[i];
}

void PathTracer::trace(const PathSettings& settings, const Scene& scene, const Sampler& sampler,
                       const PrimaryBatch& primary, const RadianceByLength& light,
                       RenderCounters& counters) {
  if (settings.length.max_depth < 2 || scene.emitters().empty()) return;
  const DirectLight::Context context{scene, sampler, counters};
  collect_shading_points(primary, points_);
  for (uint32_t depth = 1; !points_.empty(); ++depth) {
    // The last edge is the one to the light.
    extend_paths(settings, context, depth, depth < light.longest ? light.radiance : light.beyond);
  }
}

void render_paths(const PathSettings& settings, const Scene& scene, const Sensor& sensor,
                  RenderContext& context) {
  if (scene.emitters().empty()) context.skip("paths", "the scene has no emitters");
  if (settings.length.max_depth == 0) {
    context.skip("paths", "max_depth is 0: the picture is black");
    return;
  }
  shade_primary_rays(
      scene, sensor, context, settings.hide_emitters,
      [&](const PrimaryBatch& primary, std::span<Rgb> radiance, RenderCounters& counters) {
        thread_local PathTracer tracer;
        tracer.trace(settings, scene, sensor.sampler(), primary, {radiance, radiance}, counters);
      });
}

}  // namespace kinome
