#pragma once

#include <functional>
#include <vector>

#include "kinome/light_points.h"
#include "kinome/render_context.h"

namespace kinome {

/// A scene's emitters, divided by how integrators over light points treat them.
struct KINOME_EXPORT ScenePointLights {
  LightPoints points;                  ///< of all emitters that offer distant points
  std::vector<const Emitter*> others;  ///< the rest: sampled one by one (Emitter::sample_direct)
};
/// Asks each emitter for `count` points.
KINOME_EXPORT ScenePointLights gather_point_lights(const Scene& scene, RenderContext& context,
                                                   uint32_t count);

/// Fills an empty selection for the point `si`, seen by the primary sample `key`. Called from many
/// threads at once. Where it chooses at random, the expectation of each point's summed weights must
/// be 1 if the point can be reflected at `si`.
using ChoosePoints = std::function<void(const SurfaceInteraction& si, const SampleKey& key,
                                        RenderCounters& counters, PointSelection& selection)>;

/// `choose` may use 16 dimensions from here on; the others are taken by primary rays, by mirror
/// reflection and by emitters without points.
inline constexpr uint32_t kChooseDimensions = 16;

/// Renders direct light as Åkerlund 2008, 4.3: a G-buffer first; then, for each point of it, the
/// sum over the chosen lights of weight x power x f cos(theta) x visibility. Contributions of zero
/// cost no shadow ray. Mirror (delta) lobes, which no point light can meet, are followed by one ray
/// into the scene's own lights; emitters without points get one light sample each.
/// Stages: primary, choose (by `choose` itself), evaluate, shadow, film.
KINOME_EXPORT void render_point_lights(const Scene& scene, const Sensor& sensor,
                                       RenderContext& context, const ScenePointLights& lights,
                                       bool hide_emitters, const ChoosePoints& choose);

}  // namespace kinome
