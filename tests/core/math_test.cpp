#include "kinome/math.h"

#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "kinome/columns.h"
#include "kinome/image.h"
#include "kinome/ray.h"
#include "kinome/sensor.h"

namespace kinome::math_test {
namespace {

Mat4 rotation_and_shift() {
  Mat4 m = glm::translate(Mat4(1.f), Vec3(1, -2, 3));
  return glm::rotate(m, 0.7f, glm::normalize(Vec3(1, 2, -1)));
}

/// Some 10 roundings of values below 10.
constexpr float kRounding = 1e-5f;

void expect_near(const Vec3& a, const Vec3& b, float tolerance) {
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance) << "component " << i;
}

TEST(Transform, PointsShiftAndVectorsDoNot) {
  const Transform shift(glm::translate(Mat4(1.f), Vec3(1, 2, 3)));
  EXPECT_EQ(shift.point(Vec3(1, 1, 1)), Vec3(2, 3, 4));
  EXPECT_EQ(shift.vector(Vec3(1, 1, 1)), Vec3(1, 1, 1));
}

TEST(Transform, ProjectiveMapsDivide) {
  Mat4 m(1.f);
  m[2][3] = 1;  // w = z + 1
  EXPECT_EQ(Transform(m).point(Vec3(2, 4, 1)), Vec3(1, 2, 0.5f));
}

TEST(Transform, NormalsStayPerpendicularToStretchedSurfaces) {
  const Transform stretch(glm::scale(Mat4(1.f), Vec3(4, 1, 0.5f)) * rotation_and_shift());
  const Vec3 n = stretch.normal(Vec3(0, 0, 1));
  EXPECT_NEAR(glm::dot(n, stretch.vector(Vec3(1, 0, 0))), 0, kRounding);
  EXPECT_NEAR(glm::dot(n, stretch.vector(Vec3(0, 1, 0))), 0, kRounding);
  EXPECT_GT(glm::dot(n, stretch.vector(Vec3(0, 0, 1))), 0);
}

TEST(Transform, ProductAppliesTheRightOneFirst) {
  const Transform a(rotation_and_shift());
  const Transform b(glm::scale(Mat4(1.f), Vec3(2, 3, 4)));
  const Vec3 p(0.3f, -0.4f, 0.5f);
  expect_near((a * b).point(p), a.point(b.point(p)), kRounding);
  expect_near((a * b).inverse().point((a * b).point(p)), p, kRounding);
}

TEST(Transform, InverseIsAccurateToSinglePrecision) {
  // A thin needle in a rotated frame. Its determinant of 1e-6 is a sum of terms near 1, so that
  // single precision would cause errors of some per cent. The exact inverse rounded to float has an
  // error of the condition number times epsilon, 6e-5.
  const auto turn = [](float angle, const Vec3& axis) {
    return glm::rotate(Mat4(1.f), angle, glm::normalize(axis));
  };
  const Mat4 m = turn(0.7f, Vec3(1, 2, -1)) * glm::scale(Mat4(1.f), Vec3(1, 1e-3f, 1e-3f)) *
                 turn(1.1f, Vec3(2, -1, 1));
  const glm::dmat4 product = glm::dmat4(Transform(m).inverse_matrix()) * glm::dmat4(m);
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(product[c][r], c == r, 5e-4) << c << ' ' << r;
  }
}

TEST(Transform, ReportsItsProperties) {
  const Transform rigid(rotation_and_shift());
  EXPECT_TRUE(rigid.is_invertible());
  EXPECT_FALSE(rigid.has_scale());
  EXPECT_FALSE(rigid.flips_handedness());
  EXPECT_FALSE(rigid.is_identity());
  EXPECT_TRUE(Transform().is_identity());
  EXPECT_TRUE(Transform(glm::scale(Mat4(1.f), Vec3(1, 1.01f, 1))).has_scale());
  EXPECT_TRUE(Transform(glm::scale(Mat4(1.f), Vec3(1, -1, 1))).flips_handedness());
  EXPECT_FALSE(Transform(glm::scale(Mat4(1.f), Vec3(1, -1, 1))).has_scale());
  EXPECT_FALSE(Transform(glm::scale(Mat4(1.f), Vec3(1, 0, 1))).is_invertible());
  EXPECT_FALSE(Transform(Mat4(kInfinity)).is_invertible());
}

TEST(Frame, IsOrthonormalAndRightHandedAroundAnyNormal) {
  for (const Vec3& v : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(1, 2, -3),
                        Vec3(1e-4f, 1e-4f, -1), Vec3(-5, 1, 1e-3f)}) {
    const Vec3 n = glm::normalize(v);
    for (const Frame& f : {Frame::from_normal(n), Frame::from_normal_and_tangent(n, Vec3(1, 5, 2)),
                           Frame::from_normal_and_tangent(n, n)}) {
      EXPECT_NEAR(glm::length(f.s), 1, kRounding);
      EXPECT_NEAR(glm::dot(f.s, f.n), 0, kRounding);
      expect_near(glm::cross(f.s, f.t), f.n, kRounding);
      expect_near(f.to_world(f.to_local(v)), v, 10 * kRounding);
    }
  }
}

// These types require all of their values. A part of them must not compile, as it would for an
// aggregate.
template <class T, class... Parts>
constexpr bool kTakes = std::is_constructible_v<T, Parts...>;
static_assert(!std::is_aggregate_v<Frame> && !kTakes<Frame, Vec3> && !kTakes<Frame, Vec3, Vec3> &&
              kTakes<Frame, Vec3, Vec3, Vec3>);
static_assert(!kTakes<Aabb, Vec3> && kTakes<Aabb, Vec3, Vec3>);
static_assert(!kTakes<Rect, int> && !kTakes<Rect, int, int> && !kTakes<Rect, int, int, int> &&
              kTakes<Rect, int, int, int, int>);
static_assert(!kTakes<Ray, Vec3> && kTakes<Ray, Vec3, Vec3> && kTakes<Ray, Vec3, Vec3, float, float>);
static_assert(!kTakes<Columns2, float*> && kTakes<Columns2, float*, float*>);
static_assert(!kTakes<Columns3, float*> && !kTakes<Columns3, float*, float*> &&
              kTakes<Columns3, float*, float*, float*>);
static_assert(!kTakes<Image, int, int> && !kTakes<Image, int, int, std::vector<std::string>>);
static_assert(!kTakes<Shutter, float> && kTakes<Shutter, float, float>);
// The layout must be that of Embree.
static_assert(std::is_standard_layout_v<Ray> && std::is_trivially_copyable_v<Ray>);

TEST(Ray, TakesOriginAndDirection) {
  const Ray ray(Vec3(1, 2, 3), Vec3(0, 1, 0), 0.5f, 4);
  EXPECT_EQ(ray.at(ray.tmax), Vec3(1, 6, 3));
  EXPECT_EQ(ray.tmin, 0.5f);
  EXPECT_EQ(Ray(Vec3(1), Vec3(2)).tmax, kInfinity);
}

}  // namespace
}  // namespace kinome::math_test
