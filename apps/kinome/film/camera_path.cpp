// Paths of a camera, and curves of other values, over the frames of an animation.

#include "film/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/gtc/matrix_transform.hpp>

#include "kinome/look_at.h"

namespace kinome::app {
namespace {

glm::dvec3 rotated(const glm::dvec3& v, double angle, const glm::dvec3& axis) {
  return glm::dvec3(glm::rotate(glm::dmat4(1), angle, axis) * glm::dvec4(v, 0));
}

/// Returns the slope at `key` of the parabola through three keys. This is a mean of the slopes on
/// both sides, weighted toward the shorter side.
glm::dvec3 slope_at(const KeyedCurve::Key& before, const KeyedCurve::Key& key,
                    const KeyedCurve::Key& after) {
  const double left = key.time - before.time, right = after.time - key.time;
  const glm::dvec3 slope_left = (key.value - before.value) / left;
  const glm::dvec3 slope_right = (after.value - key.value) / right;
  return (right * slope_left + left * slope_right) / (left + right);
}

/// Limits a tangent so that the cubics on both sides stay between their ends (Fritsch and Carlson
/// 1980). The limit is three times the slopes on both sides, and 0 if these differ in sign.
double limited_tangent(double tangent, double slope_left, double slope_right) {
  if (slope_left * slope_right <= 0) return 0;
  const double limit = 3 * std::min(std::abs(slope_left), std::abs(slope_right));
  return std::clamp(tangent, -limit, limit);
}

}  // namespace

std::optional<Transform> CameraView::to_world() const {
  // In single precision, like <lookat> in a scene file.
  const Vec3 from(position), to(target);
  if (from == to) return std::nullopt;
  const auto matrix = look_at(from, to, Vec3(up));
  if (!matrix) return std::nullopt;
  return Transform(Mat4(*matrix));
}

CameraView orbit(const CameraView& start, double turn) {
  CameraView view = start;
  view.position = start.target + rotated(start.position - start.target, 2 * std::numbers::pi * turn,
                                         glm::normalize(start.up));
  return view;
}

CameraView on_ellipse(const CameraView& middle, const glm::dvec2& half_axes, double turn) {
  const double radius = glm::length(middle.position - middle.target);
  const glm::dvec3 out = (middle.position - middle.target) / radius;
  // Axes as seen by the camera.
  const glm::dvec3 right = glm::normalize(glm::cross(middle.up, out));
  const glm::dvec3 above = glm::cross(out, right);
  const double t = 2 * std::numbers::pi * turn;
  const glm::dvec2 angles = glm::radians(half_axes) * glm::dvec2(std::cos(t), std::sin(t));
  const double angle = glm::length(angles);
  CameraView view = middle;
  if (angle == 0) return view;
  const glm::dvec3 along = (angles.x * right + angles.y * above) / angle;
  view.position = middle.target + radius * (std::cos(angle) * out + std::sin(angle) * along);
  return view;
}

KeyedCurve::KeyedCurve(std::vector<Key> keys, Kind kind) : keys_(std::move(keys)) {
  const size_t count = keys_.size();
  tangents_.assign(count, glm::dvec3(0.));
  if (count < 2) return;
  const auto slope = [this](size_t i) {
    return (keys_[i + 1].value - keys_[i].value) / (keys_[i + 1].time - keys_[i].time);
  };
  tangents_.front() = slope(0);
  tangents_.back() = slope(count - 2);
  for (size_t i = 1; i + 1 < count; ++i) {
    tangents_[i] = slope_at(keys_[i - 1], keys_[i], keys_[i + 1]);
    if (kind != Kind::kMonotone) continue;
    for (int c = 0; c < 3; ++c) {
      tangents_[i][c] = limited_tangent(tangents_[i][c], slope(i - 1)[c], slope(i)[c]);
    }
  }
}

glm::dvec3 KeyedCurve::at(double time) const {
  if (time <= keys_.front().time) return keys_.front().value;
  if (time >= keys_.back().time) return keys_.back().value;
  const auto after = std::upper_bound(keys_.begin(), keys_.end(), time,
                                      [](double t, const Key& key) { return t < key.time; });
  const auto i = static_cast<size_t>(after - keys_.begin()) - 1;
  const double span = keys_[i + 1].time - keys_[i].time;
  const double u = (time - keys_[i].time) / span, v = 1 - u;
  // The cubic Hermite spline with these values and tangents.
  return v * v * (1 + 2 * u) * keys_[i].value + u * u * (1 + 2 * v) * keys_[i + 1].value +
         span * u * v * (v * tangents_[i] - u * tangents_[i + 1]);
}

}  // namespace kinome::app
