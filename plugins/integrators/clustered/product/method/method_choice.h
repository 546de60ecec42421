#pragma once

#include <memory>
#include <string>

#include "clustered/product/method/product_method.h"
#include "clustered/product/pass/product_renderer.h"
#include "clustered/product/trial/method_map.h"

namespace kinome {

/// True if the scene has fewer than 1,000 triangles and other shapes.
bool has_few_primitives(const Scene& scene);

/// True if `path` has the same expectation as product sampling, and may be the better method. False
/// for the direct light of emitters without area. Also false if mirrors show the light of such
/// emitters, because `path` doesn't find it.
bool is_path_possible(const ProductTask& task);

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
/// image, so that it stays unbiased.
MethodChoice choose_method(const ProductTask& task, const ProductMethod::Cells& cells,
                           const RenderLength& length);

/// Returns passes of `path`. They have `paths_per_sample` times as many samples as the settings,
/// because a path takes less time than a sample of product sampling. Logs `reason`.
std::unique_ptr<Passes> path_passes(const ProductTask& task, double paths_per_sample,
                                    const std::string& reason);

}  // namespace kinome
