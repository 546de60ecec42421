#include "clustered/points/point_lights.h"

#include "clustered/points/light_tree.h"
#include "kinome/clustered_light.h"

namespace kinome {
namespace {

using Kind = LightPoints::Kind;

/// Adds points to the set of their kind, so that they share a cut. Points with their own emission
/// make a separate set.
void add_points(LightPoints points, bool is_indirect, std::vector<PointLightSet>& sets) {
  if (points.size() == 0) return;
  check_light_points(points);
  for (PointLightSet& set : sets) {
    if (set.points.kind != points.kind || set.is_indirect != is_indirect || points.emission ||
        set.points.emission) {
      continue;
    }
    set.points.append(points);
    return;
  }
  sets.push_back({std::move(points), is_indirect, {}});
}

}  // namespace

ScenePointLights gather_point_lights(const Scene& scene, RenderContext& context, uint32_t count,
                                     const PointLightOptions& options) {
  ScenePointLights lights;
  const auto is_enabled = [&](Kind kind) {
    return kind == Kind::kDistant ? options.distant : options.local;
  };
  for (const Emitter* emitter : scene.emitters()) {
    const Kind expected = emitter->is_environment() ? Kind::kDistant : Kind::kLocal;
    std::optional<LightPoints> points;
    if (is_enabled(expected)) points = light_points_of(*emitter, scene, context, count);
    if (points && is_enabled(points->kind)) {
      // A black emitter has no points.
      add_points(std::move(*points), false, lights.sets);
    } else {
      lights.others.push_back(emitter);
    }
  }
  if (options.max_depth < 3) {
    context.job.skip("indirect light", "max_depth is 2");
  } else if (!options.local) {
    context.job.skip("indirect light", "mode is 'distant'");
  } else {
    for (const Emitter* emitter : scene.indirect_emitters()) {
      auto points = light_points_of(*emitter, scene, context, count);
      if (points) add_points(std::move(*points), true, lights.sets);
    }
  }
  return lights;
}

}  // namespace kinome
