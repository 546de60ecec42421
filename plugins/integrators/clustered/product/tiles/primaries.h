#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "clustered/kernels/lobe_kernels.h"
#include "clustered/product/tiles/path_numbers.h"
#include "kinome/block_points.h"
#include "transport/paths/coverage.h"

namespace kinome {

/// Side of the tiles that learn together, in pixels.
inline constexpr int kTileSide = 4;

class TilePrimaries;

/// True if a camera ray continues from a surface as a path of `path`. There are three cases:
/// - A lobe other than a delta lobe transmits light.
/// - The viewer is behind a surface that transmits light. Light is known only on the side of the
///   normal (of Bsdf::reflection_frame).
/// - With `hides_environment`, the surface may let the ray pass straight. Only paths hide the
///   environment behind it.
inline bool goes_on_as_path(const Bsdf& bsdf, const Vec3& normal, const Vec3& viewer,
                            bool hides_environment) {
  return bsdf.has_rough_transmission() || (bsdf.transmits() && !(glm::dot(normal, viewer) > 0)) ||
         (hides_environment && bsdf.has_null_lobe());
}
/// True for mirrors and smooth glass.
inline bool has_deltas_alone(const Bsdf& bsdf) {
  return any(bsdf.lobes() & Lobe::kDelta) && !any(bsdf.lobes() & (Lobe::kDiffuse | Lobe::kGlossy));
}

/// Camera rays through several tiles of pixels, and the surface points that they hit. Each pixel
/// has its own number of rays. Points are in the order of Surfaces: by material and shape. Most of
/// their data are columns for kernels. Reuses its memory; one object per thread. Not thread-safe.
class Primaries {
 public:
  struct View {
    const transport::SceneTable& scene;
    const Sensor& sensor;
    PathSettings paths;
    /// Rays that hit a surface with has_deltas_alone() continue as paths of `path`, too.
    bool follows_mirrors = false;
  };

  explicit Primaries(const View& view);

  /// Removes all tiles.
  void clear();
  /// Adds a tile. Its pixel i, row by row, gets counts[i] rays. Returns false and adds nothing if
  /// there would be too many rays to trace at once. Always adds the first tile.
  bool add(const Rect& pixels, std::span<const uint16_t> counts);
  /// Traces the rays of all tiles. The rays of a pixel are the first ones of a sequence that
  /// depends only on the pixel and the seed. They are spread evenly over the pixel, in the order of
  /// a Hilbert curve.
  void trace(uint64_t seed, RenderCounters& counters);

  size_t tile_count() const { return tiles_.size(); }
  /// Tiles are in the order in which they were added; valid until clear().
  TilePrimaries tile(size_t index);

 private:
  friend class TilePrimaries;
  struct Tile {
    Rect pixels;
    size_t first_pixel;
    size_t first_ray;
    size_t rays;
    float origin_width, direction_width;  ///< see TilePrimaries::width_at
  };

  const SurfaceBlock& points() const { return camera_->surfaces().points(); }
  void make_room(size_t rays);
  void place(uint64_t seed);
  void place_pixel(int x, int y, size_t begin, size_t end, uint64_t seed);
  void find_width(Tile& tile) const;
  void describe();

  const View view_;
  std::optional<transport::Arena> arena_;  ///< columns of rays
  std::unique_ptr<transport::Camera> camera_;
  bool hides_environment_;
  PathNumbers numbers_;                          ///< random numbers of coverage_
  std::optional<transport::Coverage> coverage_;  ///< nullopt if the film has no alpha
  uint32_t* key_[2] = {};                        ///< halves of the seed of each ray's numbers
  Columns2 position_, aperture_;
  Columns3 emitted_;
  float* alpha_ = nullptr;
  std::vector<Tile> tiles_;
  std::vector<uint32_t> first_;  ///< first ray of each pixel, and the end
  int32_t* point_ = nullptr;     ///< point of each ray; -1 if it hit nothing
  std::vector<int32_t> patch_;   ///< patch of each point
  std::vector<uint32_t> kind_;   ///< index in kinds_ of each point
  BsdfFormKinds kinds_;
  simd::PointFrames frames_;
  simd::MicrofacetPoints microfacets_;
  simd::TurnedPoints turned_;
  Column<float> diffuse_[3];
};

/// The rays of one tile, [0, size()), and the points that they hit.
class TilePrimaries {
 public:
  const Rect& pixels() const { return tile_->pixels; }
  size_t size() const { return tile_->rays; }
  /// Rays [first(i), first(i + 1)) are those of pixel i.
  uint32_t first(size_t pixel) const {
    return all_->first_[tile_->first_pixel + pixel] - static_cast<uint32_t>(tile_->first_ray);
  }
  /// Position in pixels of the full film.
  Vec2 film_position(size_t ray) const { return all_->position_.at(tile_->first_ray + ray); }
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
  /// Emitted light that the ray sees directly.
  Rgb emitted(size_t ray) const { return all_->emitted_.at(tile_->first_ray + ray); }
  /// Emitter of this light; nullptr if the ray hit a surface that doesn't emit, or nothing in a
  /// scene without an environment.
  const Emitter* emitter(size_t ray) const {
    return hit(ray) ? shape(ray).emitter() : all_->view_.scene.scene().environment();
  }
  float distance(size_t ray) const {
    const size_t i = tile_->first_ray + ray;
    return all_->camera_->rays()[i / kBlockLanes].ray.tmax[i % kBlockLanes];
  }
  /// Part of the ray from just before the point that it hit to just behind it.
  Ray last_part(size_t ray) const;
  /// Index of the ray's point among all points; -1 if the ray hit nothing.
  int32_t point(size_t ray) const { return all_->point_[tile_->first_ray + ray]; }

  /// The following functions return data of the point that a ray hit.
  const Shape& shape(size_t ray) const { return *points().shape[point(ray)]; }
  SurfaceInteraction interaction(size_t ray) const {
    return interaction_of(points(), static_cast<size_t>(point(ray)));
  }
  Vec3 position(size_t ray) const { return points().p.at(static_cast<size_t>(point(ray))); }
  /// Only p, n and p_error, which define the origin of rays from there.
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
  /// Index of the point's patch in the tile; negative if the point reflects no light of cells.
  int32_t patch(size_t ray) const {
    const int32_t i = point(ray);
    return i < 0 ? -1 : all_->patch_[i];
  }
  void set_patch(size_t ray, int32_t patch) { all_->patch_[point(ray)] = patch; }
  /// Bsdf::reflection_frame, and the unit direction toward the viewer, in world space.
  Vec3 normal(size_t ray) const { return at(all_->frames_.normal, ray); }
  Vec3 tangent(size_t ray) const { return at(all_->frames_.tangent, ray); }
  Vec3 viewer(size_t ray) const { return at(all_->frames_.viewer, ray); }
  /// BsdfForm::diffuse, or LobeReflectance::diffuse if there is no form. 0 if there is no diffuse
  /// lobe.
  Rgb diffuse(size_t ray) const { return at(all_->diffuse_, ray); }
  /// See BsdfFormBlock.
  Rgb specular(size_t ray) const { return at(all_->microfacets_.specular, ray); }
  /// Form that all points of this kind share, or nullptr. Lacks the values that differ from point
  /// to point.
  const BsdfForm* form_kind(size_t ray) const {
    const uint32_t kind = all_->kind_[point(ray)];
    return kind == BsdfFormKinds::kNone ? nullptr : &all_->kinds_[kind];
  }
  /// The complete form. Only for points that have one.
  BsdfForm form(size_t ray) const;

  /// The following functions return data of all points.
  const SurfaceBlock& points() const { return all_->points(); }
  const simd::PointFrames& frames() const { return all_->frames_; }
  const Column<float> (&diffuse_columns() const)[3] { return all_->diffuse_; }
  const simd::MicrofacetPoints& microfacets() const { return all_->microfacets_; }
  const simd::TurnedPoints& turned() const { return all_->turned_; }

  /// Side length of the tile at distance t, in world units.
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
