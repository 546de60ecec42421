#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kinome/color.h"
#include "kinome/math.h"

namespace kinome {

/// How local light points shine that are not Lambertian. Thread-safe.
class PointEmission {
 public:
  virtual ~PointEmission() = default;
  /// Intensity of the point `id` along the unit direction d, the cosine at the light included:
  /// radiance x area x cos' [W/sr]. Asked for only where dot(normal, d) > 0.
  virtual Rgb intensity(uint32_t id, const Vec3& d) const = 0;
  /// Where light of the point `id` along d starts: off the surface, on the side of d. That may not
  /// be the side of LightPoints::position where shading normals aren't the surface's own.
  virtual Vec3 origin(uint32_t id, const Vec3& d) const = 0;
};

/// Light as weighted points (Åkerlund 2008, 3.3 and 3.4).
struct LightPoints {
  enum class Kind {
    kDistant,  ///< `position` is the unit direction toward the light (3.4.1)
    kLocal,    ///< positions in the scene, with normals (3.4.2: VPLs)
  };
  Kind kind = Kind::kDistant;
  std::vector<Vec3> position;
  /// Unit; empty for distant light. A local point shines only where dot(normal, d) > 0.
  std::vector<Vec3> normal;
  /// What one point adds to reflected radiance, divided by f cos(theta) (and by cos'/d² where
  /// local): radiance x solid angle for distant light, radiance x area for local light. Channels
  /// may be slightly negative, as photographs are.
  std::vector<Rgb> power;
  /// Extent of each point, positive: solid angle [sr], or area.
  std::vector<float> extent;
  /// Local light only: points i with emission_id[i] != kLambertian shine as `emission` says; their
  /// power is then an average, for importance alone. Empty: all are Lambertian.
  static constexpr uint32_t kLambertian = ~0u;
  std::vector<uint32_t> emission_id;
  std::shared_ptr<const PointEmission> emission;

  size_t size() const { return position.size(); }
  bool is_lambertian(size_t i) const {
    return emission_id.empty() || emission_id[i] == kLambertian;
  }
  /// Where light of local point i along d starts.
  Vec3 origin(size_t i, const Vec3& d) const {
    return is_lambertian(i) ? position[i] : emission->origin(emission_id[i], d);
  }
  /// Adds points of the same kind, whose ids are of this `emission`.
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
