#pragma once

#include <optional>
#include <vector>

#include "clustered/product/caustics.h"
#include "clustered/product/estimator.h"
#include "clustered/product/plan.h"
#include "clustered/product/product_sampling.h"

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

  double samples() const override { return rays_left_ / kRaysPerSample; }
  double render(double samples) override;
  double seconds_per_sample() const override;
  /// All that the settings ask for.
  void render_all();

 private:
  /// Side of the blocks of tiles that are one thread's turn.
  static constexpr int kTile = kTileSide;
  static constexpr int kBlock = 32;
  static constexpr int kTilesAcross = kBlock / kTile;

  /// What the plan needs of a pilot's primary.
  struct PilotPoint {
    Vec3 reflected{0.f};  ///< normal x mean diffuse reflectance
    float known = 0;      ///< light that it sees itself, or unshadowed glossy light
    float lamps = 0;      ///< PointPlan::lamps
    float lit = 0;        ///< of the other lamps, what arrives
    float glossy_deviation = 0;
    int16_t patch = -1;
  };
  /// What a thread works with; kept from block to block.
  struct Workspace;

  int tiles_x() const { return (crop_.width() + kTile - 1) / kTile; }
  int tiles_y() const { return (crop_.height() + kTile - 1) / kTile; }
  int blocks_x() const { return (crop_.width() + kBlock - 1) / kBlock; }
  int blocks_y() const { return (crop_.height() + kBlock - 1) / kBlock; }
  Rect block_at(int x, int y) const;
  Rect block_at(int index) const { return block_at(index % blocks_x(), index / blocks_x()); }
  /// Of arrays of all cells.
  size_t padded_cells() const;
  size_t pixel_index(int x, int y) const;
  Primaries::View view() const;

  /// Rows of blocks, [first, end).
  struct Rows {
    int first = 0;
    int end = 0;
  };
  Rows all_rows() const { return {0, blocks_y()}; }
  /// One of a block's tiles.
  struct Tile {
    int index;  ///< in tiles_
    int place;  ///< in the block
    Rect pixels;
  };
  /// fn(block, workspace) for each block, on many threads.
  template <class Function>
  void for_each_block(Rows rows, const CellLight& light, const char* stage, const Function& fn);
  /// fn(tile) for each tile of a block.
  template <class Function>
  void for_each_tile(int block, const Function& fn) const;
  /// Traces count_of(x, y) primaries of each pixel of a block, several tiles at a time, and calls
  /// fn(tile, its primaries) for each tile. `seconds` gets what tracing takes.
  template <class Counts, class Function>
  void trace_tiles(int block, uint64_t seed, double& seconds, Workspace& work,
                   const Counts& count_of, const Function& fn) const;

  CellLight make_light(uint64_t seed) const;
  std::vector<PixelPlan> plan_pass(double rays_per_pixel) const;
  void render_rays(double rays_per_pixel, double progress_begin);
  /// Pilot and plan of the whole picture, band by band.
  void learn_in_bands(const CellLight& light, uint32_t rays, double progress_end);
  int rows_of_band() const;
  Rows band(int index) const;
  /// Points of the pilot's primaries in a pixel, of the band at work or the one before.
  PilotPoint* points_of(int x, int y);
  void pilot(Rows rows, const CellLight& light, uint32_t rays);
  void probe_tile(const Tile& tile, TilePrimaries& primaries, uint32_t rays, uint64_t seed,
                  Workspace& work);
  void keep_records(int block, const Workspace& work);
  void learn(int tile, const Patch& patch, Workspace& work) const;
  void plan(Rows rows, const CellLight& light);
  void plan_tile(const Tile& tile, Workspace& work);
  void forecast_pixel(const TileMemory& memory, const float* controls, int x, int y);
  void find_trust(const TileMemory& memory, Patch& patch, const Visibility& visibility) const;
  void pass(const CellLight& light, const std::vector<PixelPlan>& plan, uint64_t seed,
            float weight);
  void render_tile(const Tile& tile, TilePrimaries& primaries, const std::vector<PixelPlan>& plan,
                   uint64_t seed, Workspace& work);
  void find_visibilities(int tile, Workspace& work);
  /// What the tiles around tell of a patch, in 8 bits, added to `out`.
  void learn_visibility(int tile, const Patch& patch, Workspace& work, Visibility& visibility,
                        std::vector<uint8_t>& out) const;
  bool remembers() const;
  void load_visibility(const uint8_t* learned, Visibility& out) const;
  void apply_ablations(Visibility& visibility) const;
  float mean_visibility(const Patch& patch, const Visibility& visibility) const;
  void find_diagnostics(const TilePrimaries& primaries, const std::vector<PixelPlan>& plan,
                        Workspace& work) const;
  void add_to_film(int block, const std::vector<PixelPlan>& plan, uint64_t seed, float weight,
                   Workspace& work);

  const Scene& scene_;
  const transport::SceneTable table_;
  const Sensor& sensor_;
  RenderContext& context_;
  const std::shared_ptr<const DistantCells> shared_cells_;
  const DistantCells& cells_;
  std::unique_ptr<const LocalLight> local_;  ///< nullptr: there is none
  std::optional<Caustics> caustics_;         ///< where there may be some
  CellNeighbours neighbours_;                ///< where there is a pilot
  const ProductSettings settings_;
  const Rect crop_;
  const FilterSampler filter_;
  const uint64_t seed_;
  uint32_t pilot_primaries_ = 0;  ///< 0: there was no pilot
  double pilot_seconds_ = 0;
  double rays_left_;  ///< of the settings' rays a pixel
  uint64_t pass_ = 0;
  double unit_ = 0;  ///< rays a pixel of the first pass: they have weight 1
  std::vector<TileMemory> tiles_;
  std::vector<PilotPoint> points_[2];  ///< of bands of even and odd number
  std::vector<PixelForecast> forecast_;  ///< while the pilot is at work
  std::optional<RayAllocation> allocation_;  ///< where there was one
};

}  // namespace kinome
