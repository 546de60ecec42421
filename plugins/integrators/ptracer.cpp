/// Light tracing, as Mitsuba's `ptracer`: paths begin at emitters, and every surface point that
/// they come to is connected to the sensor (Veach 1997, 10.1; Dutré and Willems 1994). It finds
/// what paths from the camera hardly do, such as the light of a spot after one bounce, and misses
/// what is seen in mirrors. An environment lights the scene, yet is itself black to the camera, as
/// in Mitsuba: no light path comes from there to the lens. A film's alpha stays 0. Where
/// a normal map tilts so far that it is turned toward the viewer (`flip_invalid_normals`), what
/// mirrors below it send to where its turned normal is seen is missing.
///
///     <integrator type="ptracer"><integer name="max_depth" value="3"/></integrator>

#include <vector>

#include "kinome/adjoint.h"
#include "kinome/integrator.h"
#include "kinome/plugin.h"
#include "kinome/primary_rays.h"
#include "path_parameters.h"
#include "stages.h"

namespace kinome {
namespace {

constexpr Parameter kTable[] = {
    KINOME_PATH_PARAMETERS,
    {"hide_emitters", ParameterType::kBoolean, "false",
     "Light itself is black to the camera, and hides what lies behind it."},
};

/// Light paths traced together: what fits the caches.
constexpr uint32_t kPaths = 2048;
/// Light paths between two passes: bounds the memory of splats that wait for their turn.
constexpr uint64_t kPassPaths = uint64_t{1} << 20;

/// Dimensions of the sampler: which emitter, where, whereto, the lens; then for each surface point
/// the lens, the lobe, whereto, the roulette.
constexpr uint32_t kEmissionDimensions = 7;
constexpr uint32_t kPointDimensions = 6;

struct Settings {
  PathLength length;
  bool hide_emitters;
};

/// What one thread works with; kept from tile to tile.
class LightTracer {
 public:
  /// What is the same for all paths.
  struct Context {
    const Settings& settings;
    const Scene& scene;
    const Sensor& sensor;
    uint64_t seed;
  };
  /// Traces samples [first_sample, first_sample + samples) of each of the tile's pixels. A light
  /// path has nothing to do with the pixel that numbers it.
  void trace(const Context& context, uint32_t first_sample, uint32_t samples, Tile& tile);

 private:
  /// A path on its way.
  struct LightPath {
    SampleKey key;
    Rgb power{0.f};             ///< that arrives at the next point [W]
    float inverse_emitted = 0;  ///< 1 / the largest channel of what it began with
  };
  struct Splat {
    Vec2 position;
    Rgb value;
  };

  void emit(const Context& context, RenderCounters& counters);
  void splat_emitter(const Context& context, const Emitter& emitter, const Vec2& place,
                     const Vec2& aperture, RenderCounters& counters);
  void splat_point(const Context& context, const SurfaceInteraction& si, const LightPath& path,
                   uint32_t dimension, RenderCounters& counters);
  bool scatter(const Context& context, const SurfaceInteraction& si, uint32_t depth,
               uint32_t dimension, LightPath& path, Ray& ray) const;
  void trace_splats(const Scene& scene, Tile& tile);
  void extend_paths(const Context& context, uint32_t depth, Tile& tile);

  std::vector<LightPath> paths_;
  std::vector<RayHit> rays_;  ///< of each path, to its next point
  std::vector<Ray> shadow_rays_;
  std::vector<Splat> splats_;  ///< what arrives if nothing is in the way
};

/// The light that leaves an emitting surface straight toward the lens.
void LightTracer::splat_emitter(const Context& context, const Emitter& emitter, const Vec2& place,
                                const Vec2& aperture, RenderCounters& counters) {
  const Shape& shape = *emitter.shape();
  SurfaceInteraction si = shape.sample_surface(place);
  const auto connection = context.sensor.connect(si.p, aperture);
  if (!connection) return;
  si.wi = si.frame.to_local(connection->d);
  const float emitters = static_cast<float>(context.scene.emitters().size());
  const Rgb value = emitter.eval_surface(si) * (std::abs(glm::dot(si.n, connection->d)) *
                                                shape.area() * emitters * connection->weight);
  if (is_black(value)) return;
  ++counters[RayKind::kShadow];
  shadow_rays_.push_back(si.shadow_ray(connection->d, connection->distance));
  splats_.push_back({connection->film_position, value});
}

/// First edges of paths_, whose keys are set.
void LightTracer::emit(const Context& context, RenderCounters& counters) {
  const auto& emitters = context.scene.emitters();
  const Sampler& sampler = context.sensor.sampler();
  const auto count = static_cast<float>(emitters.size());
  const bool show_emitters = !context.settings.hide_emitters;
  const bool go_on = context.settings.length.max_depth > 1;
  rays_.clear();
  for (LightPath& path : paths_) {
    const auto pick = static_cast<size_t>(sampler.value_1d(path.key, 0) * count);
    const Emitter& emitter = *emitters[std::min(pick, emitters.size() - 1)];
    const Vec2 place = sampler.value_2d(path.key, 1);
    if (show_emitters && emitter.is_surface()) {
      splat_emitter(context, emitter, place, sampler.value_2d(path.key, 5), counters);
    }
    if (!go_on) continue;
    const auto emission = emitter.sample_emission(place, sampler.value_2d(path.key, 3));
    if (!emission || !(max_component(emission->power) > 0)) continue;
    path.power = emission->power * count;
    path.inverse_emitted = 1 / max_component(path.power);
    paths_[rays_.size()] = path;
    rays_.push_back({emission->ray(), Hit{}});
  }
  paths_.resize(rays_.size());
}

/// The light that a surface point scatters toward the lens.
void LightTracer::splat_point(const Context& context, const SurfaceInteraction& si,
                              const LightPath& path, uint32_t dimension, RenderCounters& counters) {
  const auto seen = connect_point(context.sensor, si,
                                  context.sensor.needs_aperture_sample()
                                      ? context.sensor.sampler().value_2d(path.key, dimension)
                                      : Vec2(0.5f));
  if (!seen) return;
  if (is_black(seen->factor)) {
    ++counters.skipped_shadow_rays;
    return;
  }
  ++counters[RayKind::kShadow];
  shadow_rays_.push_back(seen->shadow_ray);
  splats_.push_back({seen->film_position, path.power * seen->factor});
}

/// The next edge of a path that has come to si; false where the path ends.
bool LightTracer::scatter(const Context& context, const SurfaceInteraction& si, uint32_t depth,
                          uint32_t dimension, LightPath& path, Ray& ray) const {
  const Sampler& sampler = context.sensor.sampler();
  const auto sample = sample_adjoint(si, Lobe::kAll, sampler.value_1d(path.key, dimension + 2),
                                     sampler.value_2d(path.key, dimension + 3));
  if (!sample) return false;
  path.power *= sample->weight;
  if (!(max_component(path.power) > 0)) return false;
  if (depth >= context.settings.length.rr_depth) {
    const float survival = survival_probability(path.power * path.inverse_emitted);
    if (sampler.value_1d(path.key, dimension + 5) >= survival) return false;
    path.power /= survival;
  }
  ray = si.shadow_ray(sample->to, kInfinity);
  return true;
}

void LightTracer::trace_splats(const Scene& scene, Tile& tile) {
  const StageTimer timer(tile.counters.stage_seconds["shadow"]);
  scene.occluded(shadow_rays_, Coherence::kIncoherent, tile.counters);
  for (size_t k = 0; k < splats_.size(); ++k) {
    if (!shadow_rays_[k].is_occluded()) tile.film.add_splat(splats_[k].position, splats_[k].value);
  }
  shadow_rays_.clear();
  splats_.clear();
}

/// From their rays to surface points, the depth-th of each path, and on.
void LightTracer::extend_paths(const Context& context, uint32_t depth, Tile& tile) {
  {
    const StageTimer timer(tile.counters.stage_seconds["bounce"]);
    context.scene.intersect(rays_, Coherence::kIncoherent, tile.counters);
    tile.counters[RayKind::kLight] += rays_.size();
  }
  const StageTimer timer(tile.counters.stage_seconds["shade"]);
  const bool is_last = depth + 2 > context.settings.length.max_depth;
  const uint32_t dimension = kEmissionDimensions + kPointDimensions * (depth - 1);
  size_t count = 0;
  for (size_t i = 0; i < paths_.size(); ++i) {
    if (!rays_[i].hit.valid()) continue;
    const SurfaceInteraction si = context.scene.interaction(rays_[i]);
    LightPath& path = paths_[i];
    splat_point(context, si, path, dimension, tile.counters);
    Ray ray;
    if (is_last || !scatter(context, si, depth, dimension, path, ray)) continue;
    paths_[count] = path;
    rays_[count++] = {ray, Hit{}};
  }
  paths_.resize(count);
  rays_.resize(count);
}

void LightTracer::trace(const Context& context, uint32_t first_sample, uint32_t samples,
                        Tile& tile) {
  // Splats are left over only where an earlier render on this thread threw.
  shadow_rays_.clear(), splats_.clear();
  paths_.clear();
  const Rect& pixels = tile.pixels;
  for (int y = pixels.y0; y < pixels.y1; ++y) {
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      for (uint32_t s = first_sample; s < first_sample + samples; ++s) {
        paths_.push_back(
            {{static_cast<uint32_t>(x), static_cast<uint32_t>(y), s, context.seed}, Rgb(0.f), 0});
      }
    }
  }
  {
    const StageTimer timer(tile.counters.stage_seconds["emit"]);
    emit(context, tile.counters);
  }
  trace_splats(context.scene, tile);
  for (uint32_t depth = 1; !paths_.empty(); ++depth) {
    extend_paths(context, depth, tile);
    trace_splats(context.scene, tile);
  }
}

class LightTracingIntegrator final : public Integrator {
 public:
  explicit LightTracingIntegrator(const Properties& props)
      : settings_{PathLength(props), props.boolean("hide_emitters")} {}

  std::vector<Stage> stages() const override {
    return {{"emit", "sends light from the lamps"}, kBounceStage, kShadeStage, kShadowStage};
  }

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override {
    if (scene.emitters().empty()) {
      warn_without_emitters(scene);
      context.skip("light paths", "the scene has no emitters");
      return;
    }
    if (settings_.length.max_depth == 0) {
      context.skip("light paths", "max_depth is 0: the picture is black");
      return;
    }
    const LightTracer::Context tracing{settings_, scene, sensor,
                                       key_seed(context, sensor.sampler())};
    const uint32_t count = sensor.sampler().sample_count();
    Film& film = sensor.film();
    const auto pixels = static_cast<uint64_t>(std::max(1, film.crop().area()));
    const auto step = static_cast<uint32_t>(std::clamp<uint64_t>(kPassPaths / pixels, 1, count));
    for (uint32_t done = 0; done < count && !context.cancelled(); done += step) {
      const uint32_t of_pass = std::min(step, count - done);
      context.set_progress_range(static_cast<double>(done) / count,
                                 static_cast<double>(done + of_pass) / count);
      context.for_each_tile(film, [&](Tile& tile) {
        thread_local LightTracer tracer;
        for_each_part(tile.pixels, of_pass, kPaths, [&](uint32_t first, uint32_t samples) {
          tracer.trace(tracing, done + first, samples, tile);
        });
        // By each tile, so that a render that is cut short has the brightness of its paths so far.
        tile.film.add_light_paths(static_cast<double>(tile.pixels.area()) * of_pass);
      });
    }
    context.set_progress_range(0, 1);
  }

 private:
  Settings settings_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::LightTracingIntegrator, kinome::Category::kIntegrator, "ptracer",
              "Light tracing: paths from the emitters, each point of which is connected to the "
              "sensor.",
              kinome::kTable);
