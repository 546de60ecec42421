#include <algorithm>
#include <cmath>

#include "kinome/primary_rays.h"
#include "product_workspace.h"
#include "spread.h"

namespace kinome {
namespace {

constexpr uint32_t kCellPoints = 1u << 15;
/// More rays than this are left to more passes: each has fresh points of the cells.
constexpr double kMaxRaysOfPass = 512;
/// Below so many rays a pixel nothing is learned.
constexpr double kLeastToLearn = 10;
constexpr uint32_t kPilotRays = 3;           ///< for each of its primaries
constexpr double kCandidatesUnlearned = 16;  ///< for each ray
/// Keeps the random numbers of passes apart from those of the pilot.
constexpr uint64_t kPassSeed = 0x70617373;
/// Whatever is planned: surfaces that the pilot missed, such as thin ones, must not be left to
/// control terms.
constexpr uint32_t kLeastRays = 2;

}  // namespace

ProductRenderer::ProductRenderer(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                 const DistantCells& cells, const ProductSettings& settings)
    : scene_(scene),
      sensor_(sensor),
      context_(context),
      cells_(cells),
      settings_(settings),
      crop_(sensor.film().crop()),
      filter_(sensor.film().filter()),
      seed_(key_seed(context, sensor.sampler())) {
  tiles_.resize(static_cast<size_t>(tiles_x()) * tiles_y());
  forecast_.resize(crop_.area());
  radiance_.assign(crop_.area(), Rgb(0.f));
  alpha_.assign(crop_.area(), 0.f);
  passes_.assign(crop_.area(), 0);
}

size_t ProductRenderer::pixel_index(int x, int y) const {
  return static_cast<size_t>(y - crop_.y0) * crop_.width() + (x - crop_.x0);
}

TilePrimaries::View ProductRenderer::view() const {
  const Film& film = sensor_.film();
  return {scene_, sensor_, filter_, film.sample_border() ? film.reach() : crop_,
          settings_.hide_emitters};
}

void ProductRenderer::render_tile(int tile, const Rect& pixels, const std::vector<PixelPlan>& plan,
                                  uint64_t seed, Workspace& work, RenderCounters& counters) {
  TileMemory& memory = tiles_[tile];
  const auto pixel_of = [&](size_t i) {
    const int k = static_cast<int>(i);
    return pixel_index(pixels.x0 + k % pixels.width(), pixels.y0 + k / pixels.width());
  };
  const size_t count = static_cast<size_t>(pixels.area());
  work.counts.resize(count);
  for (size_t i = 0; i < count; ++i) work.counts[i] = plan[pixel_of(i)].primaries;
  {
    const StageTimer timer(counters.stage_seconds["primary"]);
    work.primaries.trace(view(), pixels, work.counts, seed, counters);
  }
  work.patches = memory.patches;
  assign_patches(work.primaries, work.patches);
  work.reserve_visibility(work.patches.size(), cells_.padded_size());
  for (size_t p = 0; p < work.patches.size(); ++p) {
    Visibility& visibility = work.visibility[p];
    if (p < memory.patches.size()) {
      load_visibility(memory, p, visibility);
    } else {
      learn(tile, work.patches[p], work);
      work.learner.finish(visibility);
      work.patches[p].trust = !is_sharp(work.patches[p]);
    }
    if (!work.patches[p].trust) {
      std::fill(visibility.v.begin(), visibility.v.end(), 0.f);
      visibility.sigma = visibility.sigma_mixed;
    }
    apply_ablations(visibility);
  }
  work.estimator.begin_tile(scene_, work.primaries, work.patches, work.visibility, counters);
  for (size_t i = 0; i < count; ++i) {
    const size_t pixel = pixel_of(i);
    Estimator::Unit unit;
    unit.first = work.primaries.first(i);
    unit.end = work.primaries.first(i + 1);
    unit.rays = std::max<uint32_t>(plan[pixel].rays, kLeastRays);
    unit.candidates = plan[pixel].candidates;
    unit.seed = hash_words(seed, pixel, 2);
    Rgb& sum = work.sums.emplace_back(0.f);
    float hits = 0;
    for (uint32_t k = unit.first; k < unit.end; ++k) {
      sum += work.primaries.emitted(k);
      hits += work.primaries.hit(k) ? 1.f : 0.f;
    }
    alpha_[pixel] += hits / static_cast<float>(unit.end - unit.first);
    work.estimator.estimate(unit, sum);
  }
}

void ProductRenderer::pass(const CellLight& light, const std::vector<PixelPlan>& plan,
                           uint64_t seed) {
  for_each_tile(
      light, "main",
      [&](int tile, int place, const Rect& pixels, Workspace& work, RenderCounters& counters) {
        if (place == 0) {
          work.sums.clear();
          work.sums.reserve(static_cast<size_t>(kBlock) * kBlock);
        }
        render_tile(tile, pixels, plan, seed, work, counters);
      },
      [&](int block, Workspace& work) {
        work.estimator.flush();
        const int x0 = block % blocks_x() * kTilesAcross, y0 = block / blocks_x() * kTilesAcross;
        size_t next = 0;
        for (int i = 0; i < kTilesAcross * kTilesAcross; ++i) {
          const int tx = x0 + i % kTilesAcross, ty = y0 + i / kTilesAcross;
          if (tx >= tiles_x() || ty >= tiles_y()) continue;
          for (int y = ty * kTile; y < std::min((ty + 1) * kTile, crop_.height()); ++y) {
            for (int x = tx * kTile; x < std::min((tx + 1) * kTile, crop_.width()); ++x) {
              const size_t pixel = static_cast<size_t>(y) * crop_.width() + x;
              radiance_[pixel] += work.sums[next++] / static_cast<float>(plan[pixel].primaries);
              ++passes_[pixel];
            }
          }
        }
      });
}

/// Also of an interrupted render, whose context hands out no more work.
void ProductRenderer::write_film() {
  const StageTimer timer(context_.stats().counters.stage_seconds["film"]);
  Film& film = sensor_.film();
  FilmTile tile = film.make_tile(crop_);
  for (int y = crop_.y0; y < crop_.y1; ++y) {
    for (int x = crop_.x0; x < crop_.x1; ++x) {
      const size_t pixel = pixel_index(x, y);
      if (passes_[pixel] == 0) continue;
      const auto passes = static_cast<float>(passes_[pixel]);
      const Rgb c = radiance_[pixel] / passes;
      const float values[4] = {c.x, c.y, c.z, alpha_[pixel] / passes};
      tile.add_pixel(x, y, {values, film.has_alpha() ? 4u : 3u});
    }
  }
  film.commit(tile);
}

CellLight ProductRenderer::make_light(uint64_t seed) const {
  const StageTimer timer(context_.stats().counters.stage_seconds["points"]);
  return CellLight(cells_, *scene_.environment(),
                   cells_.draw_points(kCellPoints, hash_words(seed_, seed), context_));
}

/// Returns the rays of a pixel that are left.
double ProductRenderer::learn_from_pilot() {
  const double budget = settings_.rays_per_pixel;
  if (budget < kLeastToLearn) {
    context_.skip("pilot", "a few rays a pixel are too few to learn from");
    return budget;
  }
  const uint32_t primaries = budget < 24 ? 1 : budget < 60 ? 2 : 4;
  const uint32_t rays = kPilotRays * primaries;
  const CellLight light = make_light(0);
  context_.set_progress_range(0, 0.2);
  pilot(light, primaries, rays);
  if (context_.cancelled()) return 0;
  plan(light);
  return budget - primaries - rays;
}

std::vector<PixelPlan> ProductRenderer::plan_passes(double rays_per_pixel) const {
  const StageTimer timer(context_.stats().counters.stage_seconds["allocate"]);
  if (pilot_primaries_ > 0) {
    return allocate(forecast_, crop_.width(), crop_.height(), rays_per_pixel, settings_.adaptive);
  }
  PixelPlan plan;
  plan.primaries = static_cast<uint16_t>(std::max(1., rays_per_pixel / 3));
  plan.rays = static_cast<uint16_t>(std::max(1., rays_per_pixel - plan.primaries));
  plan.candidates = static_cast<float>(kCandidatesUnlearned * plan.rays);
  return std::vector<PixelPlan>(forecast_.size(), plan);
}

void ProductRenderer::render() {
  const double left = learn_from_pilot();
  const auto passes = static_cast<uint32_t>(std::max(1., std::ceil(left / kMaxRaysOfPass)));
  const std::vector<PixelPlan> plan = plan_passes(left / passes);
  points_ = {};
  for (uint32_t i = 0; i < passes && !context_.cancelled(); ++i) {
    const double begin = pilot_primaries_ > 0 ? 0.2 : 0., part = (1 - begin) / passes;
    context_.set_progress_range(begin + part * i, begin + part * (i + 1));
    pass(make_light(1 + i), plan, hash_words(seed_, kPassSeed, i));
  }
  write_film();
}

void render_product(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    const DistantCells& cells, const ProductSettings& settings) {
  ProductRenderer(scene, sensor, context, cells, settings).render();
}

}  // namespace kinome
