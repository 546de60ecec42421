#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "clustered/product/pilot.h"
#include "clustered/product/product_renderer.h"
#include "clustered/product/spread.h"
#include "kinome/primary_rays.h"

namespace kinome {
namespace {

/// More rays than this are left to more passes: each has fresh points of the cells.
constexpr double kMaxRaysOfPass = 512;
/// Below so many rays a pixel nothing is learned.
constexpr double kLeastToLearn = 10;
/// Light points are one for so many rays.
constexpr double kRaysPerPoint = 32, kRaysPerExtendedPoint = 8;
/// Passes of a render that is to take a time, or to reach an error.
constexpr double kPartsOfBudget = 3;
/// And paths from lamps to mirrors, where there are both.
constexpr double kRaysPerCausticPath = 8;
/// Light points, and no fewer places than these, to find out what is of use.
constexpr uint32_t kPointsPerPlace = 8, kLeastPlaces = 256;
/// Rays of a pilot for each of its primaries, and for the only one of a pixel: rays are few then,
/// and do more for the picture.
constexpr uint32_t kPilotRays = 3, kPilotRaysOfOne = 2;
/// Through a lens, pixels see more than one primary tells of: there are so many times as many, and
/// these rays for each.
constexpr uint32_t kLensPrimaries = 2, kLensRays = 1;
/// From so many primaries a pixel on, its forecast is its own.
constexpr uint32_t kPrimariesToTell = 4;
/// What a pilot reckons with where nobody knows how many rays there will be.
constexpr double kRaysOfUnknown = 100;
/// Rays a second and thread that most scenes allow, and the share of the time within which a pilot
/// has to be back all the same.
constexpr double kCarefulSpeed = 1e6;
constexpr double kPilotShare = 0.4;
constexpr double kCandidatesUnlearned = 16;  ///< for each ray
/// What an unshadowed candidate takes, in rays.
constexpr float kCandidateCost = 0.1f;
/// Keeps the random numbers of passes apart from those of the pilot.
constexpr uint64_t kPassSeed = 0x70617373;
constexpr uint64_t kCausticSeed = 0x63617573;
/// Whatever is planned: surfaces that the pilot missed, such as thin ones, must not be left to
/// control terms.
constexpr uint32_t kLeastRays = 2;

}  // namespace

/// What a thread renders a block with.
struct ProductRenderer::Worker {
  TileTracer tracer;
  VisibilityLearner learner;
  Estimator estimator;
  /// What the sum over a unit's primaries counts for in its pixel. A unit has none where a narrow
  /// film cuts off all that is negative of the filter.
  struct Weight {
    float share, primaries;
    template <class Value>
    Value of(const Value& sum) const {
      return primaries > 0 ? share * (sum / primaries) : Value(0.f);
    }
  };

  std::vector<Patch> patches;
  std::vector<Visibility> visibility;
  std::vector<Unit> units;    ///< pixels of a tile, or what is positive and negative of them
  std::vector<Rgb> sums;      ///< of the same, of a block, tile by tile
  std::vector<Weight> weights;  ///< of the same
  std::vector<float> alphas;  ///< of a block's pixels
  std::vector<Vec3> diagnostics;
  std::vector<float> mean_visibility;  ///< of the patches of a tile

  Worker(const Primaries::View& view, const CellLight& light, size_t padded_cells,
         const CellNeighbours& neighbours)
      : tracer(view), learner(padded_cells, &neighbours), estimator(light) {}
};

ProductRenderer::ProductRenderer(const Scene& scene, const Sensor& sensor, RenderContext& context,
                                 std::shared_ptr<const DistantCells> cells,
                                 const ProductSettings& settings)
    : scene_(scene),
      table_(scene),
      sensor_(sensor),
      context_(context),
      shared_cells_(std::move(cells)),
      cells_(*shared_cells_),
      settings_(settings),
      grid_(sensor.film().crop()),
      filter_(sensor.film().filter()),
      seed_(key_seed(context, sensor.sampler())),
      local_(make_local_light(scene, sensor, settings, seed_, context)),
      knowledge_(grid_, cells_, local_.get(), settings_),
      rays_left_(settings.rays_per_pixel) {
  if (local_ && local_->has_caustics()) {
    const StageTimer timer(context.stats().counters.stage_seconds["cells"]);
    caustics_.emplace(scene, sensor, *local_, seed_, context.stats().counters);
  }
}

std::unique_ptr<const LocalLight> make_local_light(const Scene& scene, const Sensor& sensor,
                                                   const ProductSettings& settings, uint64_t seed,
                                                   RenderContext& context) {
  const size_t others = scene.emitters().size() - (scene.environment() ? 1 : 0);
  if (others == 0 && settings.length.max_depth < LocalLight::kBounceDepth) return nullptr;
  const StageTimer timer(context.stats().counters.stage_seconds["cells"]);
  LocalLight::Settings local;
  local.length = settings.length;
  local.bounce_cells = settings.bounce_cells;
  local.caustics = Caustics::serves(sensor);
  // Where rays are few, points are, too: each takes about as long as two. Until an error is
  // reached, there will be many. What is rendered by parts draws as many for each.
  double rays = settings.rays_per_pixel * sensor.film().crop().area(), parts = 1;
  if (context.budget().any()) {
    const double seconds = context.budget().seconds;
    rays = seconds > 0 ? seconds * kCarefulSpeed * context.threads() : kInfinity;
    parts = kPartsOfBudget;
  }
  rays = std::min(rays, kMaxRaysOfPass * sensor.film().crop().area());
  local.points = static_cast<uint32_t>(
      std::clamp<double>(rays / kRaysPerPoint, LocalLight::kLeastPoints, LocalLight::kMostPoints));
  local.extended_points = static_cast<uint32_t>(
      std::min<double>(rays / (kRaysPerExtendedPoint * parts), LocalLight::kMostExtendedPoints));
  std::vector<SurfaceInteraction> seen;
  if (settings.light_guide &&
      (scene.has_surface_emitters() || settings.length.max_depth >= LocalLight::kBounceDepth)) {
    seen = places_seen(scene, sensor, std::max(kLeastPlaces, local.points / kPointsPerPlace), seed,
                       context);
  }
  auto light = std::make_unique<const LocalLight>(scene, local, seen, seed, context);
  return light->empty() ? nullptr : std::move(light);
}

Primaries::View ProductRenderer::view() const {
  return Primaries::view_of(table_, sensor_, filter_, settings_.hide_emitters);
}

/// What is known of each of the tile's patches.
void ProductRenderer::find_visibilities(int tile, Worker& worker) {
  worker.mean_visibility.clear();
  for (size_t p = 0; p < worker.patches.size(); ++p) {
    if (worker.visibility.size() == p) {
      worker.visibility.emplace_back().resize(knowledge_.padded_cells());
      worker.visibility.back().reset();
    }
    Patch& patch = worker.patches[p];
    Visibility& visibility = worker.visibility[p];
    knowledge_.recall(tile, p, patch, worker.learner, visibility);
    if (settings_.diagnostics) {
      worker.mean_visibility.push_back(mean_visibility(patch, visibility));
    }
    knowledge_.restrict(patch, visibility);
  }
}

void ProductRenderer::render_tile(const TileGrid::Tile& tile, TilePrimaries& primaries,
                                  const std::vector<PixelPlan>& plan, uint64_t seed, Worker& worker,
                                  RenderCounters& counters) {
  worker.patches = knowledge_.patches(tile.index);
  assign_patches(primaries, worker.patches);
  find_visibilities(tile.index, worker);
  find_units(primaries, plan, seed, worker);
  const std::span<const Unit> units = worker.units;
  worker.estimator.begin_tile(scene_, primaries, worker.patches, worker.visibility,
                              hash_words(seed, static_cast<uint64_t>(tile.index), 3), counters,
                              settings_.shared_candidates ? units : units.first(0));
  const size_t per_pixel = units_per_pixel();
  for (size_t i = 0; i < units.size(); ++i) {
    const Unit& unit = units[i];
    Rgb& sum = worker.sums.emplace_back(0.f);
    float hits = 0;
    for (uint32_t k = unit.first; k < unit.end; ++k) {
      sum += primaries.emitted(k);
      hits += primaries.hit(k) ? 1.f : 0.f;
    }
    if (i % per_pixel == 0) worker.alphas.push_back(0.f);
    worker.alphas.back() += worker.weights[worker.sums.size() - 1].of(hits);
    worker.estimator.estimate(unit, sum);
  }
  if (settings_.diagnostics) find_diagnostics(primaries, plan, worker);
}

/// Each pixel of a tile; where the filter is negative in parts, first what is positive and then what
/// is negative of it, by its share of the pixel's primaries.
void ProductRenderer::find_units(const TilePrimaries& primaries,
                                 const std::vector<PixelPlan>& plan, uint64_t seed,
                                 Worker& worker) const {
  const Rect& pixels = primaries.pixels();
  const Rect region = view().region;
  worker.units.clear();
  for (int i = 0; i < pixels.area(); ++i) {
    const int x = pixels.x0 + i % pixels.width(), y = pixels.y0 + i / pixels.width();
    const size_t pixel = grid_.pixel(x, y);
    const uint32_t ends[] = {primaries.first(i), primaries.first_negative(i),
                             primaries.first(i + 1)};
    const FilterSampler::Shares shares = filter_.shares(x, y, region);
    const float of_sign[] = {shares.positive, -shares.negative};
    for (size_t k = 0; k < units_per_pixel(); ++k) {
      const uint32_t first = ends[k], end = ends[k + 1];
      const float part = static_cast<float>(end - first) / static_cast<float>(ends[2] - ends[0]);
      const auto rays = static_cast<uint32_t>(std::ceil(part * plan[pixel].rays));
      worker.units.push_back({first, end, std::max<uint32_t>(rays, kLeastRays),
                              part * plan[pixel].candidates, hash_words(seed, pixel, 2 + 2 * k)});
      worker.weights.push_back({of_sign[k], static_cast<float>(end - first)});
    }
  }
}

/// Of the light that cells send to an unshadowed point, by what is learned.
float ProductRenderer::mean_visibility(const Patch& patch, const Visibility& visibility) const {
  double all = 0, visible = 0;
  for (uint32_t c = 0; c < cells_.size(); ++c) {
    const Vec3 axis(cells_.axis()[0][c], cells_.axis()[1][c], cells_.axis()[2][c]);
    const double light = cells_.flux()[c] * std::max(0.f, glm::dot(axis, patch.normal));
    all += light;
    visible += light * visibility.v[c];
  }
  if (cells_.size() == 0) return patch.mean_visibility;
  return all > 0 ? static_cast<float>(visible / all) : 0.f;
}

void ProductRenderer::find_diagnostics(const TilePrimaries& primaries,
                                       const std::vector<PixelPlan>& plan, Worker& worker) const {
  const Rect& pixels = primaries.pixels();
  for (int i = 0; i < pixels.area(); ++i) {
    const uint32_t first = primaries.first(i), end = primaries.first(i + 1);
    float visible = 0, lit = 0;
    for (uint32_t k = first; k < end; ++k) {
      if (primaries.patch(k) < 0) continue;
      visible += worker.mean_visibility[primaries.patch(k)];
      lit += 1;
    }
    const PixelPlan& p =
        plan[grid_.pixel(pixels.x0 + i % pixels.width(), pixels.y0 + i / pixels.width())];
    const auto samples = static_cast<float>(end - first);
    const float rays = lit > 0 ? static_cast<float>(std::max<uint32_t>(p.rays, kLeastRays)) : 0.f;
    worker.diagnostics.emplace_back(
        samples, samples + rays + (lit > 0 ? kCandidateCost * p.candidates : 0.f),
        lit > 0 ? visible / lit : 0.f);
  }
}

void ProductRenderer::pass(const CellLight& light, const std::vector<PixelPlan>& plan,
                           uint64_t seed, float weight) {
  const auto make = [&] {
    return std::make_unique<Worker>(view(), light, knowledge_.padded_cells(), neighbours_);
  };
  grid_.for_each_block<Worker>(
      context_, grid_.all_rows(), "main", make,
      [&](int block, Worker& worker, RenderCounters& counters) {
        if (!context_.is_wanted(grid_.block(block), sensor_.film().first_layer())) return;
        worker.sums.clear();
        worker.sums.reserve(units_per_pixel() * TileGrid::kBlockSide * TileGrid::kBlockSide);
        worker.weights.clear();
        worker.alphas.clear();
        worker.diagnostics.clear();
        worker.tracer.trace(
            grid_, block, seed, counters.stage_seconds["primary"], counters,
            [&](int x, int y) {
              // Of each sign one.
              return std::max<uint16_t>(plan[grid_.pixel(x, y)].primaries,
                                        static_cast<uint16_t>(units_per_pixel()));
            },
            [&](const TileGrid::Tile& tile, TilePrimaries& primaries) {
              render_tile(tile, primaries, plan, seed, worker, counters);
            });
        worker.estimator.flush();
        const StageTimer timer(counters.stage_seconds["film"]);
        add_to_film(block, seed, weight, worker, counters);
      });
}

/// At once, block by block: an interrupted render has what was finished.
void ProductRenderer::add_to_film(int block, uint64_t seed, float weight, Worker& worker,
                                  RenderCounters& counters) {
  Film& film = sensor_.film();
  const Rect pixels = grid_.block(block);
  FilmTile colours = film.make_tile(pixels);
  std::optional<FilmTile> diagnostics;
  if (settings_.diagnostics) diagnostics = film.make_tile(pixels, 1);
  size_t next = 0;
  grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
    for (int y = tile.pixels.y0; y < tile.pixels.y1; ++y) {
      for (int x = tile.pixels.x0; x < tile.pixels.x1; ++x, ++next) {
        Rgb c(0.f);
        for (size_t k = next * units_per_pixel(); k < (next + 1) * units_per_pixel(); ++k) {
          c += worker.weights[k].of(worker.sums[k]);
        }
        const float values[4] = {c.x, c.y, c.z, worker.alphas[next]};
        colours.add_pixel(x, y, {values, film.has_alpha() ? 4u : 3u}, weight);
        if (!diagnostics) continue;
        const Vec3& d = worker.diagnostics[next];
        diagnostics->add_pixel(x, y, std::array{d.x, d.y, d.z}, weight);
      }
    }
  });
  if (caustics_) {
    const double paths = std::ceil(weight * unit_ / kRaysPerCausticPath * pixels.area());
    caustics_->trace(hash_words(seed, static_cast<uint64_t>(block), kCausticSeed),
                     static_cast<uint32_t>(paths), colours, counters);
  }
  context_.commit(film, static_cast<size_t>(block),
                  {&colours, diagnostics ? &*diagnostics : nullptr});
}

CellLight ProductRenderer::make_light(uint64_t seed, double rays_per_pixel) const {
  const StageTimer timer(context_.stats().counters.stage_seconds["points"]);
  const uint64_t own = hash_words(seed_, seed);
  CellPoints points;
  if (cells_.size() > 0) {
    points = cells_.draw_points(CellLight::points_for(rays_per_pixel * grid_.crop().area()), own,
                                context_);
  }
  LocalPoints local_points;
  if (local_) local_points = local_->draw(hash_words(own, 1), context_);
  CellLight light(cells_, scene_.environment(), std::move(points), local_.get(),
                  std::move(local_points));
  light.length = settings_.length;
  light.horizon_terms = settings_.control_variate && settings_.horizon_terms;
  return light;
}

void ProductRenderer::learn_from_pilot(double rays_per_pixel) {
  if (rays_per_pixel < kLeastToLearn) {
    context_.skip("pilot", "a few rays a pixel are too few to learn from");
    return;
  }
  const double start = context_.seconds();
  Pilot::Effort effort;
  effort.primaries = rays_per_pixel < 24 ? 1 : rays_per_pixel < 60 ? 2 : 4;
  effort.rays = effort.primaries == 1 ? kPilotRaysOfOne : kPilotRays * effort.primaries;
  if (sensor_.needs_aperture_sample()) {
    effort.primaries *= kLensPrimaries;
    effort.rays = kLensRays * effort.primaries;
  }
  const uint32_t rays = effort.primaries + effort.rays;
  if (cells_.size() > 0) neighbours_ = find_neighbours(cells_, context_);
  const CellLight light = make_light(0, rays);
  const auto forecast =
      Pilot(scene_, view(), grid_, neighbours_, local_.get(), settings_, seed_, context_)
          .learn(light, effort, rays / std::max<double>(rays_per_pixel, 1), knowledge_);
  knowledge_.finish();
  if (!context_.cancelled()) {
    const StageTimer timer(context_.stats().counters.stage_seconds["allocate"]);
    const bool is_noisy = effort.primaries < kPrimariesToTell && settings_.smooth_plan;
    allocation_.emplace(forecast, grid_.crop().width(), grid_.crop().height(),
                        !settings_.adaptive ? RayAllocation::Mode::kEven
                        : is_noisy          ? RayAllocation::Mode::kSmoothed
                                            : RayAllocation::Mode::kAdaptive);
  }
  pilot_rays_ = rays;
  rays_left_ = std::max(0., rays_left_ - rays);
  pilot_seconds_ = context_.seconds() - start;
}

void ProductRenderer::learn_in_time(double seconds) {
  context_.set_deadline(context_.seconds() + kPilotShare * seconds);
  if (!context_.cancelled()) {
    learn_from_pilot(seconds * kCarefulSpeed * context_.threads() /
                     std::max(1, grid_.crop().area()));
  }
  if (context_.cancelled()) {
    // What only some tiles have learned is of no use.
    pilot_rays_ = 0;
    allocation_.reset();
    knowledge_.forget();
    context_.skip("pilot", "there was too little time for it");
  }
  context_.set_deadline(kInfinity);
}

double ProductRenderer::seconds_per_sample() const {
  // A pilot that was given up leaves its time: of the least that there can be.
  return kRaysPerSample * pilot_seconds_ / std::max(1 + kPilotRaysOfOne, pilot_rays_);
}

std::vector<PixelPlan> ProductRenderer::plan_pass(double rays_per_pixel) const {
  const StageTimer timer(context_.stats().counters.stage_seconds["allocate"]);
  if (allocation_) {
    return allocation_->plan(rays_per_pixel);
  }
  PixelPlan plan;
  plan.primaries = static_cast<uint16_t>(std::max(1., rays_per_pixel / 3));
  plan.rays = static_cast<uint16_t>(std::max(1., rays_per_pixel - plan.primaries));
  plan.candidates = static_cast<float>(kCandidatesUnlearned * plan.rays);
  return std::vector<PixelPlan>(static_cast<size_t>(grid_.crop().area()), plan);
}

/// In passes as large as may be: the more rays share a comb, the better each of them does.
void ProductRenderer::render_rays(double rays_per_pixel, double progress_begin, bool is_last) {
  const auto passes =
      static_cast<uint64_t>(std::max(1., std::ceil(rays_per_pixel / kMaxRaysOfPass)));
  // Of the comb and all that goes with it; paths of caustics are a fixed share of these.
  const double of_caustics = caustics_ ? caustics_->rays_per_path() / kRaysPerCausticPath : 0;
  const double rays = rays_per_pixel / static_cast<double>(passes) / (1 + of_caustics);
  const std::vector<PixelPlan> plan = plan_pass(rays);
  if (is_last) allocation_.reset();  // of a large picture, a good part of the memory
  if (unit_ == 0) unit_ = std::max(rays, 1.);
  const auto weight = static_cast<float>(std::max(rays, 1.) / unit_);
  for (uint64_t i = 0; i < passes && !context_.cancelled(); ++i, ++pass_) {
    const double part = (1 - progress_begin) / static_cast<double>(passes);
    const double begin = progress_begin + part * static_cast<double>(i);
    context_.set_progress_range(begin, begin + part);
    pass(make_light(1 + pass_, rays), plan, hash_words(seed_, kPassSeed, pass_), weight);
  }
  context_.set_progress_range(0, 1);
}

double ProductRenderer::render(double samples) {
  render_rays(kRaysPerSample * samples, 0, false);
  return samples;
}

void ProductRenderer::render_all() {
  learn_from_pilot(settings_.rays_per_pixel);
  const double asked = std::max(settings_.rays_per_pixel, 1.);
  if (!context_.cancelled()) render_rays(rays_left_, std::max(0., 1 - rays_left_ / asked), true);
}

bool is_product_scene(const Scene& scene, uint32_t max_depth) {
  const Emitter* const environment = scene.environment();
  return (!environment || environment->cell_grid()) && LocalLight::serves(scene, max_depth);
}

void render_product(const Scene& scene, const Sensor& sensor, RenderContext& context,
                    std::shared_ptr<const DistantCells> cells, const ProductSettings& settings) {
  ProductRenderer(scene, sensor, context, std::move(cells), settings).render_all();
}

std::unique_ptr<Passes> begin_product(const Scene& scene, const Sensor& sensor,
                                      RenderContext& context,
                                      std::shared_ptr<const DistantCells> cells,
                                      const ProductSettings& settings, double seconds) {
  auto renderer =
      std::make_unique<ProductRenderer>(scene, sensor, context, std::move(cells), settings);
  const RenderBudget& budget = context.budget();
  context.begin_pass(0, 0, 0);  // the pilot's share of the progress isn't known
  if (budget.seconds > 0) {
    renderer->learn_in_time(seconds);
  } else {
    renderer->learn_from_pilot(budget.rel_mse > 0 ? kRaysOfUnknown : settings.rays_per_pixel);
  }
  return renderer;
}

}  // namespace kinome
