#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "clustered/product/estimator.h"
#include "clustered/product/plan.h"
#include "clustered/product/tile_knowledge.h"
#include "clustered/product/tile_tracer.h"

namespace kinome {

/// Finds out what a picture looks like before any of its passes: a few primaries of each pixel, and
/// rays from them to cells, of which tiles learn visibilities, and pixels what they need. What it
/// sees is not part of the picture. For one render.
class Pilot {
 public:
  struct Effort {
    uint32_t primaries = 0;  ///< of each pixel
    uint32_t rays = 0;       ///< of each pixel
  };

  /// All must outlive it.
  Pilot(const Scene& scene, const Primaries::View& view, const TileGrid& grid,
        const CellNeighbours& neighbours, const LocalLight* local, const ProductSettings& settings,
        uint64_t seed, RenderContext& context,
        BsdfAddresses& addresses);

  using IsWanted = std::function<bool(const TileGrid::Tile&)>;
  /// Looks at the tiles that are wanted, or at all if `is_wanted` is empty. Forecasts of other tiles
  /// are zero. Band by band of blocks, each of which is planned when the next one has been seen, so that the
  /// points of no more than two are kept; that may be stopped by `context`, and what is known is
  /// then of no use. The forecast of each pixel of the crop window.
  std::vector<PixelForecast> learn(const CellLight& light, Effort effort,
                                   const IsWanted& is_wanted, double progress_end,
                                   TileKnowledge& knowledge);

 private:
  /// What the plan needs of a primary.
  struct Point {
    Vec3 reflected{0.f};  ///< normal x mean diffuse reflectance
    float known = 0;      ///< light that it sees itself, or unshadowed glossy light
    float lamps = 0;      ///< PointPlan::lamps
    float lit = 0;        ///< of the other lamps, what arrives
    float glossy_deviation = 0;
    Rgb followed{0.f};    ///< what a path from it finds, where one goes on (is_followed)
    bool is_followed = false;
    int16_t patch = -1;
  };
  struct Prober;
  struct Planner;

  int rows_of_band() const;
  TileGrid::Rows band(int index) const;
  /// Of a pixel, of the band at work or the one before.
  Point* points_of(int x, int y);
  /// Returns which process has probed which block: the one that plans it.
  std::vector<int> probe(TileGrid::Rows rows, const CellLight& light, TileKnowledge& knowledge);
  void probe_tile(const TileGrid::Tile& tile, TilePrimaries& primaries, TileKnowledge& knowledge,
                  Prober& prober, RenderCounters& counters);
  void plan(TileGrid::Rows rows, std::vector<int> makers, const CellLight& light,
            TileKnowledge& knowledge);
  void plan_tile(const TileGrid::Tile& tile, TileKnowledge& knowledge, Planner& planner);
  bool is_wanted(const TileGrid::Tile& tile) const { return !is_wanted_ || is_wanted_(tile); }
  PixelForecast forecast(const std::vector<Patch>& patches, const float* controls, int x, int y);

  const Scene& scene_;
  const Primaries::View view_;
  const TileGrid& grid_;
  const CellNeighbours& neighbours_;
  const LocalLight* local_;  ///< nullptr: there is none
  const ProductSettings& settings_;
  const uint64_t seed_;
  RenderContext& context_;
  BsdfAddresses& addresses_;
  Effort effort_;
  IsWanted is_wanted_;
  std::vector<Point> points_[2];  ///< of bands of even and odd number
  std::vector<PixelForecast> forecast_;
};

}  // namespace kinome
