/// Path tracing from the camera, as Mitsuba's `path`: at every surface point, light straight from
/// the emitters, by emitter sampling and BSDF sampling combined by the power heuristic (Veach 1997,
/// 9.2.4 and 10.3.3); the BSDF sample is also the next edge. All emitters are found, save that
/// light of a point or a direction is not seen in mirrors. Many paths go on together, one edge at a
/// time, so that rays are traced in batches.
///
///     <integrator type="path"><integer name="max_depth" value="8"/></integrator>

#include <vector>

#include "direct_light.h"
#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "path_parameters.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    KINOME_PATH_PARAMETERS,
    {"hide_emitters", ParameterType::kBoolean, "false",
     "The camera sees no light itself: it looks through surfaces that emit, at a black sky."},
};

/// Dimensions of the sampler for a surface point: an emitter sample, a BSDF sample, the roulette.
constexpr uint32_t kPointDimensions = 2 * kLightDimensions + 1;

struct Settings {
  PathLength length;
  bool hide_emitters;
};

/// What one thread works with; kept from batch to batch.
class PathTracer {
 public:
  void trace(const Settings& settings, const Scene& scene, const Sampler& sampler,
             const PrimaryBatch& primary, std::span<Rgb> radiance, RenderCounters& counters);

 private:
  void play_roulette(const Sampler& sampler, uint32_t dimension);
  void extend_paths(const Settings& settings, const DirectLight::Context& context, uint32_t depth,
                    std::span<Rgb> radiance);

  DirectLight light_;
  std::vector<ShadingPoint> points_;  ///< where the paths that go on have come to
  std::vector<ShadingPoint> next_points_;
  /// The surfaces of points_ and of next_points_, from the second point of a path on.
  std::vector<SurfaceInteraction> surfaces_;
  std::vector<SurfaceInteraction> next_surfaces_;
};

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
void PathTracer::extend_paths(const Settings& settings, const DirectLight::Context& context,
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

void PathTracer::trace(const Settings& settings, const Scene& scene, const Sampler& sampler,
                       const PrimaryBatch& primary, std::span<Rgb> radiance,
                       RenderCounters& counters) {
  if (settings.length.max_depth == 1 || scene.emitters().empty()) return;
  const DirectLight::Context context{scene, sampler, counters};
  collect_shading_points(primary, points_);
  for (uint32_t depth = 1; !points_.empty(); ++depth) {
    extend_paths(settings, context, depth, radiance);
  }
}

class PathIntegrator final : public Integrator {
 public:
  explicit PathIntegrator(const Properties& props)
      : settings_{PathLength(props), props.boolean("hide_emitters")} {}

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (scene.emitters().empty()) context.skip("paths", "the scene has no emitters");
    shade_primary_rays(
        scene, sensor, context, settings_.hide_emitters,
        [&](const PrimaryBatch& primary, std::span<Rgb> radiance, RenderCounters& counters) {
          thread_local PathTracer tracer;
          tracer.trace(settings_, scene, sensor.sampler(), primary, radiance, counters);
        });
  }

 private:
  Settings settings_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::PathIntegrator, kinome::Category::kIntegrator, "path",
              "Path tracing from the camera with multiple importance sampling: light after any "
              "number of bounces.",
              kinome::kTable);
