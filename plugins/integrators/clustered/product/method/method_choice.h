#pragma once

#include <memory>
#include <string>

#include "clustered/cells/light_cells.h"
#include "clustered/product/trial/method_map.h"
#include "clustered/product/tiles/product_sampling.h"
#include "clustered/product/pass/render_length.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"

namespace kinome {

/// True if `path` has the same expectation as product sampling, and may be the better method. False
/// for the direct light of emitters without area. Also false if mirrors show the light of such
/// emitters, because `path` doesn't find it.
bool is_path_possible(const Scene& scene, const Sensor& sensor, const ProductSettings& settings);

/// Method of an image. If `paths` isn't nullptr, it renders the image. Otherwise, product sampling
/// does, except for the tiles that `map` leaves to `path`.
struct MethodChoice {
  std::unique_ptr<Passes> paths;
  std::unique_ptr<const MethodMap> map;
  double paths_per_ray = 0;    ///< number of paths that cost as much as a ray of product sampling
  double rays_per_second = 0;  ///< of product sampling in the trial; 0 if there was none
};

/// Chooses between product sampling and `path`. Leaves short renders to `path` without a trial.
/// Otherwise, renders some tiles by both methods (MethodTrial). These renders are not part of the
/// image, so that it stays unbiased. `grid` divides the image and must outlive the result.
MethodChoice choose_method(const Scene& scene, const Sensor& sensor, RenderContext& context,
                           CellsOnDemand& cells, const ProductSettings& settings,
                           const RenderLength& length, const TileGrid& grid);

/// Returns passes of `path`. They have `paths_per_sample` times as many samples as `settings`,
/// because a path takes less time than a sample of product sampling. Logs `reason`.
std::unique_ptr<Passes> path_passes(const Scene& scene, const Sensor& sensor,
                                    RenderContext& context, const ProductSettings& settings,
                                    double paths_per_sample, const std::string& reason);

}  // namespace kinome
