#pragma once

#include <optional>
#include <vector>

#include "kinome/math.h"

namespace kinome::app {

/// Position and orientation of a camera, in world space.
struct CameraView {
  glm::dvec3 position{0.};
  glm::dvec3 target{0.};
  glm::dvec3 up{0., 1., 0.};
  std::optional<double> fov;  ///< in degrees; nullopt leaves the sensor's value

  /// Returns the same matrix as <lookat>, bit by bit; nullopt if the view direction is parallel to
  /// `up` or zero.
  std::optional<Transform> to_world() const;
};

/// Rotates `start` about the axis `up` through its target, by `turn` full turns, anticlockwise as
/// seen from above.
CameraView orbit(const CameraView& start, double turn);

/// Moves `middle` along an ellipse on the sphere about its target (Åkerlund 2008, 4.3.1: a
/// parametric ellipse drawn on a sphere, with a constant focus point). The thesis doesn't specify
/// the ellipse. Here its centre is `middle`, and its half axes are angles as seen from the target,
/// in degrees: `half_axes.x` to the side, `half_axes.y` up. `turn` from 0 to 1 is one round that
/// begins on the right. `middle.up` must not be parallel to the view direction.
CameraView on_ellipse(const CameraView& middle, const glm::dvec2& half_axes, double turn);

/// Smooth curve through values at given times. Thread-safe.
class KeyedCurve {
 public:
  enum class Kind {
    /// Catmull-Rom spline: the tangent at a key is that of the parabola through the key and its two
    /// neighbours. It may overshoot the keys.
    kCatmullRom,
    /// The same with limited tangents, so that each component stays between neighbouring keys.
    kMonotone,
  };
  struct Key {
    double time;
    glm::dvec3 value;
  };
  /// `keys` has at least one key, in strictly increasing order of time.
  KeyedCurve(std::vector<Key> keys, Kind kind);
  /// Returns the value at `time`; it is constant before the first and after the last key.
  glm::dvec3 at(double time) const;
  const std::vector<Key>& keys() const { return keys_; }

 private:
  std::vector<Key> keys_;
  std::vector<glm::dvec3> tangents_;  ///< derivative by time at each key
};

}  // namespace kinome::app
