#pragma once

#include <optional>
#include <vector>

#include "kinome/math.h"

namespace kinome::app {

/// Where a camera is, and what it looks at: in world units.
struct CameraView {
  glm::dvec3 position{0.};
  glm::dvec3 target{0.};
  glm::dvec3 up{0., 1., 0.};
  std::optional<double> fov;  ///< in degrees; nullopt: what it is

  /// As <lookat>, to the bit; nullopt where it looks along `up`, or at the place where it is.
  std::optional<Transform> to_world() const;
};

/// `start` turned about the axis `up` through its target, seen from above against the clock, by
/// `turn` of a full turn.
CameraView orbit(const CameraView& start, double turn);

/// A point of an ellipse on the sphere about the target on which `middle` lies (Åkerlund 2008,
/// 4.3.1: a parametric ellipse drawn on a sphere, with a constant focus point). The thesis doesn't
/// say which; here `middle` is its middle, and the half axes are angles as seen from the target, in
/// degrees: `half_axes.x` to the side, `half_axes.y` up. It goes once round with `turn` from 0 to
/// 1, and begins at the right. `middle.up` must not be parallel to where the camera looks.
CameraView on_ellipse(const CameraView& middle, const glm::dvec2& half_axes, double turn);

/// Values at some times, and smooth ones between them. Thread-safe.
class KeyedCurve {
 public:
  enum class Kind {
    /// Catmull-Rom: through a key it goes along the parabola through that and its two neighbours.
    /// It may swing beyond the keys.
    kCatmullRom,
    /// The same, held back so that it stays between neighbouring keys, each component by itself.
    kMonotone,
  };
  struct Key {
    double time;
    glm::dvec3 value;
  };
  /// Times rise from key to key; there is at least one.
  KeyedCurve(std::vector<Key> keys, Kind kind);
  /// Before the first key its value, after the last one the last one's.
  glm::dvec3 at(double time) const;
  const std::vector<Key>& keys() const { return keys_; }

 private:
  std::vector<Key> keys_;
  std::vector<glm::dvec3> tangents_;  ///< change by time, at each key
};

}  // namespace kinome::app
