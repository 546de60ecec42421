#pragma once

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "clustered/cells/light_cells.h"
#include "kinome/inspection.h"
#include "kinome/integrator.h"
#include "kinome/render_context.h"
#include "path_parameters.h"

namespace kinome {

/// Rays that one sample of `direct` takes: of the camera, toward a light, and by the BSDF.
inline constexpr double kRaysPerSample = 3;

/// Learned product sampling: what the `clustered` integrator does for `importance` = product.
struct ProductSettings {
  /// Rays of all kinds for each pixel, on average.
  double rays_per_pixel = 48;
  /// Cells of distant light are half as many where rays are few, but in plain scenes and passes.
  bool fewer_cells = true;
  /// Of paths: 2 edges are direct light, 3 add one bounce.
  PathLength length{2, 5};
  /// Cells that light after a bounce is divided into, at most.
  uint32_t bounce_cells = 256;
  bool hide_emitters = false;
  /// Layer 1 of the film has kProductChannels, to be filled.
  bool diagnostics = false;
  /// Pictures of no more pixels keep the learned visibilities of all; larger ones learn them again
  /// in each pass, and keep the points of the pilot in no more pixels. Results do not depend on it.
  int remembered_pixels = 1 << 18;

  // Parts that can be left out, to see what they are worth. Estimates stay unbiased.
  bool control_variate = true;    ///< what is known of visible light is added without rays
  bool learned_sigma = true;      ///< rays go where visibility is uncertain
  bool checked_sigma = true;      ///< how uncertain it is, the pilot's rays tell
  bool adaptive = true;           ///< rays go to the pixels that need them
  bool smooth_plan = true;        ///< which those are, pixels around tell, where the pilot is small
  bool horizon_terms = true;      ///< also in cells at the horizon of flat surfaces
  bool shared_candidates = true;  ///< pixels share glossy directions where they reflect alike
  bool light_guide = true;        ///< light points go to what the camera sees the light of
  bool trial = true;              ///< `path` renders images that it renders with less work
};

/// What the film's layer 1 says of each pixel, on average over passes by their weight: camera rays;
/// rays of all kinds, ten unshadowed candidates counting as one; learned visibility, the share of
/// the cells' light that is believed to arrive (0 where nothing is learned).
inline constexpr const char* kProductChannels[] = {"samples", "cost", "visibility"};

/// Cells of an environment, made when they are first needed: renders that are left to `path` may do
/// without. Not thread-safe.
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

/// True where `product` renders all light of the scene, up to paths of max_depth edges: any mixture
/// of an environment with an Emitter::cell_grid, surface emitters, and emitters that are no
/// surface; for light after bounces, the latter with Emitter::emission_density. Not where the flux
/// that is followed is beyond 1e34.
bool is_product_scene(const Scene& scene, uint32_t max_depth);

/// Renders the light of an environment's cells (none: the environment is black, or there isn't
/// any), that of the scene's other emitters, and for max_depth 3 and more what surfaces send on of
/// all of it, into the sensor's film. Light that lamps without extent send by way of a mirror is in
/// it, too, where the sensor can be connected to (see Caustics), though `path` doesn't find it. A
/// pilot learns how visible each cell is from each patch of surface; then the picture is made by
/// estimates that know. What the pilot saw is not part of the picture.
///
/// Unbiased: the expectation of every pixel is what `direct`, or
/// `path` of the same depth, converges to, with any filter. Stages:
/// points, pilot, plan, main, film.
void render_product(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    CellsOnDemand cells, const ProductSettings& settings);

/// The same by passes, which all use what the pilot has learned. `seconds` as for
/// Integrator::begin: no pilot is sent where it would take up too much of them.
std::unique_ptr<Passes> begin_product(const Scene& scene, const Sensor& sensor,
                                      RenderContext& context, CellsOnDemand cells,
                                      const ProductSettings& settings, double seconds);

/// What a pixel's renders know of the cells and how they send their rays, for distant and for local
/// light, where there is any: clusters of a report are cells, as the surface that most of the pixel
/// shows sees them. Learned from as many rays as a render learns from.
std::vector<Inspection> inspect_product(const Scene& scene, const Sensor& sensor,
                                        RenderContext& context,
                                        std::shared_ptr<const DistantCells> cells,
                                        const ProductSettings& settings, int x, int y);

}  // namespace kinome
