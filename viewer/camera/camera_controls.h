#pragma once

#include <string>

#include "kinome/math.h"

namespace kinome::viewer {

/// A camera that is turned and moved by hand: around a target, or by itself. Angles in radians,
/// lengths in the scene's units. Not thread-safe.
class CameraControls {
 public:
  /// Takes over a sensor's to_world, whose z axis looks at a target at this distance. The axis of
  /// the world that is nearest to the camera's own is "up" from then on.
  void take(const Transform& to_world, float distance);
  /// take(), and what reset() goes back to.
  void take_home(const Transform& to_world, float distance);
  void reset() { *this = CameraControls(home_); }

  /// Goes around the target: to the right around the axis that is up, and upwards, never over a
  /// pole.
  void orbit(float right, float up);
  /// Looks elsewhere from the same place; the target goes with it.
  void look(float right, float up);
  /// Moves the camera together with its target, along its own axes.
  void move(float right, float up, float forward);
  /// Takes it to `factor` times the distance of its target; an orthographic camera sees that many
  /// times as much instead.
  void dolly(float factor, bool is_orthographic = false);
  /// Another target in the line of sight.
  void set_distance(float distance);

  Vec3 origin() const { return origin_; }
  Vec3 target() const { return origin_ + distance_ * forward_; }
  Vec3 forward() const { return forward_; }
  Vec3 up() const { return world_up_; }
  float distance() const { return distance_; }
  Transform to_world() const;
  const Transform& home() const { return home_.to_world; }  ///< what reset() goes back to
  /// As Mitsuba's XML has it: `<lookat origin="…" target="…" up="…"/>`. What else its to_world did
  /// (a mirror, a scale) isn't part of it.
  std::string lookat() const;

 private:
  struct Home {
    Transform to_world;
    float distance = 1;
  };
  CameraControls(const Home& home) : home_(home) { take(home.to_world, home.distance); }
  void turn(float right, float up);
  Vec3 right() const;
  /// World space of a camera that does nothing but look at its target.
  Mat4 frame() const;

 public:
  CameraControls() = default;

 private:
  Home home_;
  Vec3 origin_{0.f};
  Vec3 forward_{0, 0, 1};  ///< unit
  Vec3 up_{0, 1, 0};       ///< the camera's own, which tells how it is rolled
  Vec3 world_up_{0, 1, 0};
  float distance_ = 1;
  Mat4 rest_{1.f};  ///< what to_world does before: the identity, as a rule
};

}  // namespace kinome::viewer
