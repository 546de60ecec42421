#pragma once

#include <memory>
#include <vector>

#include "clustered/method.h"
#include "clustered/product/product_sampling.h"

namespace kinome {

/// `clustered` by learned product sampling: for `importance` = product.
class ProductMethod final : public ClusteredMethod {
 public:
  struct Settings {
    /// Of them, rays_per_pixel may be 0: kRaysPerSample for each of the sampler's samples.
    ProductSettings sampling;
    uint32_t cells = 512;  ///< that an environment is divided into, at most
    /// PointLightOptions::max_geometry_term: a bounce that is bounded takes light points.
    float max_geometry_term = 0;
  };
  /// Returns nullptr if the scene isn't one for this method: what an emitter lacks is logged as a
  /// warning. The scene must outlive the method. rays_per_pixel: infinity if unknown.
  static std::unique_ptr<const ProductMethod> make(const Settings& settings, const Scene& scene,
                                                   double rays_per_pixel, RenderContext& context);
  /// True where make() has one: says nothing, and does nothing else.
  static bool serves(const Settings& settings, const Scene& scene);
  /// What a render() of that sensor takes.
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
  CellsOnDemand cells_;  ///< none: there is no environment, or a black one
};

}  // namespace kinome
