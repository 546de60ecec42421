#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "clustered/kernels/lobe_kernels.h"
#include "clustered/product/path_numbers.h"
#include "kinome/block_points.h"
#include "transport/coverage.h"

namespace kinome {

/// Side of the tiles that learn together, in pixels.
inline constexpr int kTileSide = 4;

class TilePrimaries;

/// True if a camera ray goes on from a surface as one of `path` does: if other lobes than deltas
/// let light through, or the viewer is behind what does, because light is known on the side of the
/// normal (of Bsdf::reflection_frame) alone. With `hides_environment`, also if the surface may let
/// the ray straight through, because only paths hide the environment there.
inline bool goes_on_as_path(const Bsdf& bsdf, const Vec3& normal, const Vec3& viewer,
                            bool hides_environment) {
  return bsdf.scatters_through() || (bsdf.transmits() && !(glm::dot(normal, viewer) > 0)) ||
         (hides_environment && bsdf.passes_straight());
}
/// Mirrors, and smooth glass.
inline bool has_deltas_alone(const Bsdf& bsdf) {
  return any(bsdf.lobes() & Lobe::kDelta) && !any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy));
}

/// Camera rays through tiles of pixels, several tiles at a time, each pixel with a number of rays
/// of its own, and the points of surfaces that they meet: what product sampling shades. Points are
/// in the order of Surfaces, by material and shape; most of them by columns that kernels read.
/// Keeps its memory: one per thread. Not thread-safe.
class Primaries {
 public:
  struct View {
    const transport::SceneTable& scene;
    const Sensor& sensor;
    PathSettings paths;
    /// Rays that meet what has_deltas_alone() go on as those of `path` do, too.
    bool follows_mirrors = false;
  };

  explicit Primaries(const View& view);
  ~Primaries();

  /// Begins anew: no tiles.
  void clear();
  /// Adds a tile, whose pixel i, row by row, gets counts[i] rays; false if it is for the next turn,
  /// since so many rays are enough for one. The first tile is always taken.
  bool add(const Rect& pixels, std::span<const uint16_t> counts);
  /// Traces the rays of all tiles. Each pixel's are the first so many of one sequence for each
  /// seed, evenly spread over the pixel in the order of a Hilbert curve, and independent of the
  /// other tiles.
  void trace(uint64_t seed, RenderCounters& counters);

  size_t tile_count() const { return tiles_.size(); }
  /// In the order in which they were added; valid until clear().
  TilePrimaries tile(size_t index);

  /// All that follows is by points.
  const SurfaceBlock& points() const { return camera_->surfaces().points(); }
  const simd::PointFrames& frames() const { return frames_; }
  const simd::MicrofacetPoints& microfacets() const { return microfacets_; }
  const simd::TurnedPoints& turned() const { return turned_; }

 private:
  friend class TilePrimaries;
  struct Tile {
    Rect pixels;
    size_t first_pixel;
    size_t first_ray;
    size_t rays;
    float origin_width, direction_width;  ///< see TilePrimaries::width_at
  };

  void make_room(size_t rays);
  void place(uint64_t seed);
  void place_pixel(int x, int y, size_t begin, size_t end, uint64_t seed);
  void find_width(Tile& tile) const;
  void describe();
  void find_viewers();

  const View view_;
  size_t room_ = 0;  ///< rays
  std::unique_ptr<transport::Camera> camera_;
  bool hides_environment_;
  PathNumbers numbers_;                          ///< of coverage_
  std::optional<transport::Coverage> coverage_;  ///< nullopt: the film has no alpha
  Column<uint32_t> key_[2];                      ///< of each ray's numbers: halves of a seed
  Column<float> position_[2], aperture_[2], emitted_[3], alpha_;
  std::vector<Tile> tiles_;
  std::vector<uint32_t> first_;  ///< ray of each pixel, and the end
  std::vector<int32_t> point_;   ///< of each ray; -1: none
  std::vector<int32_t> patch_;   ///< of each point
  std::vector<uint32_t> kind_;   ///< of each point, in kinds_
  BsdfFormKinds kinds_;
  simd::PointFrames frames_;
  simd::MicrofacetPoints microfacets_;
  simd::TurnedPoints turned_;
  Column<float> diffuse_[3];
};

/// One tile's rays, [0, size()), and what they met.
class TilePrimaries {
 public:
  const Rect& pixels() const { return tile_->pixels; }
  size_t size() const { return tile_->rays; }
  /// Rays [first(i), first(i + 1)) are those of pixel i.
  uint32_t first(size_t pixel) const {
    return all_->first_[tile_->first_pixel + pixel] - static_cast<uint32_t>(tile_->first_ray);
  }
  /// In pixels of the full film.
  Vec2 film_position(size_t ray) const {
    const size_t i = tile_->first_ray + ray;
    return {all_->position_[0][i], all_->position_[1][i]};
  }
  bool hit(size_t ray) const { return point(ray) >= 0; }
  /// See transport::Coverage; 0 if the film has no alpha.
  float alpha(size_t ray) const { return all_->alpha_[tile_->first_ray + ray]; }
  /// See goes_on_as_path, and View::follows_mirrors.
  bool goes_on(size_t ray) const {
    if (!hit(ray)) return false;
    const Bsdf& bsdf = shape(ray).bsdf();
    return goes_on_as_path(bsdf, normal(ray), viewer(ray), all_->hides_environment_) ||
           (all_->view_.follows_mirrors && has_deltas_alone(bsdf));
  }
  /// Light that the ray sees itself.
  Rgb emitted(size_t ray) const {
    const size_t i = tile_->first_ray + ray;
    return {all_->emitted_[0][i], all_->emitted_[1][i], all_->emitted_[2][i]};
  }
  float distance(size_t ray) const {
    const size_t i = tile_->first_ray + ray;
    return all_->camera_->rays()[i / kBlockLanes].ray.tmax[i % kBlockLanes];
  }
  /// From just before the surface that the ray met, along it.
  Ray last_part(size_t ray) const;
  /// Of the ray, among all points; -1: it left the scene.
  int32_t point(size_t ray) const { return all_->point_[tile_->first_ray + ray]; }

  /// What follows is of the point that a ray met.
  const Shape& shape(size_t ray) const { return *points().shape[point(ray)]; }
  SurfaceInteraction interaction(size_t ray) const {
    return interaction_of(points(), static_cast<size_t>(point(ray)));
  }
  Vec3 position(size_t ray) const { return points().p.at(static_cast<size_t>(point(ray))); }
  /// p, n and p_error alone, which is what rays from there are made of.
  SurfaceInteraction place(size_t ray) const {
    const auto i = static_cast<size_t>(point(ray));
    SurfaceInteraction si;
    si.p = points().p.at(i);
    si.n = points().n.at(i);
    si.p_error = points().p_error[i];
    return si;
  }
  /// SurfaceInteraction::frame
  Frame frame(size_t ray) const {
    const auto i = static_cast<size_t>(point(ray));
    return {points().s.at(i), points().t.at(i), points().sn.at(i)};
  }
  void prefetch(size_t ray) const {
    const int32_t i = point(ray);
    for (const Columns3& c : {points().p, points().n}) {
      __builtin_prefetch(c.x + i), __builtin_prefetch(c.y + i), __builtin_prefetch(c.z + i);
    }
    __builtin_prefetch(points().p_error + i);
  }
  /// What reflects light from the cells belongs to a patch of its tile; < 0: nothing does.
  int32_t patch(size_t ray) const {
    const int32_t i = point(ray);
    return i < 0 ? -1 : all_->patch_[i];
  }
  void set_patch(size_t ray, int32_t patch) { all_->patch_[point(ray)] = patch; }
  /// Bsdf::reflection_frame, and the unit direction toward the viewer; world space.
  Vec3 normal(size_t ray) const { return at(all_->frames_.normal, ray); }
  Vec3 tangent(size_t ray) const { return at(all_->frames_.tangent, ray); }
  Vec3 viewer(size_t ray) const { return at(all_->frames_.viewer, ray); }
  /// BsdfForm::diffuse, or LobeReflectance::diffuse where there is no form; 0: no such lobe.
  Rgb diffuse(size_t ray) const { return at(all_->diffuse_, ray); }
  /// As BsdfFormBlock has it.
  Rgb specular(size_t ray) const { return at(all_->microfacets_.specular, ray); }
  /// nullptr: there is none. Of its kind; what differs from point to point isn't in it.
  const BsdfForm* form_kind(size_t ray) const {
    const uint32_t kind = all_->kind_[point(ray)];
    return kind == BsdfFormKinds::kNone ? nullptr : &all_->kinds_[kind];
  }
  /// All of it; where there is one.
  BsdfForm form(size_t ray) const;

  /// By points.
  const SurfaceBlock& points() const { return all_->points(); }
  const simd::PointFrames& frames() const { return all_->frames_; }
  const Column<float> (&diffuse_columns() const)[3] { return all_->diffuse_; }
  const simd::MicrofacetPoints& microfacets() const { return all_->microfacets_; }
  const simd::TurnedPoints& turned() const { return all_->turned_; }

  /// Length of a tile's side at a distance of t, world units.
  float width_at(float t) const { return tile_->origin_width + t * tile_->direction_width; }

 private:
  friend class Primaries;
  TilePrimaries(Primaries& all, const Primaries::Tile& tile) : all_(&all), tile_(&tile) {}
  Vec3 at(const Column<float> (&columns)[3], size_t ray) const {
    const auto i = static_cast<size_t>(point(ray));
    return {columns[0][i], columns[1][i], columns[2][i]};
  }
  Primaries* all_;
  const Primaries::Tile* tile_;
};

inline TilePrimaries Primaries::tile(size_t index) {
  return {*this, tiles_[index]};
}

}  // namespace kinome
