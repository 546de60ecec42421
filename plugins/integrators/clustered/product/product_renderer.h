#pragma once

#include <optional>
#include <vector>

#include "clustered/product/block_renderer.h"
#include "clustered/product/caustics.h"
#include "clustered/product/method_trial.h"
#include "clustered/product/plan.h"
#include "clustered/product/product_sampling.h"
#include "clustered/product/tile_knowledge.h"
#include "transport/path_integrator.h"

namespace kinome {

/// The scene's local light, as renders with these settings divide it; nullptr: it has none.
std::unique_ptr<const LocalLight> make_local_light(const Scene& scene, const Sensor& sensor,
                                                   const ProductSettings& settings, uint64_t seed,
                                                   RenderContext& context);

/// One render by learned product sampling: pilot, plan, and passes that make the picture.
class ProductRenderer final : public Passes {
 public:
  ProductRenderer(const Scene& scene, const Sensor& sensor, RenderContext& context,
                  std::shared_ptr<const DistantCells> cells, const ProductSettings& settings);
  /// Sends the pilot that suits so many rays a pixel, or none: before any pass. What it takes of
  /// them is taken from samples().
  void learn_from_pilot(double rays_per_pixel);
  /// The same where there are so many seconds for everything, and no more than a share of them for
  /// the pilot, which is forgotten if it takes longer.
  void learn_in_time(double seconds);

  /// Compares product sampling with `path` (MethodTrial), after the pilot, and leaves the passes to
  /// `path` if that is better or if the pilot was lost. The trial's rays come on top of those of the
  /// settings. `seconds`: total time of the render.
  void choose_method(double seconds);

  double samples() const override;
  double render(double samples) override;
  double seconds_per_sample() const override;
  /// All that the settings ask for.
  void render_all();

 private:
  /// Rays of an image for each path from a lamp to a mirror.
  static constexpr double kRaysPerCausticPath = 8;

  PathSettings path_settings() const { return {settings_.length, settings_.hide_emitters}; }
  Primaries::View view() const;
  PassView pass_view(const CellLight& light) const;
  CellLight make_light(uint64_t seed, double rays_per_pixel) const;
  bool can_use_paths() const;
  void compare_with_paths(double seconds);
  void use_paths(double paths_per_sample, const char* reason);
  /// Rays a pixel of the whole render, without those of the pilot.
  double expected_rays(double seconds) const;
  void try_product(const MethodTrial& trial, const CellLight& light, double rays, uint64_t seed,
                   std::vector<Rgb>& picture) const;
  std::vector<PixelPlan> plan_pass(double rays_per_pixel) const;
  /// `is_last`: nothing is rendered after this.
  void render_rays(double rays_per_pixel, double progress_begin, bool is_last);
  void pass(const CellLight& light, const std::vector<PixelPlan>& plan, uint64_t seed,
            float weight);
  void add_to_film(int block, uint64_t seed, float weight, const BlockRenderer& renderer,
                   RenderCounters& counters);

  const Scene& scene_;
  const transport::SceneTable table_;
  const Sensor& sensor_;
  RenderContext& context_;
  const std::shared_ptr<const DistantCells> shared_cells_;
  const DistantCells& cells_;
  const ProductSettings settings_;
  const TileGrid grid_;
  const uint64_t seed_;
  const std::unique_ptr<const LocalLight> local_;  ///< nullptr: there is none
  std::optional<Caustics> caustics_;               ///< where there may be some
  CellNeighbours neighbours_;                      ///< where there is a pilot
  BsdfAddresses addresses_;                        ///< of what other processes have found
  TileKnowledge knowledge_;
  std::optional<RayAllocation> allocation_;  ///< where there was a pilot
  std::optional<CellLight> pilot_light_;     ///< until the method is chosen
  uint32_t pilot_rays_ = 0;                  ///< of each pixel; 0: there was none
  bool lost_pilot_ = false;
  double pilot_seconds_ = 0;
  double rays_left_;                                          ///< of the settings' rays a pixel
  std::optional<transport::PathIntegrator> path_integrator_;  ///< where paths alone are chosen
  std::unique_ptr<Passes> paths_;                             ///< of that
  double paths_per_sample_ = 1;  ///< that cost as much as product sampling
  uint64_t pass_ = 0;
  double unit_ = 0;  ///< rays a pixel of the first pass: they have weight 1
};

}  // namespace kinome
