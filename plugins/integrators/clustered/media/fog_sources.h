#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "clustered/cells/channel_mean.h"
#include "clustered/cells/light_cells.h"
#include "clustered/media/sun_grid.h"
#include "kinome/scene.h"

namespace kinome {

class SkyDirections;

/// Sources of the light that media scatter: emitters at finite distances, then distant emitters,
/// then the cells of the environment. Numbered in this order. Immutable; thread-safe.
class FogSources {
 public:
  /// Number of cells of the environment. Importances of all cells are computed for each block.
  static constexpr uint32_t kCells = 256;
  /// Consecutive cells that share what is learned. They are neighbours in the sky.
  static constexpr uint32_t kCellsPerGroup = 16;

  FogSources(const Scene& scene, const Scheduler& scheduler);

  /// Emitter at a finite distance. Importances treat it as a point.
  struct Near {
    const Emitter* emitter;
    Vec3 p{0.f};
    float radius = 0;     ///< approximate; 0 for emitters without area
    float intensity = 0;  ///< mean over directions and channels [power per solid angle]
  };
  const std::vector<Near>& near() const { return near_; }
  /// Emitter or cell whose light comes from infinity.
  struct Distant {
    const Emitter* emitter;
    float flux;       ///< importance: integral of the radiance over directions, mean of channels
    Vec3 d{0, 0, 1};  ///< unit mean direction toward the light
    float mean_cosine = 1;  ///< length of the mean of the directions
    uint32_t group;         ///< of those that share what is learned
  };
  const std::vector<Distant>& distant() const { return distant_; }
  uint32_t groups() const { return groups_; }
  /// True if some sources are distant emitters other than the environment.
  bool have_suns() const { return has_suns_; }
  /// Where distant emitters shine: of the first sources of distant(), as many as have a grid.
  const std::vector<std::unique_ptr<const SunGrid>>& suns() const { return suns_; }
  /// Makes the grids. `samples`: of the render; grids are finer if it has many.
  void find_suns(const transport::SceneTable& scene, const transport::MediaTable& media,
                 double samples, RenderContext& context);
  /// True if some sources are surfaces.
  bool have_surfaces() const { return have_surfaces_; }

  /// Light of a source at the point p. The density of the direction is relative to the source: it
  /// doesn't include the probability of choosing it. 0: none.
  struct Light {
    Vec3 d{0, 0, 1};
    float distance = kInfinity;
    Rgb weight{0.f};  ///< radiance / density
    /// Density of the emitter's own samples, per solid angle; infinite if no ray hits the emitter.
    float emitter_pdf = kInfinity;
  };
  /// `u` chooses one of `directions` if the source is a cell.
  Light sample(uint32_t source, const Vec3& p, const Vec2& u,
               const SkyDirections& directions) const;

 private:
  friend class SkyDirections;
  void add_environment(const Emitter& environment, const Scheduler& scheduler);
  bool add_near(const Scene& scene, const Emitter& emitter);

  std::vector<Near> near_;
  std::vector<std::unique_ptr<const SunGrid>> suns_;
  std::vector<Distant> distant_;
  uint32_t groups_ = 0;
  uint32_t first_cell_ = 0;  ///< index into distant_
  bool have_surfaces_ = false;
  bool has_suns_ = false;
  std::unique_ptr<const DistantCells> cells_;  ///< nullptr: none
};

/// Random directions in the cells of the environment. Each block of samples draws its own, so that
/// the image converges. One per thread.
class SkyDirections {
 public:
  /// Direction in a cell, as of FogSources::Light.
  struct Direction {
    Vec3 d;
    float emitter_pdf;
    Rgb weight;
  };
  /// Replaces all directions. The same seed gives the same directions.
  void draw(const FogSources& sources, uint64_t seed);
  /// Returns the direction of a cell that u in [0,1) chooses.
  const Direction& choose(uint32_t cell, float u) const {
    const auto count = static_cast<float>(first_[cell + 1] - first_[cell]);
    return directions_[first_[cell] + static_cast<uint32_t>(u * count)];
  }

 private:
  std::vector<Direction> directions_;  ///< sorted by cell
  std::vector<uint32_t> first_;        ///< of each cell; one more entry than cells
};

}  // namespace kinome
