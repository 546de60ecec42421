/// Tests of camera paths of films.
#include "film/camera_path.h"

#include <gtest/gtest.h>

namespace kinome::app::camera_path_test {
namespace {

CameraView start() {
  CameraView view;
  view.position = {1, 3, 6};
  view.target = {1, 2, 1};
  return view;
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-12) {
  EXPECT_NEAR(glm::distance(a, b), 0, tolerance) << a.x << " " << a.y << " " << a.z;
}

TEST(CameraPath, OrbitTurnsAboutTheAxisThroughTheTarget) {
  expect_near(orbit(start(), 0).position, {1, 3, 6});
  // The orbit is counterclockwise seen from above: from the front to the right.
  expect_near(orbit(start(), 0.25).position, {6, 3, 1});
  expect_near(orbit(start(), 0.5).position, {1, 3, -4});
  expect_near(orbit(start(), 1).position, {1, 3, 6});
  expect_near(orbit(start(), 0.3).target, {1, 2, 1});
}

TEST(CameraPath, EllipseIsOnASphereAroundItsTarget) {
  const CameraView middle = start();
  const double radius = glm::distance(middle.position, middle.target);
  const glm::dvec3 out = (middle.position - middle.target) / radius;
  for (int i = 0; i <= 100; ++i) {
    const CameraView view = on_ellipse(middle, {30, 10}, 0.01 * i);
    EXPECT_NEAR(glm::distance(view.position, middle.target), radius, 1e-12 * radius);
    EXPECT_EQ(view.target, middle.target);
    // Angles from the middle are those of an ellipse in polar coordinates: to the side and up.
    const glm::dvec3 d = (view.position - view.target) / radius;
    const double angle = glm::degrees(std::acos(glm::dot(d, out)));
    const double t = 2 * 3.14159265358979 * 0.01 * i;
    EXPECT_NEAR(angle, std::hypot(30 * std::cos(t), 10 * std::sin(t)), 1e-5) << i;
  }
  // The ellipse begins at the right and then goes up.
  EXPECT_GT(on_ellipse(middle, {30, 10}, 0).position.x, middle.position.x + 1);
  EXPECT_GT(on_ellipse(middle, {30, 10}, 0.25).position.y, middle.position.y + 0.1);
  expect_near(on_ellipse(middle, {0, 0}, 0.4).position, middle.position);
}

TEST(CameraPath, ViewsMatchLookat) {
  const auto to_world = start().to_world();
  ASSERT_TRUE(to_world);
  const Vec3 p = to_world->point({0, 0, 0}), d = to_world->vector({0, 0, 1});
  EXPECT_NEAR(glm::distance(p, Vec3(1, 3, 6)), 0, 1e-6);
  EXPECT_NEAR(glm::distance(d, glm::normalize(Vec3(0, -1, -5))), 0, 1e-6);
  CameraView down = start();
  down.target = {1, 0, 6};
  EXPECT_FALSE(down.to_world());
  down.target = down.position;
  EXPECT_FALSE(down.to_world());
}

KeyedCurve curve(std::vector<std::pair<double, double>> keys, KeyedCurve::Kind kind) {
  std::vector<KeyedCurve::Key> made;
  for (const auto& [time, value] : keys) made.push_back({time, glm::dvec3(value, 2 * value, 1)});
  return KeyedCurve(std::move(made), kind);
}

TEST(KeyedCurve, InterpolatesItsKeysAndIsConstantOutside) {
  for (const auto kind : {KeyedCurve::Kind::kCatmullRom, KeyedCurve::Kind::kMonotone}) {
    const KeyedCurve c = curve({{1, 5}, {2, 7}, {5, -1}, {5.5, 0}}, kind);
    for (const KeyedCurve::Key& key : c.keys()) expect_near(c.at(key.time), key.value);
    expect_near(c.at(-10), c.keys().front().value);
    expect_near(c.at(10), c.keys().back().value);
    expect_near(curve({{3, 4}}, kind).at(7), {4, 8, 1});
  }
}

/// A parabola through three keys has the slopes that the curve uses, for any spans between keys.
TEST(KeyedCurve, FollowsAParabolaBetweenInnerKeys) {
  const auto parabola = [](double t) { return 3 + 2 * t - 0.5 * t * t; };
  std::vector<std::pair<double, double>> keys;
  for (const double t : {0., 1., 1.5, 4., 6.}) keys.emplace_back(t, parabola(t));
  const KeyedCurve c = curve(keys, KeyedCurve::Kind::kCatmullRom);
  for (double t = 1; t < 4; t += 0.07) EXPECT_NEAR(c.at(t).x, parabola(t), 1e-12) << t;
}

/// Neither the values nor their derivatives jump at keys.
TEST(KeyedCurve, IsSmooth) {
  const KeyedCurve c = curve({{0, 0}, {1, 3}, {3, -2}, {4, 1}}, KeyedCurve::Kind::kCatmullRom);
  constexpr double kStep = 1e-6;
  for (const double t : {1., 3.}) {
    const double left = (c.at(t).x - c.at(t - kStep).x) / kStep;
    const double right = (c.at(t + kStep).x - c.at(t).x) / kStep;
    EXPECT_NEAR(left, right, 1e-4) << t;
  }
}

TEST(KeyedCurve, MonotoneOnesStayBetweenNeighbouringKeys) {
  const std::vector<std::pair<double, double>> keys = {
      {0, 0.1}, {1, 0.1}, {2, 0.9}, {2.2, 1}, {5, 0}};
  const KeyedCurve c = curve(keys, KeyedCurve::Kind::kMonotone);
  const KeyedCurve free = curve(keys, KeyedCurve::Kind::kCatmullRom);
  double min_value = 1, max_value = 0;
  for (size_t i = 0; i + 1 < keys.size(); ++i) {
    const auto [low, high] = std::minmax(keys[i].second, keys[i + 1].second);
    for (int j = 0; j <= 50; ++j) {
      const double t = keys[i].first + (keys[i + 1].first - keys[i].first) * j / 50;
      EXPECT_GE(c.at(t).x, low - 1e-12) << t;
      EXPECT_LE(c.at(t).x, high + 1e-12) << t;
      min_value = std::min(min_value, free.at(t).x);
      max_value = std::max(max_value, free.at(t).x);
    }
  }
  EXPECT_TRUE(min_value < 0.1 - 1e-3 || max_value > 1 + 1e-3);  // the other kind overshoots
}

}  // namespace
}  // namespace kinome::app::camera_path_test
