#include "camera/camera_controls.h"

#include <cmath>
#include <cstdio>
#include <glm/gtc/matrix_transform.hpp>

#include "kinome/look_at.h"

namespace kinome::viewer {
namespace {

/// Minimum angle to a pole [rad]: at the pole itself, left and right are undefined.
constexpr float kMinPolarAngle = 0.02f;

Vec3 turned(const Vec3& v, float angle, const Vec3& axis) {
  return Vec3(glm::rotate(Mat4(1.f), angle, axis) * glm::vec4(v, 0.f));
}

}  // namespace

void CameraControls::take(const Transform& to_world, float distance) {
  const Mat4& m = to_world.matrix();
  origin_ = Vec3(m[3]);
  forward_ = glm::normalize(Vec3(m[2]));
  const Vec3 along = Vec3(m[1]) - glm::dot(Vec3(m[1]), forward_) * forward_;
  up_ = glm::length(along) > 0 ? glm::normalize(along) : Frame::from_normal(forward_).s;
  world_up_ = nearest_axis(up_);
  distance_ = distance > 0 && std::isfinite(distance) ? distance : 1;
  rest_ = glm::inverse(frame()) * m;
}

void CameraControls::set_home(const Transform& to_world, float distance) {
  home_ = {to_world, distance};
  take(to_world, distance);
}

Vec3 CameraControls::right() const {
  return glm::normalize(glm::cross(forward_, up_));
}

void CameraControls::look(float right_angle, float up_angle) {
  // Turns up first, but not over a pole.
  const float polar = std::acos(std::clamp(glm::dot(forward_, world_up_), -1.f, 1.f));
  // A camera that is already closer to the pole can be turned away from it.
  const float low = std::min(polar, kMinPolarAngle);
  const float high = std::max(polar, kPi - kMinPolarAngle);
  const float rise = polar - std::clamp(polar - up_angle, low, high);
  const Vec3 axis = right();
  forward_ = turned(forward_, rise, axis);
  up_ = turned(up_, rise, axis);
  forward_ = glm::normalize(turned(forward_, -right_angle, world_up_));
  up_ = turned(up_, -right_angle, world_up_);
  up_ = glm::normalize(up_ - glm::dot(up_, forward_) * forward_);
}

void CameraControls::orbit(float right_angle, float up_angle) {
  const Vec3 centre = target();
  // Moving to the right around the target turns the view to the left.
  look(-right_angle, -up_angle);
  origin_ = centre - distance_ * forward_;
}

void CameraControls::move(float right_length, float up_length, float forward_length) {
  origin_ += right_length * right() + up_length * up_ + forward_length * forward_;
}

void CameraControls::dolly(float factor, bool is_orthographic) {
  if (is_orthographic) {
    rest_ = rest_ * glm::scale(Mat4(1.f), Vec3(factor, factor, 1));
    return;
  }
  const Vec3 centre = target();
  distance_ *= factor;
  origin_ = centre - distance_ * forward_;
}

Mat4 CameraControls::frame() const {
  Mat4 m(1.f);
  m[0] = glm::vec4(-right(), 0.f);
  m[1] = glm::vec4(up_, 0.f);
  m[2] = glm::vec4(forward_, 0.f);
  m[3] = glm::vec4(origin_, 1.f);
  return m;
}

Transform CameraControls::to_world() const {
  return Transform(frame() * rest_);
}

std::string CameraControls::lookat() const {
  const Vec3 at = target();
  char text[256];
  std::snprintf(text, sizeof text,
                "<lookat origin=\"%.6g, %.6g, %.6g\" target=\"%.6g, %.6g, %.6g\" "
                "up=\"%.6g, %.6g, %.6g\"/>",
                origin_.x, origin_.y, origin_.z, at.x, at.y, at.z, up_.x, up_.y, up_.z);
  return text;
}

}  // namespace kinome::viewer
