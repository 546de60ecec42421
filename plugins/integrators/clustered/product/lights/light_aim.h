#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kinome/emitter.h"
#include "kinome/interaction.h"

namespace kinome {

class Scene;
struct RenderCounters;

/// A sphere around positions whose light contributes to the image.
struct AimSphere {
  Vec3 centre{0.f};
  float radius = 0;
};

/// Maximum number of nested spheres.
inline constexpr int kMaxAimSpheres = 4;
/// Probability that an emission ray is aimed at one of the spheres. All spheres are equally likely.
/// Other rays are sampled by the emitter.
inline constexpr float kAimedShare = 0.5f;

/// A position and its relative contribution to the image.
struct WeightedPosition {
  Vec3 position{0.f};
  float weight = 0;
};

/// Returns nested spheres around the weighted median of the positions, with half, 80, 95 and 99.5 %
/// of their weight, in ascending order of size. Spheres of nearly the same size are merged. Returns
/// an empty vector if the total weight is 0.
std::vector<AimSphere> aim_spheres(std::vector<WeightedPosition> positions);

/// A surface point that rays from the camera reach.
struct EyePoint {
  SurfaceInteraction si;
  float weight = 1;  ///< fraction of its radiance that reaches the camera
  uint64_t seed = 0;
};

/// Returns the points that one or two rays, sampled by BSDFs, reach from the given surface points.
/// `first` is the index of the first of these, for random numbers.
std::vector<EyePoint> points_around(const Scene& scene, std::span<const SurfaceInteraction> seen,
                                    size_t first, uint64_t seed, RenderCounters& counters);

/// Selects one of `count` spheres, or none (-1), with u. Rescales u so that it is uniform in [0, 1)
/// again. Leaves u unchanged if `count` is 0.
int pick_aim(int count, float& u);

/// Density of directions from one position toward spheres: a mixture of cones and a given density.
class AimCones {
 public:
  AimCones() = default;

  /// Adds the sphere's cone if it raises the density by more than kMinGain. plain(axis, sine)
  /// returns the density of the emitter's own sampling in the cone, per solid angle.
  template <class Density>
  void add(const Vec3& from, const AimSphere& sphere, const Density& plain) {
    Cone cone;
    if (!make_cone(from, sphere, cone)) return;
    const float density = plain(cone.axis, cone.sine);
    if (density > 0 && cone.density > kMinGain * density) {
      from_ = from;
      cones_[static_cast<size_t>(count_++)] = cone;
    }
  }

  int count() const { return count_; }
  const Vec3& from() const { return from_; }
  /// Distance to the centre of a cone's sphere.
  float distance(int cone) const { return cones_[static_cast<size_t>(cone)].distance; }
  Vec3 sample(int cone, const Vec2& u) const;
  /// Density of d per solid angle. `plain` is the density of the emitter's own sampling. `drawn` is
  /// the cone from which d was sampled, so that rounding can't put d outside; -1 if none or
  /// unknown.
  float pdf(const Vec3& d, float plain, int drawn = -1) const;

  /// Minimum factor by which a cone must raise the density of the emitter's own sampling.
  static constexpr float kMinGain = 2;

 private:
  struct Cone {
    Vec3 axis{0, 0, 1};
    float sine = 0;     ///< of half the opening angle
    float height = 0;   ///< 1 - cosine of half the opening angle
    float density = 0;  ///< of directions in the cone, per solid angle
    float distance = 0;
  };
  static bool make_cone(const Vec3& from, const AimSphere& sphere, Cone& cone);

  Vec3 from_{0.f};
  std::array<Cone, kMaxAimSpheres> cones_;
  int count_ = 0;
};

/// Density of parallel light toward spheres: a mixture of disks perpendicular to its direction and
/// a given density.
class AimDisks {
 public:
  AimDisks() = default;
  /// `plain`: density of the emitter's own sampling, per area perpendicular to the direction.
  AimDisks(std::span<const AimSphere> spheres, float plain);

  int count() const { return count_; }
  /// Samples an origin such that a ray along d hits the sphere. It lies on the plane through
  /// `plane` perpendicular to d.
  Vec3 sample(int disk, const Vec2& u, const Vec3& d, const Vec3& plane) const;
  /// Density of the line along d through p, per area perpendicular to d. `drawn` as in
  /// AimCones::pdf().
  float pdf(const Vec3& p, const Vec3& d, int drawn = -1) const;
  /// Density of the emitter's own sampling.
  float plain() const { return plain_; }

 private:
  std::array<AimSphere, kMaxAimSpheres> spheres_;
  int count_ = 0;
  float plain_ = 0;
};

}  // namespace kinome
