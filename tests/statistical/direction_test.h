#pragma once

#include <functional>
#include <optional>

#include "support/statistics.h"
#include "support/shape_helpers.h"

namespace kinome::test {

/// Tests sampled directions against a density with jumps, such as that of points on a shape. Jumps
/// defeat cubature, but don't affect an estimate by random directions.
struct DirectionTest {
  /// Returns nullopt if no direction was sampled.
  std::function<std::optional<Vec3>(Vec2 u)> sample;
  std::function<float(const Vec3& d)> pdf;
  /// Axis of a cone that contains all directions of the light, and 1 - cos of its half angle.
  Vec3 axis{0, 0, 1};
  float height = 2;
  int samples = 50000;
};

/// Sets the cone to contain a box as seen from p.
inline void aim_at(DirectionTest& test, const Vec3& p, const Aabb& box) {
  const Vec3 to = box.centre() - p;
  const float radius = 0.5f * glm::length(box.extent()) * 1.001f;
  const float sine = radius / glm::length(to);
  if (!(sine < 1)) return;
  test.axis = glm::normalize(to);
  test.height = 1 - std::sqrt(1 - sine * sine);
}

/// z-tests of the number of samples in each cell of the cone, and of their sum.
inline Verdict direction_test(const DirectionTest& test, double alpha) {
  constexpr int kRings = 6, kSectors = 10, kCells = kRings * kSectors;
  const Frame frame = Frame::from_normal(test.axis);
  const auto cell_of = [&](const Vec3& d) {
    const Vec3 local = frame.to_local(d);
    const float ring = (1 - local.z) / test.height;
    if (ring > 1 + 1e-4f) return -1;
    const float turn = std::atan2(local.y, local.x) / (2 * kPi) + 0.5f;
    return std::clamp(static_cast<int>(ring * kRings), 0, kRings - 1) * kSectors +
           std::clamp(static_cast<int>(turn * kSectors), 0, kSectors - 1);
  };
  std::vector<Moments> sampled(kCells), expected(kCells);
  Random random(41);
  for (int i = 0; i < test.samples; ++i) {
    const auto d = test.sample({random.unit(), random.unit()});
    const int cell = d ? cell_of(*d) : -1;
    if (d && cell < 0) return {false, 0, "a direction lies outside the cone"};
    for (int k = 0; k < kCells; ++k) sampled[k].add(k == cell);

    const float depth = random.unit() * test.height;
    const float phi = random.between(0, 2 * kPi);
    const float r = safe_sqrt(depth * (2 - depth));
    const Vec3 even = frame.to_world({r * std::cos(phi), r * std::sin(phi), 1 - depth});
    const double mass = static_cast<double>(test.pdf(even) * 2 * kPi * test.height);
    const int even_cell = cell_of(even);
    for (int k = 0; k < kCells; ++k) expected[k].add(k == even_cell ? mass : 0);
  }
  std::vector<Estimate> a, b;
  for (const Moments& m : sampled) a.push_back({m.mean(), m.variance_of_mean()});
  for (const Moments& m : expected) b.push_back({m.mean(), m.variance_of_mean()});
  return z_test(a, b, alpha);
}

}  // namespace kinome::test
