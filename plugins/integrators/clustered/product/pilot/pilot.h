#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "clustered/product/strata/estimator.h"
#include "clustered/product/pilot/plan.h"
#include "clustered/product/pilot/tile_knowledge.h"
#include "clustered/product/tiles/tile_tracer.h"

namespace kinome {

/// The pilot of one render. It sends a few primaries per pixel, and shadow rays from them to cells.
/// Tiles learn visibilities from these rays, and each pixel gets a forecast for the plan. The
/// pilot's rays are not part of the image.
class Pilot {
 public:
  struct Effort {
    uint32_t primaries = 0;  ///< of each probed pixel
    uint32_t rays = 0;       ///< of each probed pixel
    /// The pilot probes one pixel of each square of this side, a divisor of kTileSide. The forecast
    /// of this pixel is that of the whole square.
    int side = 1;

    /// Mean over all pixels.
    double rays_per_pixel() const { return static_cast<double>(primaries + rays) / (side * side); }
  };

  /// Probes the wanted tiles (all if `is_wanted` is empty). All references must outlive the pilot.
  Pilot(const ProductTask& task, const Primaries::View& view, const CellLight& light,
        const CellNeighbours& neighbours, Effort effort, const TileGrid::IsWanted& is_wanted,
        BsdfAddresses& addresses, TileKnowledge& knowledge);

  /// Returns the forecast of each pixel of the crop window; it is zero in tiles that aren't wanted.
  /// Works in bands of blocks: a band is planned after the next one is probed, so that the points
  /// of at most two bands are kept. If the render is cancelled, the result and the knowledge are
  /// incomplete and must not be used.
  LargeArray<PixelForecast> learn(double progress_end);

 private:
  /// Data of a primary that the plan needs.
  struct Point {
    Vec3 reflected{0.f};  ///< normal x mean diffuse reflectance
    float known = 0;      ///< light that the primary sees directly, plus unshadowed glossy light
    float lamps = 0;      ///< PointPlan::lamps
    float lit = 0;        ///< light that arrives from lamps that got rays
    float glossy_deviation = 0;
    Rgb followed{0.f};  ///< light that its path finds, if one continues from it (is_followed)
    bool is_followed = false;
    int16_t patch = -1;
  };
  struct Prober;
  struct Planner;

  int rows_of_band() const;
  TileGrid::Rows band(int index) const;
  /// Pixels of the square of Effort::side that contains the pixel, inside the crop window.
  Rect square_of(int x, int y) const;
  bool is_probed(int x, int y) const;
  /// Points of a tile in the current band or the previous one, pixel by pixel. All probed pixels
  /// have the same number of points.
  Point* points_of(const TileGrid::Tile& tile);
  /// Returns for each block the process that probed it. The same process plans it.
  std::vector<int> probe(TileGrid::Rows rows);
  void probe_tile(const TileGrid::Tile& tile, TilePrimaries& primaries, Prober& prober,
                  RenderCounters& counters);
  void plan(TileGrid::Rows rows, std::vector<int> ranks);
  void plan_tile(const TileGrid::Tile& tile, Planner& planner);
  bool is_wanted(const TileGrid::Tile& tile) const { return !is_wanted_ || is_wanted_(tile); }
  PixelForecast forecast(const std::vector<Patch>& patches, const float* controls,
                         const Point* points) const;

  const ProductTask& task_;
  RenderContext& context_;
  const TileGrid& grid_;
  const Primaries::View view_;
  const CellLight& light_;
  const CellNeighbours& neighbours_;
  const Effort effort_;
  const TileGrid::IsWanted is_wanted_;
  const uint64_t seed_;
  BsdfAddresses& addresses_;
  TileKnowledge& knowledge_;
  LargeArray<Point> points_[2];  ///< points of the bands with even and odd index
  LargeArray<PixelForecast> forecast_;
};

}  // namespace kinome
