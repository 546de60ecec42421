#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kinome/color.h"
#include "kinome/math.h"

namespace kinome {

/// Directional emission of local light points that are not Lambertian. Thread-safe.
class PointEmission {
 public:
  virtual ~PointEmission() = default;
  /// Intensity of point `id` along the unit direction d, including the cosine at the emitter:
  /// radiance x area x cos' [W/sr]. Called only if dot(normal, d) > 0.
  virtual Rgb intensity(uint32_t id, const Vec3& d) const = 0;
  /// Origin of light from point `id` along d: moved off the surface to the side of d. If shading
  /// normals differ from geometric normals, that may not be the side of LightPoints::position.
  virtual Vec3 origin(uint32_t id, const Vec3& d) const = 0;
};

/// Light represented by weighted points (Åkerlund 2008, 3.3 and 3.4).
struct LightPoints {
  enum class Kind {
    kDistant,  ///< `position` is the unit direction toward the light (3.4.1)
    kLocal,    ///< positions and normals in the scene: virtual point lights (3.4.2)
  };
  Kind kind = Kind::kDistant;
  std::vector<Vec3> position;
  /// Unit normals; empty for distant light. A local point emits only where dot(normal, d) > 0.
  std::vector<Vec3> normal;
  /// Contribution of each point to reflected radiance, divided by f cos(theta), and for local
  /// points by cos'/d²: radiance x solid angle of distant light, radiance x area of local light.
  /// Channels may be slightly negative, as they are in some photographs.
  std::vector<Rgb> power;
  /// Extent of each point, positive: solid angle [sr] of distant light, area of local light.
  std::vector<float> extent;
  /// Local light only: points i with emission_id[i] != kLambertian emit as `emission` defines;
  /// their power is an average, used only for importance. Empty: all points are Lambertian.
  static constexpr uint32_t kLambertian = ~0u;
  std::vector<uint32_t> emission_id;
  std::shared_ptr<const PointEmission> emission;

  size_t size() const { return position.size(); }
  bool is_lambertian(size_t i) const {
    return emission_id.empty() || emission_id[i] == kLambertian;
  }
  /// Origin of light from local point i along d.
  Vec3 origin(size_t i, const Vec3& d) const {
    return is_lambertian(i) ? position[i] : emission->origin(emission_id[i], d);
  }
  /// Appends points of the same kind, whose ids refer to this object's `emission`.
  void append(const LightPoints& other) {
    const auto add = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    add(position, other.position);
    add(normal, other.normal);
    add(power, other.power);
    add(extent, other.extent);
    add(emission_id, other.emission_id);
  }
};

}  // namespace kinome
