#pragma once

#include <functional>
#include <vector>

#include "clustered/points/point_selection.h"
#include "kinome/light_points.h"
#include "kinome/render_context.h"
#include "transport/surfaces.h"

namespace kinome {

/// Points of a block that are to be lit.
struct LitPoints {
  const PixelSamples& samples;
  const transport::Surfaces& surfaces;
  const uint32_t* owner;  ///< of each point, the sample of the block that sees it
  uint32_t dimension;     ///< of the sampler, from which kChooseDimensions may be used

  /// fn(i, material) for each point that scatters light.
  template <class Function>
  void for_each(const Function& fn) const {
    for (const transport::Surfaces::Range& range : surfaces.ranges()) {
      if (range.first >= surfaces.scattering()) return;
      for (size_t i = range.first; i < range.first + range.count; ++i) fn(i, *range.row->bsdf);
    }
  }
};
inline constexpr uint32_t kChooseDimensions = 16;

/// Takes the light points that were chosen for point i.
using UseChosen =
    std::function<void(size_t i, const Bsdf& bsdf, const PointSelection& selection)>;
/// Chooses for each of the points, one after the other. Called from many threads at once. Where it
/// chooses at random, the expectation of each light point's summed weights must be 1 if that can be
/// reflected at the point.
using ChoosePoints =
    std::function<void(const LitPoints& points, RenderCounters& counters, const UseChosen& use)>;

/// Light points of one kind, and how those of a shading point are chosen.
struct PointLightSet {
  LightPoints points;
  bool is_indirect = false;  ///< light after a bounce: its paths are one segment longer
  ChoosePoints choose;
};

/// A scene's light, divided by how integrators over light points treat it.
struct ScenePointLights {
  std::vector<PointLightSet> sets;     ///< `choose` is left to the integrator
  std::vector<const Emitter*> others;  ///< the rest: sampled one by one (Emitter::sample_direct)
};

/// What is rendered.
struct PointLightOptions {
  bool distant = true;  ///< light points of environments; others among their emitters if not
  bool local = true;    ///< light points within the scene, indirect light among them
  /// Segments of a path from the camera to a light: 2 is direct light, 3 one bounce more.
  uint32_t max_depth = 2;
  bool hide_emitters = false;
  /// Upper bound on cos cos' / d² between a shading point and a local light point [1 / area]; 0:
  /// none. Takes the peaks near light points away, and their light with them: a bias.
  float max_geometry_term = 0;
};

/// Asks each emitter for `count` points (and, for max_depth 3, each of the scene's indirect
/// emitters).
ScenePointLights gather_point_lights(const Scene& scene, RenderContext& context, uint32_t count,
                                     const PointLightOptions& options);

/// Renders as Åkerlund 2008, 4.3, block by block: a G-buffer first; then, for each point of it, the
/// sum over the chosen lights of weight x power x f cos(theta) x visibility. Contributions of zero
/// cost no shadow ray. Mirror (delta) lobes, which no point light can meet, are followed by rays,
/// and what they meet is lit directly; emitters without points get one light sample each. Light
/// that reaches a surface by way of a mirror is left out. Stages: primary, choose (by `choose`
/// itself), evaluate, shadow, film.
void render_point_lights(const Scene& scene, const Sensor& sensor, RenderContext& context,
                         const ScenePointLights& lights, const PointLightOptions& options);

}  // namespace kinome
