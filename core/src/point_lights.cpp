#include "kinome/point_lights.h"

#include "point_light_shader.h"

namespace kinome {
namespace {

using Kind = LightPoints::Kind;

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// Points of one kind make one set, so that they share the cut; those with an emission of their own
/// stay by themselves.
void add_points(LightPoints points, bool is_indirect, std::vector<PointLightSet>& sets) {
  if (points.size() == 0) return;
  for (PointLightSet& set : sets) {
    if (set.points.kind != points.kind || set.is_indirect != is_indirect || points.emission ||
        set.points.emission) {
      continue;
    }
    append(set.points.position, points.position);
    append(set.points.normal, points.normal);
    append(set.points.power, points.power);
    append(set.points.extent, points.extent);
    return;
  }
  sets.push_back({std::move(points), is_indirect, {}});
}

}  // namespace

ScenePointLights gather_point_lights(const Scene& scene, RenderContext& context, uint32_t count,
                                     const PointLightOptions& options) {
  ScenePointLights lights;
  const auto is_wanted = [&](Kind kind) {
    return kind == Kind::kDistant ? options.distant : options.local;
  };
  for (const Emitter* emitter : scene.emitters()) {
    const Kind expected = emitter->is_environment() ? Kind::kDistant : Kind::kLocal;
    std::optional<LightPoints> points;
    if (is_wanted(expected)) points = emitter->light_points(scene, context, count);
    if (points && is_wanted(points->kind)) {
      // None at all: a light that is black.
      add_points(std::move(*points), false, lights.sets);
    } else {
      lights.others.push_back(emitter);
    }
  }
  if (options.max_depth < 3) {
    context.skip("indirect light", "max_depth is 2");
  } else if (!options.local) {
    context.skip("indirect light", "mode is 'distant'");
  } else {
    for (const Emitter* emitter : scene.indirect_emitters()) {
      auto points = emitter->light_points(scene, context, count);
      if (points) add_points(std::move(*points), true, lights.sets);
    }
  }
  return lights;
}

void render_point_lights(const Scene& scene, const Sensor& sensor, RenderContext& context,
                         const ScenePointLights& lights, const PointLightOptions& options) {
  Film& film = sensor.film();
  const Sampler& sampler = sensor.sampler();
  const uint64_t seed = key_seed(context, sampler);
  context.for_each_tile(film, [&](Tile& tile) {
    thread_local PointLightScratch scratch;
    double& primary_seconds = tile.counters.stage_seconds["primary"];
    double& film_seconds = tile.counters.stage_seconds["film"];
    for_each_part(tile.pixels, sampler.sample_count(), 2048, [&](uint32_t first, uint32_t count) {
      {
        const StageTimer timer(primary_seconds);
        scratch.primary.trace(scene, sensor, tile.pixels, first, count, seed, tile.counters);
        if (options.hide_emitters) scratch.primary.pass_emitters(scene, tile.counters);
      }
      PointLightShader(scene, lights, options, sampler, tile.counters, scratch).shade_all();
      const StageTimer timer(film_seconds);
      for (size_t i = 0; i < scratch.primary.size(); ++i) {
        const Rgb& L = scratch.radiance[i];
        const float values[4] = {L.x, L.y, L.z, scratch.primary.hit(i) ? 1.f : 0.f};
        tile.film.add(scratch.primary.film_position(i), {values, film.has_alpha() ? 4u : 3u});
      }
    });
  });
}

}  // namespace kinome
