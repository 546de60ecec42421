// Compares hits of analytic shapes with closed forms in double precision.

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>

#include "support/shape_helpers.h"

namespace kinome::test::shape_geometry_test {
namespace {

using DVec3 = glm::dvec3;

/// Returns the sorted roots of a t² + 2 b t + c = 0.
std::vector<double> roots(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (a == 0 || discriminant < 0) return {};
  const double s = std::sqrt(discriminant);
  return {(-b - s) / a, (-b + s) / a};
}

/// All intersections of a ray with the untransformed shape. `margin` is the distance, in object
/// units, by which the ray must change to gain or lose hits.
struct ClosedForm {
  std::vector<double> t;
  double margin = 1e9;
};
using Solver = std::function<ClosedForm(const DVec3& o, const DVec3& d)>;

ClosedForm solve_sphere(const DVec3& o, const DVec3& d) {
  const double a = glm::dot(d, d);
  const double b = glm::dot(o, d);
  const double nearest = glm::length(o - d * (b / a));
  return {roots(a, b, glm::dot(o, o) - 1), std::abs(nearest - 1)};
}

ClosedForm solve_flat(const DVec3& o, const DVec3& d,
                      const std::function<double(double, double)>& distance_inside) {
  const double t = -o.z / d.z;
  const double inside = distance_inside(o.x + t * d.x, o.y + t * d.y);
  ClosedForm form;
  form.margin = std::min(std::abs(inside), std::abs(d.z) / glm::length(d));
  if (inside > 0) form.t.push_back(t);
  return form;
}

ClosedForm solve_disk(const DVec3& o, const DVec3& d) {
  return solve_flat(o, d, [](double x, double y) { return 1 - std::hypot(x, y); });
}

ClosedForm solve_rectangle(const DVec3& o, const DVec3& d) {
  return solve_flat(o, d,
                    [](double x, double y) { return 1 - std::max(std::abs(x), std::abs(y)); });
}

ClosedForm solve_cube(const DVec3& o, const DVec3& d) {
  double enter = -1e300;
  double leave = 1e300;
  for (int i = 0; i < 3; ++i) {
    const double t0 = (-1 - o[i]) / d[i];
    const double t1 = (1 - o[i]) / d[i];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  ClosedForm form;
  form.margin = std::abs(leave - enter) * glm::length(d);
  if (enter < leave) form.t = {enter, leave};
  return form;
}

ClosedForm solve_cylinder(const DVec3& o, const DVec3& d) {
  ClosedForm form;
  const double a = d.x * d.x + d.y * d.y;
  const double b = o.x * d.x + o.y * d.y;
  form.margin = std::abs(std::hypot(o.x - d.x * b / a, o.y - d.y * b / a) - 1);
  for (const double t : roots(a, b, o.x * o.x + o.y * o.y - 1)) {
    const double z = o.z + t * d.z;
    form.margin = std::min({form.margin, std::abs(z), std::abs(z - 1)});
    if (z > 0 && z < 1) form.t.push_back(t);
  }
  return form;
}

const std::map<std::string, Solver>& solvers() {
  static const std::map<std::string, Solver> all = {{"sphere", solve_sphere},
                                                    {"disk", solve_disk},
                                                    {"rectangle", solve_rectangle},
                                                    {"cube", solve_cube},
                                                    {"cylinder", solve_cylinder}};
  return all;
}

std::string shape_xml(const std::string& type, const std::string& transform) {
  return "<shape type='" + type + "'><transform name='to_world'>" + transform +
         "</transform></shape>";
}

class EachShape : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, EachShape,
                         testing::Values("sphere", "disk", "rectangle", "cube", "cylinder"),
                         [](const auto& test) { return test.param; });

TEST_P(EachShape, RaysHitItWhereTheClosedFormPredicts) {
  // Scaled by 2, rotated by 40 degrees around (1, 2, 2) / 3, and translated.
  const auto scene = scene_from(
      shape_xml(GetParam(),
                "<scale value='2'/><rotate value='.3333333 .6666667 .6666667' angle='40'/>"
                "<translate x='3' y='-2' z='1'/>"));
  const double angle = 40 * std::numbers::pi / 180;
  const DVec3 axis = DVec3(1, 2, 2) / 3.;
  const auto to_object = [&](const DVec3& v) {  // inverse rotation by Rodrigues' formula
    return (v * std::cos(angle) - glm::cross(axis, v) * std::sin(angle) +
            axis * glm::dot(axis, v) * (1 - std::cos(angle))) /
           2.;
  };
  Random random(7);
  const Solver& solver = solvers().at(GetParam());
  int hits = 0;
  int misses = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 target = Vec3(3, -2, 1) + 4.f * random.unit() * random.direction();
    const Vec3 o = target + random.between(0, 8) * random.direction();
    const Vec3 d = (target - o) * random.between(0.2f, 2);
    const ClosedForm form = solver(to_object(DVec3(o) - DVec3(3, -2, 1)), to_object(DVec3(d)));
    std::optional<double> expected;
    bool clear = form.margin > 1e-4;
    for (const double t : form.t) {
      if (std::abs(t) * glm::length(d) < 1e-3) clear = false;
      if (t > 0 && (!expected || t < *expected)) expected = t;
    }
    if (!clear) continue;
    const RayHit hit = trace(*scene, o, d);
    ASSERT_EQ(hit.hit.valid(), expected.has_value()) << "ray " << i;
    (expected ? hits : misses) += 1;
    if (!expected) continue;
    // The matrix and coordinates (up to 12) have rounding errors of 1e-6 to 2e-6. A slope of at
    // least sqrt(1e-4) magnifies them at most a hundredfold.
    const float length = glm::length(d);
    ASSERT_NEAR(hit.ray.tmax * length, *expected * length, 2e-4) << "ray " << i;
    const SurfaceInteraction si = scene->interaction(hit);
    ASSERT_LT(glm::length(si.p - (o + d * static_cast<float>(*expected))), 2e-4);
    ASSERT_NEAR(glm::length(si.n), 1, 1e-6);
    ASSERT_NEAR(glm::dot(si.n, si.dp_du) / glm::length(si.dp_du), 0, 1e-5);
    ASSERT_NEAR(glm::dot(si.n, si.dp_dv) / glm::length(si.dp_dv), 0, 1e-5);
  }
  EXPECT_GT(hits, 2000);
  EXPECT_GT(misses, 2000);
}

/// The derivatives are those of the surface: neighbouring hits move by dp_du du + dp_dv dv.
TEST_P(EachShape, DerivativesPredictNeighbouringHits) {
  const auto scene = scene_from(shape_xml(
      GetParam(),
      "<rotate value='.3333333 .6666667 .6666667' angle='40'/><translate x='.3' y='-.2' z='.1'/>"));
  Random random(8);
  int compared = 0;
  for (int i = 0; i < 5000; ++i) {
    const Vec3 o = 3.f * random.direction();
    const Vec3 d = glm::normalize(random.unit() * random.direction() - o);
    const RayHit a = trace(*scene, o, d);
    const RayHit b = trace(*scene, o, glm::normalize(d + 1e-3f * random.direction()));
    if (!a.hit.valid() || !b.hit.valid()) continue;
    const SurfaceInteraction sa = scene->interaction(a);
    const SurfaceInteraction sb = scene->interaction(b);
    const Vec2 duv = sb.uv - sa.uv;
    // Other faces, the seam and the singular points have no common chart.
    if (glm::dot(sa.n, sb.n) < 0.99f || glm::length(duv) > 0.05f) continue;
    if (std::abs(glm::dot(sa.n, d)) < 0.2f) continue;
    const Vec3 step = sb.p - sa.p;
    const float angle = glm::length(glm::cross(sa.dp_du, sa.dp_dv));
    if (angle < 0.3f) continue;  // near a pole or the disk's centre
    const Vec3 predicted = sa.dp_du * duv.x + sa.dp_dv * duv.y;
    // Steps are below 0.03. The second-order error is half their square, plus that of u and v,
    // scaled by at most 2 pi / 0.3. Third-order terms add a little.
    ASSERT_LT(glm::length(step - predicted), 14 * glm::dot(step, step) + 1e-5f) << i;
    ++compared;
  }
  EXPECT_GT(compared, 500);
}

TEST_P(EachShape, AreaIsTheClosedForm) {
  const std::map<std::string, float> areas = {{"sphere", 4 * kPi},
                                              {"disk", kPi},
                                              {"rectangle", 4.f},
                                              {"cube", 24.f},
                                              {"cylinder", 2 * kPi}};
  const auto area = [&](const std::string& transform) {
    return make<Shape>(shape_xml(GetParam(), transform))->area();
  };
  const float unit = areas.at(GetParam());
  EXPECT_NEAR(area(""), unit, 1e-6f * unit);
  EXPECT_NEAR(area("<scale value='3'/><rotate y='1' angle='70'/><translate x='9'/>"), 9 * unit,
              1e-5f * unit);
  EXPECT_NEAR(area("<scale value='-3'/>"), 9 * unit, 1e-5f * unit);
}

TEST(ShapeArea, OfStretchedFlatShapes) {
  EXPECT_NEAR(make<Shape>(shape_xml("disk", "<scale x='3' y='2' z='7'/>"))->area(), 6 * kPi, 1e-5f);
  EXPECT_NEAR(make<Shape>(shape_xml("rectangle", "<scale x='3' y='2' z='7'/>"))->area(), 24, 1e-5f);
}

TEST_P(EachShape, BoundsAreTightAndHoldEveryHit) {
  const auto scene = scene_from(shape_xml(GetParam(),
                                          "<scale value='2'/><rotate value='.3333333 .6666667 "
                                          ".6666667' angle='40'/><translate x='3'/>"));
  Random random(9);
  Aabb seen;
  for (int i = 0; i < 200000; ++i) {
    const Vec3 o = Vec3(3, 0, 0) + 8.f * random.direction();
    const Vec3 target = Vec3(3, 0, 0) + 4.f * random.unit() * random.direction();
    const RayHit hit = trace(*scene, o, target - o);
    if (hit.hit.valid()) seen.expand(scene->interaction(hit).p);
  }
  const Aabb bounds = scene->bounds();
  for (int i = 0; i < 3; ++i) {
    EXPECT_GE(seen.lo[i], bounds.lo[i] - 2e-6f);
    EXPECT_LE(seen.hi[i], bounds.hi[i] + 2e-6f);
    // With so many hits, the extreme ones are near the faces of the smallest box.
    EXPECT_LT(seen.lo[i], bounds.lo[i] + 0.25f);
    EXPECT_GT(seen.hi[i], bounds.hi[i] - 0.25f);
  }
}

TEST(ShapeParameters, BadValuesAreErrorsThatNameThem) {
  const std::map<std::string, std::string> cases = {
      {"<shape type='sphere'><float name='radius' value='0'/></shape>", "radius"},
      {"<shape type='sphere'><float name='radius' value='-1'/></shape>", "radius"},
      {"<shape type='cylinder'><point name='p1' x='0' y='0' z='0'/></shape>", "differ"},
      {"<shape type='cylinder'><float name='radius' value='0'/></shape>", "radius"},
      {shape_xml("rectangle", "<matrix value='1 0 0 0  0 1 0 0  0 0 1 0  0 1 0 1'/>"), "affine"},
      {"<shape type='rectangle'><string name='filename' value='x'/></shape>", "filename"},
  };
  for (const auto& [xml, expected] : cases) {
    const std::string error = error_of([&, text = xml] { make<Shape>(text); });
    EXPECT_NE(error.find(expected), std::string::npos) << xml << ": " << error;
  }
}

}  // namespace
}  // namespace kinome::test::shape_geometry_test
