#pragma once

#include <functional>
#include <vector>

#include "clustered/points/point_selection.h"
#include "kinome/light_points.h"
#include "kinome/render_context.h"
#include "transport/surfaces/surfaces.h"

namespace kinome {

/// Points of a block for which light points are chosen.
struct LitPoints {
  const PixelSamples& samples;
  const transport::Surfaces& surfaces;
  const uint32_t* owner;  ///< for each point, the sample of the block that sees it
  uint32_t dimension;     ///< first of kChooseDimensions dimensions of the sampler

  /// Calls fn(i, material) for each point that scatters light.
  template <class Function>
  void for_each(const Function& fn) const {
    for (const transport::Surfaces::Range& range : surfaces.ranges()) {
      if (range.first >= surfaces.scattering()) return;
      for (size_t i = range.first; i < range.first + range.count; ++i) fn(i, *range.row->bsdf);
    }
  }
};
inline constexpr uint32_t kChooseDimensions = 16;

/// Uses the light points that were chosen for point i.
using UseChosen =
    std::function<void(size_t i, const Bsdf& bsdf, const PointSelection& selection)>;
/// Chooses light points for each of the points, one after the other. Called from many threads at
/// once. The expectation of each light point's total weight must be 1 if its light can be reflected
/// at the point.
using ChoosePoints =
    std::function<void(const LitPoints& points, RenderCounters& counters, const UseChosen& use)>;

/// Light points of one kind, and the function that chooses among them for shading points.
struct PointLightSet {
  LightPoints points;
  bool is_indirect = false;  ///< light after a bounce, whose paths are one edge longer
  ChoosePoints choose;
};

/// A scene's light, for integrators over light points.
struct ScenePointLights {
  std::vector<PointLightSet> sets;     ///< the integrator sets `choose`
  std::vector<const Emitter*> others;  ///< other emitters, sampled by Emitter::sample_direct
};

/// Options of integrators over light points.
struct PointLightOptions {
  bool distant = true;  ///< environments have light points; otherwise they are sampled directly
  bool local = true;    ///< the same for emitters in the scene; includes indirect light
  /// Maximum number of edges of a path from the camera to an emitter: 2 is direct light, 3 one
  /// bounce more.
  uint32_t max_depth = 2;
  bool hide_emitters = false;
  /// Upper bound on cos cos' / d² between a shading point and a local light point [1 / area]; 0: no
  /// bound. It removes the peaks near light points, but also their light: a bias.
  float max_geometry_term = 0;
};

/// Requests `count` light points of each emitter and, for max_depth 3, of each of the scene's
/// indirect emitters.
ScenePointLights gather_point_lights(const Scene& scene, RenderContext& context, uint32_t count,
                                     const PointLightOptions& options);

/// Renders as in Åkerlund 2008, 4.3, block by block. A block's G-buffer comes first; then, for each
/// of its points, the sum over the chosen light points of weight x power x f cos(theta) x
/// visibility. Contributions of zero take no shadow ray. Emitters without light points get one
/// emitter sample each.
///
/// Rays follow mirror (delta) lobes, to which light points can't contribute. The surfaces that they
/// hit are lit in the same way, within max_depth. Light that reaches a surface via a mirror is left
/// out. Stages: primary, choose (timed by `choose` itself), evaluate, shadow, film.
void render_point_lights(const Scene& scene, const Sensor& sensor, RenderContext& context,
                         const ScenePointLights& lights, const PointLightOptions& options);

}  // namespace kinome
