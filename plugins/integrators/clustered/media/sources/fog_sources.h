#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "clustered/cells/channel_mean.h"
#include "clustered/cells/light_cells.h"
#include "clustered/media/sources/sun_beams.h"
#include "clustered/media/sources/sun_grid.h"
#include "kinome/scene.h"

namespace kinome {

class SkyDirections;

/// Sources of the light that media scatter, numbered in this order: emitters at finite distances,
/// distant delta emitters (the strongest first), other distant emitters, cells of the environment.
/// Thread-safe after find_suns() and find_beams().
class FogSources {
 public:
  /// Number of cells of the environment. Importances of all cells are computed for each block.
  static constexpr uint32_t kCells = 256;
  /// Number of consecutive cells, neighbours in the sky, that share their learned visibility.
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
    uint32_t group;         ///< number of the group that shares its learned visibility
  };
  const std::vector<Distant>& distant() const { return distant_; }
  uint32_t groups() const { return groups_; }
  /// True if some sources are distant emitters other than the environment.
  bool have_suns() const { return first_cell_ > 0; }
  /// Grids of lit space of distant emitters; the first suns().size() sources of distant() have one.
  const std::vector<std::unique_ptr<const SunGrid>>& suns() const { return suns_; }
  /// Creates the grids. They are finer if the whole render has many `samples`.
  void find_suns(const transport::SceneTable& scene, const transport::MediaTable& media,
                 double samples, RenderContext& context);
  /// Learns the beams if there are grids. More rays are traced if the whole render has many
  /// `samples`. Only paths of three edges or more use them.
  void find_beams(const transport::SceneTable& scene, const transport::MediaTable& media,
                  const Sensor& sensor, double samples, RenderContext& context);
  /// Rays of light of the strongest sun, which is source beam_source(); nullptr if SunPoints can't
  /// follow them, or if the render is too short to learn them.
  const SunBeams* beams() const { return beams_.get(); }
  uint32_t beam_source() const { return static_cast<uint32_t>(near_.size()); }
  /// True if some sources are surfaces.
  bool have_surfaces() const { return have_surfaces_; }

  /// Light of a source at a point. The density of the direction doesn't include the probability of
  /// choosing the source; it is 0 if there is no light.
  struct Light {
    Vec3 d{0, 0, 1};
    float distance = kInfinity;
    Rgb weight{0.f};  ///< radiance / density
    /// Density of the emitter's own samples, per solid angle; infinite if no ray hits the emitter.
    float emitter_pdf = kInfinity;
  };
  /// Samples the light of a source at the point p. `u` chooses one of `directions` if the source is
  /// a cell.
  Light sample(uint32_t source, const Vec3& p, const Vec2& u,
               const SkyDirections& directions) const;

 private:
  friend class SkyDirections;
  void add_environment(const Emitter& environment, const Scheduler& scheduler);
  bool add_near(const Scene& scene, const Emitter& emitter);

  std::vector<Near> near_;
  std::vector<std::unique_ptr<const SunGrid>> suns_;
  std::unique_ptr<const SunBeams> beams_;
  std::vector<Distant> distant_;
  uint32_t groups_ = 0;
  uint32_t first_cell_ = 0;  ///< index into distant_
  bool have_surfaces_ = false;
  std::unique_ptr<const DistantCells> cells_;  ///< nullptr: none
};

/// Random directions in the cells of the environment. Each block of samples draws its own, so that
/// the image converges. Not thread-safe: use one per thread.
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
  std::vector<uint32_t> first_;        ///< first direction of each cell, then their number
};

}  // namespace kinome
