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
  size_t size() const { return pixels_.size(); }
  /// Mean over the pixel's samples, which are spread evenly over the pixel.
  Rgb colour(size_t pixel) const;
  /// kProductChannels, if the settings ask for them.
  const Vec3& diagnostics(size_t pixel) const { return diagnostics_[pixel]; }

  /// Adds the pixels of the block rendered last to a tile of the film, each with the same total
  /// weight: their samples one by one if is_split(), else their means.
  void add_to(FilmTile& colours, float weight) const;

 private:
  /// A pixel of the block rendered last.
  struct Pixel {
    int x, y;
    size_t first;  ///< index of its first sum in sums_ and, if is_split(), in samples_
    uint32_t samples;
    float alpha;  ///< mean over the samples
  };
  /// Film positions and alpha of the block's samples.
  struct Samples {
    std::vector<float> x, y;  ///< on the full film
    std::vector<float> alpha;
    void clear();
    void add(const Vec2& position, float alpha_of_sample);
  };

  /// True if samples of a pixel have different weights in the film.
  bool is_split() const { return is_split_; }
  void add_samples(FilmTile& colours, float weight) const;
  void render_tile(const TileGrid::Tile& tile, TilePrimaries& primaries,
                   const std::vector<PixelPlan>& plan, uint64_t seed, RenderCounters& counters);
  void find_visibilities(int tile);
  void find_units(const TilePrimaries& primaries, const std::vector<PixelPlan>& plan,
                  uint64_t seed);
  void reserve(int block, const std::vector<PixelPlan>& plan);
  uint16_t samples_of(const PixelPlan& plan) const { return std::max<uint16_t>(plan.primaries, 1); }
  float mean_visibility(const Patch& patch, const Visibility& visibility) const;
  void find_diagnostics(const TilePrimaries& primaries, const std::vector<PixelPlan>& plan);

  const PassView view_;
  const bool is_split_;
  TileTracer tracer_;
  VisibilityLearner learner_;
  Estimator estimator_;
  // Of the tile at work:
  std::vector<Patch> patches_;
  std::vector<Visibility> visibility_;
  std::vector<float> mean_visibility_;  ///< of the patches
  std::vector<Unit> units_;             ///< a unit per pixel
  // Of the block:
  std::vector<Rgb> sums_;  ///< of the samples if is_split(), else of the pixels
  std::vector<Pixel> pixels_;
  Samples samples_;  ///< if is_split()
  std::vector<Vec3> diagnostics_;
};

}  // namespace kinome
