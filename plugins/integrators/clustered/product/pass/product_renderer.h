#pragma once

#include <optional>
#include <vector>

#include "clustered/product/pass/block_renderer.h"
#include "clustered/product/paths/caustics.h"
#include "clustered/product/pilot/pilot.h"
#include "clustered/product/pilot/plan.h"
#include "clustered/product/pilot/tile_knowledge.h"
#include "clustered/product/tiles/product_sampling.h"
#include "clustered/product/trial/method_map.h"
#include "clustered/product/trial/method_trial.h"

namespace kinome {

/// Mean number of rays per pixel of a render, and its time limit in seconds (infinity if there is
/// none).
struct RenderLength {
  double rays_per_pixel = 0;
  double seconds = kInfinity;
};
/// Rays per second and thread of product sampling in most scenes.
inline constexpr double kRaysPerThreadSecond = 1e6;
/// Returns the expected length of a render. `seconds` as for Integrator::begin.
RenderLength expected_length(const ProductTask& task, double seconds);

/// Returns the local light of the task's scene, or nullptr if there is none. `share` is the
/// fraction of the light points to draw. `min_aimed_share`: LocalLight::Settings::min_aimed_share.
std::unique_ptr<const LocalLight> make_local_light(const ProductTask& task, double share = 1,
                                                   double min_aimed_share = 0);

/// One render by learned product sampling: a pilot, a plan, and the passes of the image.
class ProductRenderer final : public Passes {
 public:
  /// `local` is complete or nullptr. `light_share` is the fraction of an image's light points that
  /// each pass draws.
  ProductRenderer(const ProductTask& task, std::shared_ptr<const DistantCells> cells,
                  std::unique_ptr<const LocalLight> local, double light_share = 1);
  /// Leaves tiles to `path` as the map says, if it isn't nullptr. Call it before the pilot.
  void use(std::unique_ptr<const MethodMap> map, double paths_per_ray);
  /// Sends the pilot for a render with this number of rays per pixel, or none if they are too few.
  /// Call it before any pass. Reduces samples() by the pilot's rays.
  void learn_from_pilot(double rays_per_pixel);
  /// Sends the pilot for a render of `seconds` at an expected speed. If it exceeds its share of the
  /// time, discards it and returns false.
  bool learn_in_time(double seconds, double rays_per_second);

  /// Material that most of the pilot's primaries hit in a tile, or nullptr if they hit none.
  const Bsdf* main_bsdf(int tile) const { return knowledge_.main_bsdf(tile); }
  /// False if `path` doesn't find all light, or is known to find some of it with much noise.
  bool can_use_paths() const;
  /// LocalLight::aimed_share(), or 1 if there is no local light.
  double aimed_share() const { return local_ ? local_->aimed_share() : 1; }
  /// Learns from the tiles of a trial. Returns the rays per pixel of an image's pilot.
  double learn_for_trial(double rays_per_pixel, const MethodTrial& trial);
  /// Returns the method that renders the tiles of a trial by product sampling, with `rays` per
  /// pixel. Call it after learn_for_trial(). `length` is that of the whole render. This renderer
  /// must outlive the result.
  MethodTrial::Way trial_way(const MethodTrial& trial, double rays, const RenderLength& length,
                             double cost_of_ray, uint64_t seed);

  double samples() const override;
  double render(double samples) override;
  double seconds_per_sample() const override;
  /// Renders all samples of the settings.
  void render_all();

 private:
  /// Rays of an image for each path from a lamp to a mirror.
  static constexpr double kRaysPerCausticPath = 8;

  Primaries::View view() const;
  PassView pass_view(const CellLight& light) const;
  /// `share`: see LocalLight::draw.
  CellLight make_light(uint64_t seed, double rays_per_pixel, float share = 1) const;
  Pilot::Effort effort_of_pilot(double rays_per_pixel) const;
  /// The pilot probes the tiles that `is_wanted` selects, or all if it is empty.
  LargeArray<PixelForecast> send_pilot(Pilot::Effort effort, const TileGrid::IsWanted& is_wanted,
                                       double progress_end);
  void allocate(Pilot::Effort effort, std::span<const PixelForecast> forecast, int width,
                int height);
  void try_tiles(const MethodTrial& trial, double rays, uint64_t index, uint64_t seed,
                 std::span<Rgb> image);
  LargeArray<PixelPlan> plan_pass(double rays_per_pixel) const;
  /// `is_last`: this is the last call for the image.
  void render_rays(double rays_per_pixel, double progress_begin, bool is_last);
  void divide_among_methods();
  bool is_by_path(const TileGrid::Tile& tile) const {
    return !by_path_.empty() && by_path_[tile.index] != 0;
  }
  struct Pass;
  struct PassWorker;
  void pass(const Pass& pass, std::span<const PixelPlan> plan);
  void add_to_film(const Pass& pass, int block, PassWorker& worker, RenderCounters& counters);

  const ProductTask task_;
  RenderContext& context_;
  const TileGrid& grid_;
  const transport::SceneTable table_;
  /// The scene with light groups, for tiles that are left to `path`; nullopt if not needed.
  std::optional<transport::SceneTable> grouped_table_;
  const std::shared_ptr<const DistantCells> shared_cells_;
  const DistantCells& cells_;
  const double light_share_;
  const std::unique_ptr<const LocalLight> local_;  ///< nullptr if there is none
  std::optional<Caustics> caustics_;               ///< nullopt if there are none
  CellNeighbours neighbours_;                      ///< only if there is a pilot
  BsdfAddresses addresses_;                        ///< of the results of other processes
  TileKnowledge knowledge_;
  std::optional<RayAllocation> allocation_;  ///< nullopt if there was no pilot
  std::vector<size_t> trial_pixels_;         ///< pixels of allocation_, if it is that of a trial
  std::optional<CellLight> pilot_light_;     ///< of the pilot, or of a trial
  double light_rays_ = 0;                    ///< traced for the light points of the pilot
  double pilot_rays_ = 0;                    ///< rays per pixel; 0 if there was no pilot
  double pilot_seconds_ = 0;
  double rays_left_;                      ///< rays per pixel that are left of the settings'
  std::unique_ptr<const MethodMap> map_;  ///< nullptr if all tiles have product sampling
  double paths_per_ray_ = 0;
  std::vector<uint8_t> by_path_;  ///< 1 for each tile that is left to `path`; empty: none
  uint64_t pass_ = 0;
  double unit_ = 0;  ///< rays per pixel of the first pass, whose weight is 1
};

}  // namespace kinome
