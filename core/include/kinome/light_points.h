#pragma once

#include <cstdint>
#include <vector>

#include "kinome/color.h"
#include "kinome/math.h"

namespace kinome {

/// Light as weighted points (Åkerlund 2008, 3.3 and 3.4), the input of a LightTree.
struct LightPoints {
  enum class Kind {
    kDistant,  ///< `position` is the unit direction toward the light (3.4.1)
    kLocal,    ///< positions in the scene, with normals (3.4.2: VPLs)
  };
  Kind kind = Kind::kDistant;
  std::vector<Vec3> position;
  std::vector<Vec3> normal;  ///< unit; empty for distant light
  /// What one point adds to reflected radiance, divided by f cos(theta) (and by cos'/d² where
  /// local): radiance x solid angle for distant light, radiance x area for local light. Channels
  /// may be slightly negative, as photographs are.
  std::vector<Rgb> power;
  /// Extent of each point, positive: solid angle [sr], or area.
  std::vector<float> extent;

  size_t size() const { return position.size(); }
};

/// Light points chosen for one shading point: point i of the set counts weights[k] times.
struct PointSelection {
  std::vector<uint32_t> points;
  std::vector<float> weights;
  void clear() {
    points.clear();
    weights.clear();
  }
};

}  // namespace kinome
