#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "clustered/cells/light_cells.h"
#include "clustered/method.h"
#include "clustered/product/tiles/product_sampling.h"

namespace kinome {

/// The `clustered` integrator with learned product sampling: `importance` = product. Renders all
/// light of the scene: that of an environment, by its cells, that of other emitters, and for
/// max_depth > 2 the light that surfaces reflect. If the sensor supports it (see Caustics), the
/// image has light that lamps send by way of a mirror, which `path` doesn't find.
///
/// A pilot learns how visible each cell is from each patch. The passes of the image use these
/// visibilities. The pilot's rays are not part of the image.
///
/// Unbiased: the expectation of every pixel is the value to which `direct`, or `path` of the same
/// depth, converges, with any filter. Stages: points, pilot, plan, main, film.
class ProductMethod final : public ClusteredMethod {
 public:
  struct Settings {
    /// If its rays_per_pixel is 0, each sample of the sampler has kRaysPerSample rays.
    ProductSettings sampling;
    uint32_t cells = 512;  ///< maximum number of cells of an environment
    /// PointLightOptions::max_geometry_term. If it is set and light bounces, the method is not
    /// supported, because only light points can bound the term.
    float max_geometry_term = 0;
  };
  /// Returns nullptr if the method doesn't support the scene. Logs a warning if an emitter lacks a
  /// function. All arguments must outlive the method. If `is_progressive`, a budget of time or
  /// error determines the number of rays, so that it is unknown.
  static std::unique_ptr<const ProductMethod> make(const Settings& settings, const Scene& scene,
                                                   const Sensor& sensor, RenderContext& context,
                                                   bool is_progressive = false);
  /// True if the method renders all light of the scene. An environment must have
  /// Emitter::cell_grid. If light bounces, emitters other than surfaces must have
  /// Emitter::emission_density. The flux of emitting surfaces and reflected light must be below
  /// 1e34. Unlike make(), logs nothing and makes no cells.
  static bool serves(const Settings& settings, const Scene& scene);
  /// True if scenes with these emitters need light points, because light of only some emitters
  /// bounces or max_geometry_term bounds it. Emitters that aren't indirect have no effect.
  static bool is_for_light_points(const Settings& settings,
                                  std::span<const Emitter* const> emitters);

  /// Function that returns the cells of the environment. They are made at the first call, because
  /// renders by `path` don't need them. No cells if the environment is missing or black.
  using Cells = std::function<std::shared_ptr<const DistantCells>()>;
  ProductMethod(const ProductSettings& sampling, Cells cells)
      : sampling_(sampling), cells_(std::move(cells)) {}

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;
  /// All passes use the same pilot. Sends no pilot if it would take too large a share of `seconds`.
  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override;
  /// Returns a report for distant light and one for local light, if the scene has them: the learned
  /// visibility of the cells and the distribution of rays. Clusters of a report are cells, as seen
  /// from the surface that most of the pixel shows. Learns from as many rays as a render.
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  int x, int y) const override;

 private:
  ProductSettings sampling_;
  Cells cells_;
};

}  // namespace kinome
