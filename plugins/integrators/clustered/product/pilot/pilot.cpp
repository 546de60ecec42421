#include "clustered/product/pilot/pilot.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Number of pixels of a band, which is enough work for many threads. Points of two bands are kept
/// until they are planned.
constexpr int kPixelsOfBand = 1 << 16;
/// Separates the pilot's random numbers from those of the passes.
constexpr uint64_t kPilotSeed = 0x70696c6f74;
/// Factor of the candidates' variance, which is small compared with that of shadows.
constexpr float kGlossyFactor = 2;
/// Cost of an eye ray in rays, including the light of the point that it hits.
constexpr float kEyeRayCost = 2.5f;
/// Cost of a path that continues from a primary.
constexpr float kPathCost = 1;

}  // namespace

/// Data of a thread that probes blocks.
struct Pilot::Prober {
  TileTracer tracer;
  Estimator estimator;
  std::vector<Visibility> unknown;
  std::vector<PointPlan> points;
  // Patches and records of the tiles of the block. Rays that wait refer to them.
  std::vector<Patch> patches[TileGrid::kMaxTilesOfBlock];
  std::vector<std::vector<VisibilityRecord>> records[TileGrid::kMaxTilesOfBlock];

  Prober(const Primaries::View& view, const CellLight& light) : tracer(view), estimator(light) {}
};

/// Data of a thread that plans.
struct Pilot::Planner {
  VisibilityLearner learner;
  DiffuseStrata strata;
  Visibility visibility;
  std::vector<Patch> patches;  ///< of the tile
  std::vector<float> controls;

  Planner(const CellLight& light, size_t padded_cells, const CellNeighbours& neighbours)
      : learner(padded_cells, &neighbours), strata(light), visibility(padded_cells) {}
};

Pilot::Pilot(const ProductTask& task, const Primaries::View& view, const CellLight& light,
             const CellNeighbours& neighbours, Effort effort, const TileGrid::IsWanted& is_wanted,
             BsdfAddresses& addresses, TileKnowledge& knowledge)
    : task_(task),
      context_(task.context),
      grid_(task.grid),
      view_(view),
      light_(light),
      neighbours_(neighbours),
      effort_(effort),
      is_wanted_(is_wanted),
      seed_(hash_words(task.seed, kPilotSeed)),
      addresses_(addresses),
      knowledge_(knowledge) {}

int Pilot::rows_of_band() const {
  const int pixels = std::min(task_.settings.remembered_pixels, kPixelsOfBand);
  return std::clamp(pixels / (grid_.crop().width() * grid_.block_side()), 1,
                    std::max(1, grid_.blocks_y()));
}

TileGrid::Rows Pilot::band(int index) const {
  const int rows = rows_of_band();
  return {index * rows, std::min((index + 1) * rows, grid_.blocks_y())};
}

Rect Pilot::square_of(int x, int y) const {
  const Rect& crop = grid_.crop();
  const int side = effort_.side;
  const int left = x - (x - crop.x0) % side, top = y - (y - crop.y0) % side;
  return {left, top, std::min(left + side, crop.x1), std::min(top + side, crop.y1)};
}

/// True for one random pixel of each square.
bool Pilot::is_probed(int x, int y) const {
  if (effort_.side == 1) return true;
  const Rect square = square_of(x, y);
  const uint64_t random = hash_words(seed_, grid_.pixel(square.x0, square.y0), 3);
  return static_cast<int>(random % static_cast<uint64_t>(square.area())) ==
         (y - square.y0) * square.width() + x - square.x0;
}

Pilot::Point* Pilot::points_of(const TileGrid::Tile& tile) {
  const int tiles = rows_of_band() * grid_.tiles_across() * grid_.tiles_x();
  const auto place = static_cast<size_t>(tile.index % tiles);
  return &points_[tile.index / tiles % 2][place * kTileSide * kTileSide * effort_.primaries];
}

LargeArray<PixelForecast> Pilot::learn(double progress_end) {
  // A tile at the border of a band learns from tiles of the next band.
  static_assert(TileKnowledge::kReach <= kSmallTileSize / kTileSide);
  const Rect& crop = grid_.crop();
  const int rows = rows_of_band(), bands = (grid_.blocks_y() + rows - 1) / rows;
  const auto tiles = static_cast<size_t>(rows) * grid_.tiles_across() * grid_.tiles_x();
  forecast_ = LargeArray<PixelForecast>(static_cast<size_t>(crop.area()));
  std::vector<int> ranks;  // processes that probed the previous band
  for (int i = 0; i <= bands && !context_.job.cancelled(); ++i) {
    context_.job.set_progress_range(progress_end * i / (bands + 1),
                                    progress_end * (i + 1) / (bands + 1));
    std::vector<int> probed;
    if (i < bands) {
      points_[i % 2].resize(tiles * kTileSide * kTileSide * effort_.primaries);
      probed = probe(band(i));
    }
    if (i > 0 && !context_.job.cancelled()) plan(band(i - 1), std::move(ranks));
    ranks = std::move(probed);
  }
  for (auto& points : points_) points = {};
  return std::move(forecast_);
}

std::vector<int> Pilot::probe(TileGrid::Rows rows) {
  // Neighbours learn from the records. Points are only for the plan and stay where they are.
  SharedItems shared([&](size_t item, SharedBytes& bytes) {
    grid_.for_each_tile(grid_.first_block(rows) + static_cast<int>(item),
                        [&](const TileGrid::Tile& tile) {
                          knowledge_.transfer_kept(tile.index, bytes, addresses_);
                        });
  });
  grid_.for_each_block<Prober>(
      context_.scheduler, rows, "pilot", [&] { return std::make_unique<Prober>(view_, light_); },
      [&](int block, Prober& prober, RenderCounters& counters) {
        double uncounted = 0;  // the pilot is one stage
        for (std::vector<Patch>& patches : prober.patches) patches.clear();
        prober.tracer.trace(
            grid_, block, seed_, uncounted, counters,
            [&](const TileGrid::Tile& tile) {
              context_.job.check_interrupt();
              return is_wanted(tile);
            },
            [&](int x, int y) {
              return static_cast<uint16_t>(is_probed(x, y) ? effort_.primaries : 0);
            },
            [&](const TileGrid::Tile& tile, TilePrimaries& primaries) {
              probe_tile(tile, primaries, prober, counters);
            });
        prober.estimator.flush();
        grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
          if (!is_wanted(tile)) return;
          knowledge_.keep(tile.index, prober.patches[tile.place], prober.records[tile.place]);
        });
      },
      &shared);
  return shared.ranks();
}

void Pilot::probe_tile(const TileGrid::Tile& tile, TilePrimaries& primaries, Prober& prober,
                       RenderCounters& counters) {
  std::vector<Patch>& patches = prober.patches[tile.place];
  make_patches(primaries, patches);
  while (prober.unknown.size() < patches.size()) {
    prober.unknown.emplace_back(knowledge_.padded_cells());
  }
  auto& records = prober.records[tile.place];
  if (records.size() < patches.size()) records.resize(patches.size());
  for (auto& r : records) r.clear();
  prober.points.assign(primaries.size(), {});
  Point* const points = points_of(tile);
  for (size_t i = 0; i < primaries.size(); ++i) {
    Point& point = points[i];
    point = {};
    prober.points[i].lit = &point.lit;
    prober.points[i].followed = &point.followed;
    point.is_followed = primaries.goes_on(i);
  }
  for (Patch& patch : patches) patch.glossy = patch.eye_rays = 0;
  const auto index = static_cast<uint64_t>(tile.index);
  prober.estimator.begin_tile(task_.scene, primaries, patches, prober.unknown,
                              hash_words(seed_, index, 2), counters);
  size_t lit = 0;
  for (size_t i = 0; i < primaries.size(); ++i) lit += primaries.patch(i) >= 0;
  Unit unit;
  unit.end = static_cast<uint32_t>(primaries.size());
  unit.rays = static_cast<uint32_t>(lit * effort_.rays / effort_.primaries);
  unit.seed = hash_words(seed_, index, 1);
  prober.estimator.probe(unit, prober.points, records);
  for (size_t i = 0; i < primaries.size(); ++i) {
    Point& point = points[i];
    point.patch = static_cast<int16_t>(primaries.patch(i));
    const PointPlan& plan = prober.points[i];
    point.known = mean_of(primaries.emitted(i)) + plan.glossy + plan.mirrored;
    point.lamps = plan.lamps;
    point.glossy_deviation = static_cast<float>(std::sqrt(plan.glossy_variance));
    if (point.patch >= 0) {
      point.reflected = primaries.normal(i) * mean_of(primaries.diffuse(i));
    }
  }
}

void Pilot::plan(TileGrid::Rows rows, std::vector<int> ranks) {
  SharedItems shared([&](size_t item, SharedBytes& bytes) {
    grid_.for_each_tile(
        grid_.first_block(rows) + static_cast<int>(item), [&](const TileGrid::Tile& tile) {
          knowledge_.transfer_learned(tile.index, bytes);
          tile.for_each_pixel([&](int x, int y) { bytes.value(forecast_[grid_.pixel(x, y)]); });
        });
  });
  shared.assign(std::move(ranks));
  grid_.for_each_block<Planner>(
      context_.scheduler, rows, "plan",
      [&] { return std::make_unique<Planner>(light_, knowledge_.padded_cells(), neighbours_); },
      [&](int block, Planner& planner, RenderCounters&) {
        grid_.for_each_tile(block, [&](const TileGrid::Tile& tile) {
          context_.job.check_interrupt();
          if (is_wanted(tile)) plan_tile(tile, planner);
        });
      },
      &shared);
}

void Pilot::plan_tile(const TileGrid::Tile& tile, Planner& planner) {
  std::vector<Patch>& patches = planner.patches;
  knowledge_.patches(tile.index, patches);
  planner.controls.assign(patches.size() * 9, 0.f);
  knowledge_.learn(tile.index, patches, planner.learner, planner.visibility,
                   [&](size_t p, const Visibility& visibility) {
                     Patch& patch = patches[p];
                     const auto plan = planner.strata.plan(patch, visibility);
                     std::copy(plan.control, plan.control + 9, &planner.controls[p * 9]);
                     patch.uncertainty = plan.uncertainty + patch.glossy * patch.mean_sigma;
                   });
  const Point* points = points_of(tile);
  tile.for_each_pixel([&](int x, int y) {
    if (!is_probed(x, y)) return;
    const PixelForecast found = forecast(patches, planner.controls.data(), points);
    points += effort_.primaries;
    const Rect square = square_of(x, y);
    for (int v = square.y0; v < square.y1; ++v) {
      for (int u = square.x0; u < square.x1; ++u) forecast_[grid_.pixel(u, v)] = found;
    }
  });
}

PixelForecast Pilot::forecast(const std::vector<Patch>& patches, const float* controls,
                              const Point* points) const {
  PixelForecast forecast;
  double sum = 0, squares = 0, glossy_variance = 0, followed = 0;
  for (uint32_t k = 0; k < effort_.primaries; ++k) {
    const Point& point = points[k];
    float value = point.known + mean_of(point.followed);
    if (point.patch >= 0) {
      const Patch& patch = patches[point.patch];
      const float* const control = controls + point.patch * 9;
      Vec3 light(0.f);
      for (int i = 0; i < 9; ++i) light[i % 3] += control[i] * (1 / 3.f);
      value = std::max(
          0.f, kInvPi * glm::dot(light, point.reflected) + point.known * patch.mean_visibility);
      value += point.lit + std::max(0.f, point.lamps) * patch.lamp_visibility;
      forecast.uncertainty += patch.uncertainty;
      const double deviation = point.glossy_deviation * patch.mean_visibility;
      glossy_variance += deviation * deviation * kGlossyFactor;
      const bool mirrors = any(patch.bsdf->lobes() & Lobe::kDelta);
      forecast.mirrors += mirrors ? 1.f : 0.f;
      if (light_.local) {
        forecast.mirrors += kEyeRayCost * expected_eye_rays(patch, *light_.local);
      }
      forecast.sharp = forecast.sharp || mirrors || is_sharp(patch);
    }
    if (point.is_followed) {
      forecast.mirrors += kPathCost;
      forecast.sharp = true;
    }
    followed += mean_of(glm::abs(point.followed));
    sum += value;
    squares += static_cast<double>(value) * value;
  }
  const double n = effort_.primaries;
  forecast.mean = static_cast<float>(sum / n);
  forecast.uncertainty /= static_cast<float>(n);
  forecast.glossy_deviation = static_cast<float>(std::sqrt(glossy_variance / n));
  forecast.mirrors /= static_cast<float>(n);
  if (n > 1) {
    forecast.deviation =
        static_cast<float>(std::sqrt(std::max(0., (squares - sum * sum / n) / (n - 1))));
  } else {
    // The deviation of one path is about its value.
    forecast.deviation = static_cast<float>(followed);
  }
  return forecast;
}

}  // namespace kinome
