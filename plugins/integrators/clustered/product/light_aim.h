#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "kinome/emitter.h"
#include "kinome/interaction.h"

namespace kinome {

class RenderContext;
class Scene;

/// A sphere around positions that the camera sees the effect of.
struct AimSphere {
  Vec3 centre{0.f};
  float radius = 0;
};

/// Maximum number of nested spheres.
inline constexpr int kMaxAimSpheres = 4;
/// Probability that an emission ray is aimed at one of the spheres, each as likely as the others.
/// Other rays are sampled as the emitter does.
inline constexpr float kAimedShare = 0.5f;

/// A position, and its share of what the camera sees.
struct WeightedPosition {
  Vec3 position{0.f};
  float weight = 0;
};

/// Nested spheres around the weighted median of the positions, with half, 80, 95 and 99.5 % of their
/// weight; the largest comes last. Spheres of nearly the same size count as one. Empty
/// if there is no weight.
std::vector<AimSphere> aim_spheres(std::vector<WeightedPosition> positions);

/// A point that rays from the camera reach.
struct EyePoint {
  SurfaceInteraction si;
  float weight = 1;  ///< share of its radiance that the camera sees
  uint64_t seed = 0;
};

/// Points that one or two rays, sampled by BSDFs, reach from the given surface points.
std::vector<EyePoint> points_around(const Scene& scene, std::span<const SurfaceInteraction> seen,
                                    uint64_t seed, RenderContext& context);

/// Chooses among `count` spheres, or none (-1), by u, which is rescaled to be uniform in [0, 1)
/// again. Leaves u unchanged if `count` is 0.
int pick_aim(int count, float& u);

/// Directions from one position toward spheres: a mixture of cones and a given density.
class AimCones {
 public:
  AimCones() = default;

  /// Adds the cone of the sphere if it is small enough to pay. plain(d): density per solid angle of
  /// the emitter's own sampling.
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
  /// Distance of the centre of a cone's sphere.
  float distance(int cone) const { return cones_[static_cast<size_t>(cone)].distance; }
  Vec3 sample(int cone, const Vec2& u) const;
  /// Density of d per solid angle. plain: density by the emitter's own sampling. drawn: cone that d
  /// was sampled from, so that rounding can't put d outside; -1 if none or unknown.
  float pdf(const Vec3& d, float plain, int drawn = -1) const;

  /// Spheres that aim gains less at are left to the emitter's own sampling.
  static constexpr float kMinGain = 2;

 private:
  struct Cone {
    Vec3 axis{0, 0, 1};
    float sine = 0;     ///< of half of the opening angle
    float height = 0;   ///< 1 - cosine of that angle
    float density = 0;  ///< of directions in the cone, per solid angle
    float distance = 0;
  };
  static bool make_cone(const Vec3& from, const AimSphere& sphere, Cone& cone);

  Vec3 from_{0.f};
  std::array<Cone, kMaxAimSpheres> cones_;
  int count_ = 0;
};

/// Parallel light toward spheres: a mixture of disks across its direction and a given density.
class AimDisks {
 public:
  AimDisks() = default;
  /// plain: density of the emitter's own sampling, per area across the direction.
  AimDisks(std::span<const AimSphere> spheres, float plain);

  int count() const { return count_; }
  /// A point on the plane across d through `plane`, from where a ray along d meets the sphere.
  Vec3 sample(int disk, const Vec2& u, const Vec3& d, const Vec3& plane) const;
  /// Density of lines along d through p, per area across d; `drawn` as in AimCones::pdf().
  float pdf(const Vec3& p, const Vec3& d, int drawn = -1) const;
  /// Density of the emitter's own sampling.
  float plain() const { return plain_; }

 private:
  std::array<AimSphere, kMaxAimSpheres> spheres_;
  int count_ = 0;
  float plain_ = 0;
};

}  // namespace kinome
