// Tests that interactions of shapes have Mitsuba's values.

#include <gtest/gtest.h>

#include <memory>

#include "mitsuba_interactions.h"
#include "support/shape_helpers.h"

namespace kinome::test::shape_conventions_test {
namespace {

std::string with_folder(std::string xml, const std::string& folder) {
  const size_t place = xml.find("DIR");
  return place == std::string::npos ? xml : xml.replace(place, 3, folder);
}

/// Mitsuba computes in single precision, so that its values have errors of a few dozen ulps of
/// their terms (up to 20 here). Derivatives have the hit point's error times their magnitude.
template <class V>
bool near(const V& a, const V& b) {
  const float tolerance = 4e-5f * std::max(1.f, glm::length(b));
  return glm::length(a - b) <= tolerance;
}

std::string text(const Vec3& v) {
  return "(" + std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z) + ")";
}

/// Returns the part of dp_dv perpendicular to the curve. The reference direction of angles turns
/// along a B-spline. Mitsuba's derivative has another turn than its uv, unlike Kinome's
/// (CurveShapes.DerivativesMatchUv).
Vec3 own_dp_dv(const MitsubaInteraction& m, const Vec3& dp_dv) {
  if (std::string(m.xml).find("bsplinecurve") == std::string::npos) return dp_dv;
  return dp_dv - m.dp_du * (glm::dot(dp_dv, m.dp_du) / glm::dot(m.dp_du, m.dp_du));
}

TEST(ShapeConventions, AgreeWithMitsuba) {
  const TemporaryFolder folder;
  folder.write("plain.ply", kPlainPly);
  folder.write("normals.ply", kNormalsPly);
  folder.write("quad.obj", kQuadObj);
  folder.write("curves.txt", kCurves);
  for (const MitsubaInteraction& m : kMitsubaInteractions) {
    SCOPED_TRACE(std::string(m.xml) + " from " + text(m.o) + " along " + text(m.d));
    const auto scene = scene_from(with_folder(m.xml, folder.folder()));
    const RayHit hit = trace(*scene, m.o, m.d);
    ASSERT_TRUE(hit.hit.valid());
    const SurfaceInteraction si = scene->interaction(hit);
    EXPECT_NEAR(si.t, m.t, 4e-6f * m.t);
    EXPECT_TRUE(near(si.p, m.p)) << text(si.p);
    // If a mirroring transform is combined with stored normals, Mitsuba's geometric normal opposes
    // its shading normal. Kinome's both point to the shape's outside.
    const Vec3 n = glm::dot(m.n, m.shading_n) < 0 ? -m.n : m.n;
    EXPECT_TRUE(near(si.n, n)) << text(si.n) << " expected " << text(n);
    EXPECT_TRUE(near(si.uv, m.uv)) << si.uv.x << ", " << si.uv.y;
    if (m.dp_du != Vec3(0.f)) {  // Mitsuba has none for linear curves
      EXPECT_TRUE(near(si.dp_du, m.dp_du)) << text(si.dp_du) << " expected " << text(m.dp_du);
      EXPECT_TRUE(near(own_dp_dv(m, si.dp_dv), own_dp_dv(m, m.dp_dv)))
          << text(si.dp_dv) << " expected " << text(m.dp_dv);
    }
    EXPECT_TRUE(near(si.frame.n, m.shading_n)) << text(si.frame.n);
    EXPECT_TRUE(near(si.frame.s, m.shading_s)) << text(si.frame.s);
    EXPECT_TRUE(near(si.frame.t, glm::cross(si.frame.n, si.frame.s)));
    // Mitsuba's wi has the length of the ray's direction; Kinome's is a unit vector.
    EXPECT_TRUE(near(si.wi, glm::normalize(m.wi))) << text(si.wi);
  }
}

}  // namespace
}  // namespace kinome::test::shape_conventions_test
