#pragma once

#include <functional>
#include <vector>

#include "clustered/product/estimator.h"
#include "clustered/product/plan.h"
#include "clustered/product/product_sampling.h"
#include "clustered/product/tile_knowledge.h"
#include "clustered/product/tile_tracer.h"

namespace kinome {

/// What a pass renders of, the same for all threads. All must outlive it.
struct PassView {
  const Scene& scene;
  Primaries::View primaries;
  const TileGrid& grid;
  const DistantCells& cells;
  const TileKnowledge& knowledge;
  const CellNeighbours& neighbours;
  const ProductSettings& settings;
  const CellLight& light;
};

/// Renders the pixels of a block by what is known of its tiles. Keeps its memory: one per thread.
/// Not thread-safe.
class BlockRenderer {
 public:
  explicit BlockRenderer(const PassView& view);

  using IsWanted = std::function<bool(const TileGrid::Tile&)>;
  /// `plan`: of all pixels of the picture. Without `is_wanted`, all tiles of the block are.
  void render(int block, const std::vector<PixelPlan>& plan, uint64_t seed,
              RenderCounters& counters, const IsWanted& is_wanted = nullptr);

  /// Of what was rendered last, pixel by pixel: tile by tile (TileGrid::for_each_tile), row by row.
  size_t size() const { return alphas_.size(); }
  Rgb colour(size_t pixel) const;
  float alpha(size_t pixel) const { return alphas_[pixel]; }
  /// kProductChannels, if the settings ask for them.
  const Vec3& diagnostics(size_t pixel) const { return diagnostics_[pixel]; }

 private:
  /// What the sum over a unit's primaries counts for in its pixel. A unit has none where a narrow
  /// film cuts off all that is negative of the filter.
  struct Weight {
    float share, primaries;
    template <class Value>
    Value of(const Value& sum) const {
      return primaries > 0 ? share * (sum / primaries) : Value(0.f);
    }
  };

  /// Of a pixel: two, where the filter is negative in parts.
  size_t units_per_pixel() const { return view_.primaries.filter.has_negative() ? 2 : 1; }
  void render_tile(const TileGrid::Tile& tile, TilePrimaries& primaries,
                   const std::vector<PixelPlan>& plan, uint64_t seed, RenderCounters& counters);
  void find_visibilities(int tile);
  void find_units(const TilePrimaries& primaries, const std::vector<PixelPlan>& plan,
                  uint64_t seed);
  float mean_visibility(const Patch& patch, const Visibility& visibility) const;
  void find_diagnostics(const TilePrimaries& primaries, const std::vector<PixelPlan>& plan);

  const PassView view_;
  TileTracer tracer_;
  VisibilityLearner learner_;
  Estimator estimator_;
  // Of the tile at work:
  std::vector<Patch> patches_;
  std::vector<Visibility> visibility_;
  std::vector<float> mean_visibility_;  ///< of the patches
  std::vector<Unit> units_;             ///< pixels, or what is positive and negative of them
  // Of the block:
  std::vector<Rgb> sums_;        ///< of the units
  std::vector<Weight> weights_;  ///< of the same
  std::vector<float> alphas_;
  std::vector<Vec3> diagnostics_;
};

}  // namespace kinome
