#include "handles/handle_drag.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

namespace kinome::viewer {
namespace {

/// Minimum cosine between a ray and the normal of a plane, or sine between a ray and an axis.
/// Otherwise a pixel of the mouse would be a large movement.
constexpr float kMinCosine = 0.02f;

/// Returns the intersection with the plane through `point` with the unit vector `normal`.
std::optional<Vec3> on_plane(const Ray& ray, const Vec3& point, const Vec3& normal) {
  const float cosine = glm::dot(ray.d, normal);
  if (!(std::abs(cosine) > kMinCosine * glm::length(ray.d))) return std::nullopt;
  const float t = glm::dot(point - ray.o, normal) / cosine;
  return t > 0 ? std::optional(ray.at(t)) : std::nullopt;
}

/// Returns the coordinate, along the axis through `point`, of the point that is nearest to the ray.
std::optional<float> on_axis(const Ray& ray, const Vec3& point, const Vec3& axis) {
  const Vec3 d = glm::normalize(ray.d);
  const float cosine = glm::dot(d, axis), sine2 = 1 - cosine * cosine;
  if (!(sine2 > kMinCosine * kMinCosine)) return std::nullopt;
  const Vec3 way = ray.o - point;
  return (glm::dot(way, axis) - cosine * glm::dot(way, d)) / sine2;
}

Vec3 unit_axis(int index) {
  Vec3 axis(0.f);
  axis[index] = 1;
  return axis;
}

}  // namespace

std::optional<Mat4> dragged(Handle handle, const Vec3& pivot, const Vec3& forward, const Ray& from,
                            const Ray& to) {
  const int index = axis_of(handle);
  const Vec3 axis = index < 0 ? forward : unit_axis(index);
  if (handle <= Handle::kMoveZ) {
    const auto start = on_axis(from, pivot, axis), end = on_axis(to, pivot, axis);
    if (!start || !end) return std::nullopt;
    return glm::translate(Mat4(1.f), (*end - *start) * axis);
  }
  const auto start = on_plane(from, pivot, axis), end = on_plane(to, pivot, axis);
  if (!start || !end) return std::nullopt;
  if (handle <= Handle::kMoveInView) return glm::translate(Mat4(1.f), *end - *start);
  const Vec3 a = *start - pivot, b = *end - pivot;
  const float angle = std::atan2(glm::dot(glm::cross(a, b), axis), glm::dot(a, b));
  return glm::translate(glm::rotate(glm::translate(Mat4(1.f), pivot), angle, axis), -pivot);
}

}  // namespace kinome::viewer
