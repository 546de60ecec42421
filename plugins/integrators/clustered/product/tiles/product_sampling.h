#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "clustered/cells/light_cells.h"
#include "kinome/inspection.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "transport/path_parameters.h"

namespace kinome {

/// Rays of one sample of `direct`: a camera ray, a ray toward an emitter, and a BSDF ray.
inline constexpr double kRaysPerSample = 3;

/// Settings of learned product sampling: the `clustered` integrator with `importance` = product.
struct ProductSettings {
  /// Mean number of rays of all kinds per pixel.
  double rays_per_pixel = 48;
  /// Halves the number of cells of distant light if rays are few, except in scenes of few
  /// primitives and if the number of rays is unknown.
  bool fewer_cells = true;
  /// Number of edges of paths: 2 is direct light, 3 adds one bounce.
  PathLength length{2, 5};
  /// Maximum number of cells of reflected light.
  uint32_t bounce_cells = 256;
  bool hide_emitters = false;
  /// Writes kProductChannels to layer 1 of the film.
  bool diagnostics = false;
  /// Maximum number of pixels of an image whose learned visibilities are kept. Larger images learn
  /// them again in each pass. Also limits the number of pixels whose points the pilot keeps.
  /// Results don't depend on it.
  int remembered_pixels = 1 << 18;

  // Parts that can be switched off to measure their benefit. Estimates stay unbiased.
  bool control_variate = true;  ///< adds learned visible light without rays
  bool learned_sigma = true;    ///< sends rays where visibility is uncertain
  bool checked_sigma = true;    ///< corrects sigma by the pilot's own rays
  bool adaptive = true;         ///< sends more rays to pixels with more noise
  bool smooth_plan = true;    ///< averages the plan's weights over neighbours if the pilot is small
  bool horizon_terms = true;  ///< adds control terms of cells at the horizon of flat patches
  bool shared_candidates = true;  ///< shares glossy candidates among pixels that reflect alike
  bool light_guide = true;        ///< draws light points where they contribute to the image
  bool trial = true;              ///< leaves images to `path` if it takes less work
};

/// Channels of the film's layer 1, as weighted means over passes. `samples` is the number of camera
/// rays. `cost` is the number of rays of all kinds; ten unshadowed candidates count as one ray.
/// `visibility` is the learned fraction of the cells' light that arrives, or 0 if nothing was
/// learned.
inline constexpr const char* kProductChannels[] = {"samples", "cost", "visibility"};

/// Cells of an environment, made at the first use, because renders by `path` don't need them. Not
/// thread-safe.
class CellsOnDemand {
 public:
  using Cells = std::shared_ptr<const DistantCells>;
  CellsOnDemand(Cells cells) : cells_(std::move(cells)) {}
  explicit CellsOnDemand(std::function<Cells(RenderContext&)> make) : make_(std::move(make)) {}

  const Cells& get(RenderContext& context) {
    if (!cells_) cells_ = make_(context);
    return cells_;
  }

 private:
  std::function<Cells(RenderContext&)> make_;
  Cells cells_;
};

/// True if the scene has fewer than 1,000 triangles and other shapes.
bool has_few_primitives(const Scene& scene);

/// True if `product` renders all light of the scene with paths of up to max_depth edges. An
/// environment must have Emitter::cell_grid. If light bounces, emitters other than surfaces must
/// have Emitter::emission_density. The flux of emitting surfaces and reflected light must be below
/// 1e34.
bool is_product_scene(const Scene& scene, uint32_t max_depth);

/// Renders all light of the scene into the sensor's film: that of an environment, by its cells,
/// that of other emitters, and for max_depth > 2 the light that surfaces reflect. `cells` are empty
/// if the environment is missing or black. If the sensor supports it (see Caustics), the image has
/// light that lamps send by way of a mirror, which `path` doesn't find.
///
/// A pilot learns how visible each cell is from each patch. The passes of the image use these
/// visibilities. The pilot's rays are not part of the image.
///
/// Unbiased: the expectation of every pixel is the value to which `direct`, or `path` of the same
/// depth, converges, with any filter. Stages: points, pilot, plan, main, film.
void render_product(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    CellsOnDemand cells, const ProductSettings& settings);

/// Renders by passes, which all use the same pilot. `seconds` as for Integrator::begin. Sends no
/// pilot if it would take too large a share of them.
std::unique_ptr<Passes> begin_product(const Scene& scene, const Sensor& sensor,
                                      RenderContext& context, CellsOnDemand cells,
                                      const ProductSettings& settings, double seconds);

/// Inspects a pixel: the learned visibility of the cells and the distribution of rays. Returns a
/// report for distant light and one for local light, if the scene has them. Clusters of a report
/// are cells, as seen from the surface that most of the pixel shows. Learns from as many rays as a
/// render.
std::vector<Inspection> inspect_product(const Scene& scene, const Sensor& sensor,
                                        RenderContext& context,
                                        std::shared_ptr<const DistantCells> cells,
                                        const ProductSettings& settings, int x, int y);

}  // namespace kinome
