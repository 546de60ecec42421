#pragma once

#include <string>

#include "kinome/math.h"

namespace kinome::viewer {

/// A camera that the user turns and moves, around a target or freely. Angles are in radians,
/// lengths in the scene's units. Not thread-safe.
class CameraControls {
 public:
  /// Sets the camera to a sensor's to_world, whose z axis points at a target at this distance. The
  /// world axis nearest to the camera's up vector becomes the vertical axis.
  void take(const Transform& to_world, float distance);
  /// Calls take(), and makes this the pose to which reset() returns.
  void set_home(const Transform& to_world, float distance);
  void reset() { *this = CameraControls(home_); }

  /// Moves the camera around the target: to the right around the vertical axis, and up, but never
  /// over a pole.
  void orbit(float right, float up);
  /// Turns the camera in place. The target turns with it.
  void look(float right, float up);
  /// Moves the camera together with its target, along its own axes.
  void move(float right, float up, float forward);
  /// Multiplies the distance to the target by `factor`; for an orthographic camera, the size of the
  /// view instead.
  void dolly(float factor, bool is_orthographic = false);

  Vec3 origin() const { return origin_; }
  Vec3 target() const { return origin_ + distance_ * forward_; }
  Vec3 forward() const { return forward_; }
  Vec3 up() const { return world_up_; }
  float distance() const { return distance_; }
  Transform to_world() const;
  const Transform& home() const { return home_.to_world; }  ///< to which reset() returns
  /// Returns Mitsuba's XML: `<lookat origin="…" target="…" up="…"/>`. It doesn't contain other
  /// parts of to_world, such as a reflection or a scale.
  std::string lookat() const;

 private:
  struct Home {
    Transform to_world;
    float distance = 1;
  };
  CameraControls(const Home& home) : home_(home) { take(home.to_world, home.distance); }
  Vec3 right() const;
  /// Returns the camera-to-world transform without rest_.
  Mat4 frame() const;

 public:
  CameraControls() = default;

 private:
  Home home_;
  Vec3 origin_{0.f};
  Vec3 forward_{0, 0, 1};  ///< unit
  Vec3 up_{0, 1, 0};       ///< the camera's own, including its roll
  Vec3 world_up_{0, 1, 0};
  float distance_ = 1;
  Mat4 rest_{1.f};  ///< the part of to_world that is applied before frame(); usually the identity
};

}  // namespace kinome::viewer
