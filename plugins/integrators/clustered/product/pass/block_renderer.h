#pragma once

#include <functional>
#include <vector>

#include "clustered/product/strata/estimator.h"
#include "clustered/product/pilot/plan.h"
#include "clustered/product/tiles/product_sampling.h"
#include "clustered/product/pilot/tile_knowledge.h"
#include "clustered/product/tiles/tile_tracer.h"

namespace kinome {

/// Input of a pass, shared by all threads. All references must outlive it.
struct PassView {
  const ProductTask& task;
  Primaries::View primaries;
  const TileKnowledge& knowledge;
  const CellNeighbours& neighbours;
  const CellLight& light;
};

/// Renders the pixels of a block with the learned visibility of its tiles. Reuses its memory; one
/// per thread. Not thread-safe.
class BlockRenderer {
 public:
  explicit BlockRenderer(const PassView& view);

  /// Renders the tiles of the block that `is_wanted` accepts (all tiles if it is empty). `plan` has
  /// an entry for each pixel of the image.
  void render(int block, std::span<const PixelPlan> plan, uint64_t seed, RenderCounters& counters,
              const TileGrid::IsWanted& is_wanted = nullptr);

  /// Number of pixels rendered last. Pixels are in the order of tiles (TileGrid::for_each_tile),
  /// row by row within a tile.
  size_t size() const { return pixels_.size(); }
  /// Returns the mean over the pixel's samples, which are spread evenly over the pixel.
  Rgb colour(size_t pixel) const;
  /// Returns the values of kProductChannels. Valid only if ProductSettings::diagnostics is set.
  const Vec3& diagnostics(size_t pixel) const { return diagnostics_[pixel]; }

  /// Adds the pixels of the block rendered last to a tile of the film, each with the same total
  /// weight: their samples one by one if is_split(), else their means.
  void add_to(FilmTile& colours, float weight) const;

 private:
  /// A pixel of the block rendered last.
  struct Pixel {
    int x, y;
    size_t first;  ///< index of the first sum in sums_
    uint32_t samples;
    float alpha;  ///< mean over the samples
  };
  /// Film positions and alpha of the block's samples.
  struct Samples {
    std::vector<float> x, y;  ///< on the full film
    std::vector<float> alpha;
  };

  /// True if samples of a pixel have different weights in the film.
  bool is_split() const { return is_split_; }
  /// Number of values of layer 0 of the film before those of light groups: colour and alpha.
  size_t first_group_value() const { return view_.primaries.sensor.film().has_alpha() ? 4 : 3; }
  void set_sample(const Rgb* sums, size_t k, float response,
                  std::span<Column<float>> columns) const;
  void add_samples(FilmTile& colours, float weight) const;
  void render_tile(const TileGrid::Tile& tile, TilePrimaries& primaries,
                   std::span<const PixelPlan> plan, uint64_t seed, RenderCounters& counters);
  void find_visibilities(int tile);
  void find_units(const TileGrid::Tile& tile, const TilePrimaries& primaries,
                  std::span<const PixelPlan> plan, uint64_t seed);
  void reserve(int block, std::span<const PixelPlan> plan);
  uint16_t samples_of(const PixelPlan& plan) const { return std::max<uint16_t>(plan.primaries, 1); }
  float mean_visibility(const Patch& patch, const Visibility& visibility) const;
  void find_diagnostics(const TilePrimaries& primaries);

  const PassView view_;
  const bool is_split_;
  const uint32_t groups_;  ///< CellLight::group_count()
  TileTracer tracer_;
  VisibilityLearner learner_;
  Estimator estimator_;
  // Current tile:
  std::vector<Patch> patches_;
  std::vector<Visibility> visibility_;
  std::vector<float> mean_visibility_;  ///< of each patch
  std::vector<Unit> units_;             ///< one per pixel
  // Current block:
  /// Sums of the light groups, for each sample if is_split(), else for each pixel.
  std::vector<Rgb> sums_;
  std::vector<Pixel> pixels_;
  Samples samples_;  ///< if is_split()
  std::vector<Vec3> diagnostics_;
};

}  // namespace kinome
