#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "kinome/scene.h"
#include "kinome/wide/vectors.h"
#include "transport/media/bodies/majorant_grid.h"
#include "transport/shadows/rays.h"

namespace kinome::transport {

/// Maximum number of surfaces that a ray passes straight through. The limit ends rays that rounding
/// errors keep at the same surface.
inline constexpr uint32_t kMaxLegs = 1024;

/// Moves the origin of a ray to point i, which it has hit, and sets its tmin so that it continues
/// behind the surface. Distances count from the surface, so that no part of a medium is left out.
/// Returns the distance of the point from the old origin.
inline float continue_behind(const SurfaceBlock& points, size_t i, Ray& ray) {
  const kinome::Vec3 p = points.p.at(i);
  const float distance = glm::dot(p - ray.o, ray.d);
  ray.tmin = distance_behind(ray, p, points.n.at(i), points.p_error[i]) - distance;
  ray.o += distance * ray.d;
  return distance;
}

/// True if an environment or a directional emitter is in the scene.
bool has_light_from_infinity(const Scene& scene);

/// Table of the media of a scene, numbered from 1, and of the shapes that separate them. Immutable:
/// created once per render, and shared by all threads.
class MediaTable {
 public:
  /// Number of empty space.
  static constexpr uint32_t kVacuum = 0;
  /// Medium on both sides of a shape that doesn't separate media: that of the ray.
  static constexpr uint32_t kUnchanged = ~0u;

  MediaTable(const Scene& scene, const Sensor& sensor);
  MediaTable(const MediaTable&) = delete;
  MediaTable& operator=(const MediaTable&) = delete;

  /// Number of media, including vacuum.
  size_t size() const { return media_.size(); }
  /// Returns a medium, or nullptr for vacuum.
  const Medium* medium(uint32_t number) const { return media_[number]; }
  /// Medium in which the sensor's rays start.
  uint32_t start() const { return start_; }
  /// True if the extinction of some medium differs between the channels.
  bool is_coloured() const { return is_coloured_; }
  /// True if some medium isn't uniform.
  bool has_grids() const { return has_grids_; }
  /// Bounds on the extinction of a medium; nullptr for vacuum and uniform media.
  const MajorantGrid* grid(uint32_t number) const { return grids_[number].get(); }
  /// Coefficients of each medium; 0 for those that aren't uniform, and for vacuum.
  const Columns3& extinction() const { return extinction_; }
  const Columns3& albedo() const { return albedo_; }
  /// True if all paths leave the medium: it is bounded, or light from infinity bounds the scene.
  bool ends(uint32_t number) const { return ends_[number]; }
  /// True if Walks continue paths from collisions in this medium: it is uniform and enclosed.
  bool is_walked(uint32_t number) const { return is_enclosed_[number] && !grids_[number]; }
  bool has_walks() const { return has_walks_; }
  /// Probability that a collision in such a medium takes an emitter sample. Only delta emitters are
  /// sampled, because the phase function can't find their light. They are visible from the inside
  /// only if the surface around the medium has a hole.
  float delta_share(uint32_t number) const {
    return has_deltas_ && media_[number]->samples_emitters() ? kDeltaShare : 0.f;
  }
  /// Weight of emitter samples at collisions in a medium, or 0 if emitters aren't sampled. If only
  /// delta emitters are sampled, the weight is negated.
  float emitter_weight(uint32_t number) const {
    if (!media_[number]->samples_emitters()) return 0;
    if (!is_enclosed_[number]) return 1;
    if (!has_deltas_) return 0;
    return is_walked(number) ? -1 / kDeltaShare : -1.f;
  }
  /// Returns the shape number of hits that represent collisions in a medium (see SceneTable).
  uint32_t collision_shape(uint32_t number) const {
    return static_cast<uint32_t>(interior_.size()) + number - 1;
  }
  /// Phase functions as BSDFs, without vacuum: media 1, 2 ...
  const std::vector<const Bsdf*>& phases() const { return phases_; }

  /// Media of a shape of Scene::shapes(), opposite to its geometric normal and on its side.
  uint32_t interior(uint32_t shape) const { return interior_[shape]; }
  uint32_t exterior(uint32_t shape) const { return exterior_[shape]; }
  /// Returns the medium of a ray that leaves a shape of geometric normal n toward d. `before` is
  /// that of the ray toward the shape.
  uint32_t behind(uint32_t shape, const kinome::Vec3& n, const kinome::Vec3& d,
                  uint32_t before) const {
    const uint32_t medium = glm::dot(n, d) > 0 ? exterior_[shape] : interior_[shape];
    return medium == kUnchanged ? before : medium;
  }

  /// Returns the distances at which media without a boundary end, for the rays from `lane` on,
  /// whose directions are unit vectors. Rays that are not in `hits` leave the scene. If some light
  /// comes from infinity, these media fill a sphere that contains all shapes and the sensor,
  /// because otherwise the light couldn't reach the scene. Without such light, they are unbounded.
  KINOME_WIDE wide::Float end_of_space(const Ray16& rays, size_t lane, wide::Mask hits) const {
    using namespace wide;
    if (all(hits)) return kInfinity;
    const auto three = [&](const float* x, const float* y, const float* z) {
      return wide::Vec3(Float::load(x + lane), Float::load(y + lane), Float::load(z + lane));
    };
    return end_of_space<wide::Vec3>(three(rays.ox, rays.oy, rays.oz),
                                    three(rays.dx, rays.dy, rays.dz));
  }
  float end_of_space(const Ray& ray) const { return end_of_space<kinome::Vec3>(ray.o, ray.d); }

 private:
  static constexpr float kDeltaShare = 1.f / 32;

  template <class V>
  KINOME_WIDE wide::NumberOf<V> end_of_space(const V& o, const V& d) const {
    using namespace wide::formulas;
    using F = wide::NumberOf<V>;
    const V to = V(centre_) - o;
    const F along = dot(to, d);
    const V beside = to - d * along;
    return max(along + safe_sqrt(radius_ * radius_ - dot(beside, beside)), F(0.f));
  }
  void add(const Medium& medium);
  void find_sphere(const Scene& scene, const Sensor& sensor);
  void find_enclosed(const Scene& scene, const Sensor& sensor);
  uint32_t number_of(const Medium* medium) const;

  std::vector<const Medium*> media_{nullptr};
  std::vector<std::unique_ptr<const MajorantGrid>> grids_;
  std::vector<std::unique_ptr<const Bsdf>> owned_phases_;
  std::vector<const Bsdf*> phases_;
  std::vector<float> coefficients_;  ///< memory of the columns
  Columns3 extinction_, albedo_;
  std::vector<uint32_t> interior_, exterior_;
  uint32_t start_ = kVacuum;
  bool is_coloured_ = false;
  bool has_grids_ = false;
  std::vector<bool> is_enclosed_, ends_;
  bool has_walks_ = false;
  bool has_deltas_ = false;  ///< true if the scene has emitters that rays can't hit
  kinome::Vec3 centre_{0.f};
  float radius_ = 0;
};

}  // namespace kinome::transport
