// The part of ProductRenderer that decides between product sampling and `path`.
#include <algorithm>
#include <cmath>

#include "clustered/product/method_trial.h"
#include "clustered/product/product_renderer.h"
#include "clustered/product/spread.h"
#include "clustered/product/trial_paths.h"

namespace kinome {
namespace {

constexpr uint64_t kTrialSeed = 0x74726961;
constexpr double kTrialRays = 32;  ///< rays per pixel of product sampling in a trial, at most
/// Cost of a ray, with all that is done for it, in units of a ray of `path`. Between 4 and 8 were
/// measured in eight interiors, and 3 among balls of glass, where most rays belong to paths.
constexpr double kCostOfRay = 5, kCostOfLightRay = 5;
/// `path` renders the image if it takes less than this share of the work of product sampling in a
/// trial. More than 1, because a trial finds few of the bright outliers of product sampling.
constexpr double kMaxWorkOfPaths = 1.5;
/// The error of product sampling times its rays falls by this power of the rays of a pass, because
/// stratification improves; measured between 16 and 64 samples a pixel. At most kMaxMoreRays times
/// the rays of a trial are considered.
constexpr double kGainOfRays = 0.3, kMaxMoreRays = 16;
/// Share of the render's time that a trial may take.
constexpr double kTrialShare = 0.1;

/// Returns the rays per pixel of product sampling in a trial. At least 1: the pilot of a render with
/// a time limit may have used more rays than the settings ask for.
double rays_of_trial(double rays_left) {
  return std::clamp(rays_left, 1., kTrialRays);
}

}  // namespace

/// Renders the tiles of the trial by product sampling into `picture`. The first of the two renders
/// uses the light points of the pilot, because drawing points takes long for any number of pixels.
void ProductRenderer::try_product(const MethodTrial& trial, const CellLight& light, double rays,
                                  uint64_t seed, std::vector<Rgb>& picture) const {
  const std::vector<PixelPlan> plan = plan_pass(rays);
  const auto is_wanted = [&](const TileGrid::Tile& tile) { return trial.is_wanted(tile); };
  SharedItems shared([&](size_t block, SharedBytes& bytes) {
    transfer_tiles(picture, grid_, static_cast<int>(block), is_wanted, bytes);
  });
  grid_.for_each_block<BlockRenderer>(
      context_, grid_.all_rows(), "trial",
      [&] { return std::make_unique<BlockRenderer>(pass_view(light)); },
      [&](int block, BlockRenderer& renderer, RenderCounters& counters) {
        renderer.render(block, plan, seed, counters, is_wanted);
        size_t next = 0;
        grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
          if (!is_wanted(tile)) return;
          tile.for_each_pixel(
              [&](int x, int y) { picture[grid_.pixel(x, y)] = renderer.colour(next++); });
        });
      },
      &shared);
}

/// True if `path` has the same expectation: it finds no caustics of lamps.
bool ProductRenderer::can_use_paths() const {
  return local_ && !local_->has_lamp_caustics() && !settings_.diagnostics;
}

void ProductRenderer::use_paths(double paths_per_sample, const char* reason) {
  context_.skip("product", reason);
  paths_per_sample_ = paths_per_sample;
  path_integrator_.emplace(path_settings());
  paths_ = path_integrator_->begin(scene_, sensor_, context_, kInfinity);
}

/// `path` is better if most of the error is in light that product sampling finds badly, such as light
/// by mirrors and glass or from far outside of the view.
void ProductRenderer::compare_with_paths(double seconds) {
  if (!can_use_paths()) return;
  if (!allocation_) {
    if (lost_pilot_) use_paths(1, "without a pilot, paths from the camera do better");
    return;
  }
  // The direct light of lamps is left to product sampling: its noise is in the edges of shadows, of
  // which few tiles tell little.
  if (!local_->has_surfaces() && !local_->has_bounce()) return;
  const uint64_t seed = hash_words(seed_, kTrialSeed);
  const MethodTrial trial(grid_, seed);
  if (!trial.is_possible()) return;
  const double expected = expected_rays(seconds), rays = rays_of_trial(expected);
  // Light is followed once for the whole image, and for more rays than those of the trial; one of
  // the two renders follows none.
  const double share = 2 * trial.share() * std::min(1., kTrialRays / std::max(expected, 1.));
  MethodTrial::Way product{[&](uint64_t index, std::vector<Rgb>& picture) {
                             const uint64_t own = hash_words(seed, 1, index);
                             if (index == 0) {
                               return try_product(trial, *pilot_light_, rays, own, picture);
                             }
                             const CellLight light = make_light(hash_words(own, 1), rays);
                             try_product(trial, light, rays, own, picture);
                           },
                           kCostOfRay, kCostOfLightRay * share};
  if (caustics_) {
    const double count = rays / kRaysPerCausticPath * grid_.crop().area();
    const auto tried = static_cast<uint32_t>(std::ceil(count * trial.share()));
    product.more_variance =
        caustics_->variance(hash_words(seed, 3), tried, count, grid_, context_.stats().counters);
    product.more_cost = tried * caustics_->rays_per_path() * kCostOfLightRay;
  }
  const TrialPaths trial_paths(table_, sensor_, grid_, path_settings(), context_);
  const MethodTrial::Way paths{[&](uint64_t index, std::vector<Rgb>& picture) {
    trial_paths.trace(trial, hash_words(seed, 2, index), picture);
  }};
  if (seconds < kInfinity) context_.set_deadline(context_.seconds() + kTrialShare * seconds);
  const MethodTrial::Result result = trial.compare(product, paths, context_);
  const bool is_late = context_.cancelled();
  context_.set_deadline(kInfinity);
  if (context_.cancelled()) return;
  const double more_rays = std::clamp(expected / kTrialRays, 1., kMaxMoreRays);
  const double paths_of_same_cost = TrialPaths::kPaths / result.cost * kRaysPerSample / rays;
  if (is_late) {
    use_paths(1, "there was too little time for a trial");
  } else if (result.work * std::pow(more_rays, kGainOfRays) < kMaxWorkOfPaths) {
    use_paths(std::max(1., paths_of_same_cost),
              "in a trial, paths from the camera alone did as well for less");
  }
}

void ProductRenderer::choose_method(double seconds) {
  compare_with_paths(seconds);
  pilot_light_.reset();
}

}  // namespace kinome
