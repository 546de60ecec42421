#pragma once

#include <memory>
#include <vector>

#include "clustered/method.h"
#include "clustered/product/tiles/product_sampling.h"

namespace kinome {

/// The `clustered` integrator with learned product sampling: `importance` = product.
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
  /// function. The scene must outlive the method. rays_per_pixel is infinity if unknown.
  static std::unique_ptr<const ProductMethod> make(const Settings& settings, const Scene& scene,
                                                   double rays_per_pixel, RenderContext& context);
  /// True if the method supports the scene. Unlike make(), logs nothing and makes no cells.
  static bool serves(const Settings& settings, const Scene& scene);
  /// Number of rays per pixel of a render() with that sensor.
  static double rays_per_pixel(const Settings& settings, const Sensor& sensor);

  void render(const Scene& scene, const Sensor& sensor, RenderContext& context) const override;
  std::unique_ptr<Passes> begin(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                double seconds) const override;
  std::vector<Inspection> inspect(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                  int x, int y) const override;

 private:
  ProductMethod(const ProductSettings& sampling, CellsOnDemand cells)
      : sampling_(sampling), cells_(std::move(cells)) {}
  ProductSettings sampling_of(const Sensor& sensor) const;

  ProductSettings sampling_;
  CellsOnDemand cells_;  ///< no cells if the environment is missing or black
};

}  // namespace kinome
