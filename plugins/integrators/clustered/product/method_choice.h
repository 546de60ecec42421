#pragma once

#include <memory>
#include <string>

#include "clustered/cells/light_cells.h"
#include "clustered/product/method_map.h"
#include "clustered/product/product_sampling.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "kinome/scene.h"
#include "kinome/sensor.h"

namespace kinome {

/// Rays of a render, on average over its pixels, and its time limit in seconds (infinity: none).
struct RenderLength {
  double rays_per_pixel = 0;
  double seconds = kInfinity;
};

/// Rays per second and thread that product sampling traces in most scenes.
inline constexpr double kCarefulSpeed = 1e6;

/// Returns the expected length of a render with these settings. `seconds` as for Integrator::begin.
RenderLength expected_length(const ProductSettings& settings, const Sensor& sensor,
                             const RenderContext& context, double seconds);

/// True if `path` has the same expectation as product sampling, and the choice between them is not
/// obvious: not for the direct light of emitters without area, and not if mirrors show the light of
/// such emitters, which `path` doesn't find.
bool is_path_possible(const Scene& scene, const Sensor& sensor, const ProductSettings& settings);

/// Method of an image: `paths` if that isn't nullptr, else product sampling, but for the tiles that
/// `map` leaves to paths.
struct MethodChoice {
  std::unique_ptr<Passes> paths;
  std::unique_ptr<const MethodMap> map;
  double paths_per_ray = 0;    ///< paths that cost as much as a ray of product sampling
  double rays_per_second = 0;  ///< of product sampling in a trial; 0: there was none
};

/// Chooses between product sampling and `path`. Short renders are left to `path` at once; otherwise,
/// some tiles are rendered by both (MethodTrial). What they find is not part of the image, which
/// stays unbiased. `grid`: of the image; must outlive the result.
MethodChoice choose_method(const Scene& scene, const Sensor& sensor, RenderContext& context,
                           CellsOnDemand& cells, const ProductSettings& settings,
                           const RenderLength& length, const TileGrid& grid);

/// Returns passes of `path`. They have `paths_per_sample` times as many samples as `settings` says,
/// because a path takes less time than a sample of product sampling. `reason` is logged.
std::unique_ptr<Passes> path_passes(const Scene& scene, const Sensor& sensor,
                                    RenderContext& context, const ProductSettings& settings,
                                    double paths_per_sample, const std::string& reason);

}  // namespace kinome
