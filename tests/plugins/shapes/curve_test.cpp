// Tests of curves: their files, and their intersections with rays.

#include <gtest/gtest.h>

#include <memory>
#include <sstream>

#include "support/shape_helpers.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

namespace kinome::test::curve_test {
namespace {

constexpr const char* kTypes[] = {"linearcurve", "bsplinecurve"};

/// Two curves. Part of the second is parallel to z, where the reference direction of u is special.
constexpr const char* kCurves = R"(0 0 0 .2
1 0 0 .1
1 1 0 .3
2 2 .5 .2
2 3 .3 .25

  0 0 2 .1
0 0 3 .1
0 0 4 .12
0 .5 5 .1
)";

class CurveShapes : public testing::Test {
 protected:
  std::string xml(const std::string& type, const std::string& text,
                  const std::string& inside = "") {
    return "<shape type='" + type + "'><string name='filename' value='" +
           folder_.write("curves.txt", text) + "'/>" + inside + "</shape>";
  }
  std::string fault(const std::string& type, const std::string& text,
                    const std::string& inside = "") {
    return error_of([&] { make<Shape>(xml(type, text, inside)); });
  }
  TemporaryFolder folder_;
};

/// Calls `action` for rays that hit the curves from all sides; returns the number of hits.
template <class Action>
int for_hits(const Scene& scene, int rays, Random& random, const Action& action) {
  const CurveSet& curves = *scene.shapes().at(0)->curves();
  int hits = 0;
  for (int i = 0; i < rays; ++i) {
    const size_t k =
        std::min(static_cast<size_t>(random.unit() * static_cast<float>(curves.points.size())),
                 curves.points.size() - 1);
    const Vec3 target = Vec3(curves.points[k]) + 0.6f * random.unit() * random.direction();
    const Vec3 o = Vec3(1, 1, 1) + 12.f * random.direction();
    const RayHit hit = trace(scene, o, target - o);
    if (!hit.hit.valid()) continue;
    ++hits;
    action(hit, scene.interaction(hit));
  }
  return hits;
}

TEST_F(CurveShapes, HaveASegmentForEachPieceOfEachCurve) {
  const auto linear = make<Shape>(xml("linearcurve", kCurves));
  EXPECT_EQ(linear->curves()->segments, (std::vector<uint32_t>{0, 1, 2, 3, 5, 6, 7}));
  const auto bspline = make<Shape>(xml("bsplinecurve", kCurves));
  EXPECT_EQ(bspline->curves()->segments, (std::vector<uint32_t>{0, 1, 5}));
  EXPECT_TRUE(bspline->curves()->is_bspline);
  EXPECT_EQ(bspline->curves()->points.size(), 9u);
  // Radii aren't scaled, as in Mitsuba.
  const auto larger = make<Shape>(
      xml("linearcurve", kCurves, "<transform name='to_world'><scale value='3'/></transform>"));
  EXPECT_EQ(larger->curves()->points[3], glm::vec4(6, 6, 1.5f, .2f));
}

TEST_F(CurveShapes, MayHaveCarriageReturnsBlankLinesAndMoreNumbers) {
  const auto shape =
      make<Shape>(xml("linearcurve", "\n\r\n0 0 0 1\r\n1 0 0 1 7\r\n\r\n \n\n+2 0 0 1\n3e0 0 0 1"));
  EXPECT_EQ(shape->curves()->segments, (std::vector<uint32_t>{0, 2}));
}

TEST_F(CurveShapes, LieInTheirBoundsAndAreSeenFromOutside) {
  for (const char* type : kTypes) {
    const auto scene = scene_from(xml(type, kCurves));
    const Aabb box = scene->bounds();
    Random random(1);
    const int hits = for_hits(*scene, 4000, random, [&](const RayHit& hit, const auto& si) {
      const Vec3 at = hit.ray.at(hit.ray.tmax);
      EXPECT_LT(glm::length(at - si.p), 2e-4f);
      for (int k = 0; k < 3; ++k) {
        EXPECT_GE(si.p[k], box.lo[k] - 1e-5f);
        EXPECT_LE(si.p[k], box.hi[k] + 1e-5f);
      }
      EXPECT_NEAR(glm::length(si.n), 1, 1e-5f);
      EXPECT_LT(glm::dot(si.n, glm::normalize(hit.ray.d)), 2e-2f);
      EXPECT_GT(si.p_error, 0);
      EXPECT_GE(si.uv.x, 0);
      EXPECT_LE(si.uv.x, 1);
      EXPECT_GE(si.uv.y, 0);
      EXPECT_LE(si.uv.y, 1);
    });
    EXPECT_GT(hits, 500);
  }
}

/// A segment of a linear curve is the envelope of balls. A hit touches the ball at its v.
TEST_F(CurveShapes, OfStraightPiecesTouchBalls) {
  const auto scene = scene_from(xml("linearcurve", kCurves));
  const CurveSet& curves = *scene->shapes()[0]->curves();
  Random random(2);
  for_hits(*scene, 2000, random, [&](const RayHit& hit, const SurfaceInteraction& si) {
    const uint32_t first = curves.segments[hit.hit.primitive];
    const glm::vec4 ball = glm::mix(curves.points[first], curves.points[first + 1], hit.hit.u);
    EXPECT_NEAR(glm::length(si.p - Vec3(ball)), ball.w, 1e-5f);
    EXPECT_LT(glm::length(si.n - (si.p - Vec3(ball)) / ball.w), 1e-5f);
    const float v = (static_cast<float>(hit.hit.primitive) + hit.hit.u) / 7;
    EXPECT_NEAR(si.uv.y, v, 1e-6f);
  });
}

/// Compares derivatives with the differences of points along neighbouring rays.
TEST_F(CurveShapes, DerivativesMatchUv) {
  const auto scene = scene_from(xml("bsplinecurve", kCurves));
  Random random(3);
  std::vector<double> errors;
  for_hits(*scene, 4000, random, [&](const RayHit& hit, const SurfaceInteraction& si) {
    EXPECT_NEAR(glm::dot(si.n, glm::normalize(si.dp_du)), 0, 2e-3f);
    EXPECT_NEAR(glm::dot(si.n, glm::normalize(si.dp_dv)), 0, 2e-3f);
    if (glm::dot(si.n, glm::normalize(hit.ray.d)) > -0.3f) return;
    const Vec3 aside = 0.002f * random.direction();
    const RayHit other = trace(*scene, hit.ray.o + aside, hit.ray.d);
    if (!other.hit.valid() || other.hit.primitive != hit.hit.primitive) return;
    const SurfaceInteraction there = scene->interaction(other);
    Vec2 change = there.uv - si.uv;
    if (std::abs(change.x) > 0.5f) return;  // across the seam of u
    const Vec3 expected = si.dp_du * change.x + si.dp_dv * change.y;
    errors.push_back(glm::length(there.p - si.p - expected) / 0.002);
  });
  ASSERT_GT(errors.size(), 500u);
  std::sort(errors.begin(), errors.end());
  // Tolerance: second-order terms, and the tracer's error of some 1e-5.
  EXPECT_LT(errors[errors.size() * 9 / 10], 0.05);
}

TEST_F(CurveShapes, LetNoRayThroughTheirCentres) {
  for (const char* type : kTypes) {
    const auto scene = scene_from(xml(type, kCurves));
    const CurveSet& curves = *scene->shapes()[0]->curves();
    Random random(4);
    int missed = 0, traced = 0;
    for (int i = 0; i < 20000; ++i) {
      const uint32_t first = curves.segments[static_cast<size_t>(i) % curves.segments.size()];
      const float u = i % 5 == 0 ? 1 : random.unit();  // also at joints
      const glm::vec4* const p = &curves.points[first];
      const Vec3 target =
          curves.is_bspline
              ? Vec3((1 - u) * (1 - u) * (1 - u) * p[0] + (4 - 6 * u * u + 3 * u * u * u) * p[1] +
                     (1 + 3 * u + 3 * u * u - 3 * u * u * u) * p[2] + u * u * u * p[3]) /
                    6.f
              : Vec3(glm::mix(p[0], p[1], u));
      const Vec3 d = random.direction();
      // B-splines have no caps: rays along them may enter at their ends.
      const Vec3 along = glm::normalize(Vec3(p[curves.is_bspline ? 2 : 1]) - Vec3(p[0]));
      if (curves.is_bspline && (std::abs(glm::dot(d, along)) > .5f || u < .2f || u > .8f)) continue;
      ++traced;
      missed += !trace(*scene, target - 20.f * d, d).hit.valid();
    }
    EXPECT_GT(traced, 3000);
    EXPECT_EQ(missed, 0) << type;
  }
}

TEST_F(CurveShapes, AreNotMetByRaysThatLeaveThem) {
  struct Case {
    float size;
    Vec3 offset;
  };
  for (const char* type : kTypes) {
    for (const Case& c : {Case{1, Vec3(0.f)}, Case{1e-3f, Vec3(0.f)}, Case{1e3f, Vec3(0.f)},
                          Case{1, Vec3(100, -50, 20)}}) {
      SCOPED_TRACE(std::string(type) + " of " + std::to_string(c.size));
      // A straight rod, which is convex.
      std::ostringstream text;
      for (int i = 0; i < 5; ++i) {
        const Vec3 p = c.offset + c.size * static_cast<float>(i) * Vec3(1, .3f, .2f);
        text << p.x << ' ' << p.y << ' ' << p.z << ' ' << .4f * c.size << '\n';
      }
      const auto scene = scene_from(xml(type, text.str()));
      Random random(5);
      std::vector<RayHit> leaving;
      for (int i = 0; i < 10000; ++i) {
        const Vec3 target = c.offset + c.size * (random.between(0, 4) * Vec3(1, .3f, .2f) +
                                                 .4f * random.direction());
        const Vec3 o = c.offset + c.size * (Vec3(2, .6f, .4f) + 10.f * random.direction());
        const RayHit hit = trace(*scene, o, glm::normalize(target - o));
        if (!hit.hit.valid()) continue;
        const SurfaceInteraction si = scene->interaction(hit);
        const Vec3 d = grazing_direction(random, si.n, -2.5f);
        leaving.push_back(ray_hit(si.ray_origin(d), d));
      }
      EXPECT_GT(leaving.size(), 2000u);
      EXPECT_EQ(count_hits(*scene, leaving), 0);
    }
  }
}

TEST_F(CurveShapes, ReportErrors) {
  const auto says = [&](const std::string& message, const std::string& place,
                        const std::string& what) {
    EXPECT_NE(message.find("curves.txt" + place), std::string::npos) << message;
    EXPECT_NE(message.find(what), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  for (const std::string type : kTypes) {
    says(fault(type, ""), ":", "no curves");
    says(fault(type, "\n \n"), ":", "no curves");
    says(fault(type, "0 0 0 1\n"), ":1:1:", "expected at least");
    says(fault(type, "0 0 0 0\n1 0 0 0\n2 0 0 0\n3 0 0 0\n"), ":", "all curves are 0");
    says(fault(type, "0 0 0 1\n1 0 0 -2\n"), ":2:7:", "must be finite and not negative");
    says(fault(type, "0 0 0 1\n1 0 0 nan\n"), ":2:7:", "must be finite and not negative");
    says(fault(type, "0 0 inf 1\n1 0 0 2\n"), ":1:5:", "not finite");
    says(fault(type, "0 0 0\n1 0 0 1\n"), ":1:6:", "expected a radius, but the line ends");
    says(fault(type, "# hair\n0 0 0 1\n"), ":1:1:", "expected a coordinate, got '#'");
    says(fault(type, "0,0,0,1\n"), ":1:1:", "expected a coordinate");
    says(fault(type, std::string(kCurves) + "\n0 0 0 1\n"), ":12:1:", "a curve has 1 control");
    EXPECT_NE(fault(type, kCurves, "<emitter type='area'/>").find("emitter"), std::string::npos);
  }
  says(fault("bsplinecurve", "0 0 0 1\n1 0 0 1\n2 0 0 1\n"),
       ":1:1:", "has 3 control points, expected at least 4");
}

class CurveBlocks : public testing::TestWithParam<InstructionSet> {};

TEST_P(CurveBlocks, MatchSinglePoints) {
  const TemporaryFolder folder;
  for (const char* type : kTypes) {
    const std::string xml = "<shape type='" + std::string(type) +
                            "'><string name='filename' value='" +
                            folder.write("curves.txt", kCurves) + "'/></shape>";
    const auto shape = make_for<Shape>(GetParam(), xml);
    const auto scene = scene_from(xml);
    Random random(6);
    for (const size_t count : kRanges) {
      std::vector<RayHit> hits;
      while (hits.size() < count) {
        for_hits(*scene, 50, random, [&](const RayHit& hit, const SurfaceInteraction&) {
          if (hits.size() < count) hits.push_back(hit);
        });
      }
      BlockMemory memory(count);
      std::vector<RayHit16> rays(padded(count) / 16 + 1);
      SurfaceBlock points;
      points.count = count;
      for (Columns3* c : {&points.p, &points.n, &points.s, &points.t, &points.sn, &points.wi,
                          &points.dp_du, &points.dp_dv}) {
        *c = memory.three();
      }
      points.uv = memory.two();
      points.p_error = memory.one();
      points.primitive = memory.indices(), points.ray = memory.indices();
      for (size_t i = 0; i < count; ++i) {
        RayHit16& to = rays[i / 16];
        Columns3{to.ray.ox, to.ray.oy, to.ray.oz}.set(i % 16, hits[i].ray.o);
        Columns3{to.ray.dx, to.ray.dy, to.ray.dz}.set(i % 16, hits[i].ray.d);
        to.ray.tmax[i % 16] = hits[i].ray.tmax;
        to.u[i % 16] = hits[i].hit.u, to.v[i % 16] = hits[i].hit.v;
        to.primitive[i % 16] = hits[i].hit.primitive;
        points.ray[i] = static_cast<uint32_t>(i);
      }
      shape->interaction_block(rays.data(), points);
      for (size_t i = 0; i < count; ++i) {
        const SurfaceInteraction si = shape->interaction(hits[i].ray, hits[i].hit);
        constexpr float kNear = 2e-5f;
        EXPECT_LT(largest_difference(points.p.at(i), si.p), kNear);
        EXPECT_NEAR(points.p_error[i], si.p_error, 1e-5f * si.p_error);
        EXPECT_LT(largest_difference(points.n.at(i), si.n), 5 * kNear);
        EXPECT_LT(largest_difference(points.dp_du.at(i), si.dp_du), 5 * kNear);
        EXPECT_LT(largest_difference(points.dp_dv.at(i), si.dp_dv),
                  5 * kNear * (1 + largest_coordinate(si.dp_dv)));
        const float turn = std::abs(points.uv.x[i] - si.uv.x);
        EXPECT_LT(std::min(turn, 1 - turn), kNear);
        EXPECT_NEAR(points.uv.y[i], si.uv.y, kNear);
        EXPECT_EQ(points.primitive[i], si.primitive);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, CurveBlocks, testing::ValuesIn(instruction_sets()),
                         [](const auto& test) { return name_of(test.param); });

TEST_F(CurveShapes, ContainNoMedium) {
  const char* const message =
      "'interior' isn't possible for curves, because rays hit them only from outside";
  for (const std::string type : kTypes) {
    const std::string medium =
        fault(type, kCurves, "\n<medium type='homogeneous' name='interior'/>");
    EXPECT_NE(medium.find(std::string(":2:1: ") + message), std::string::npos) << medium;
    const std::string wax = fault(type, kCurves, "<bsdf type='subsurface'/>");
    EXPECT_NE(wax.find("shape '" + type + "': " + message), std::string::npos) << wax;
    EXPECT_EQ(fault(type, kCurves, "<medium type='homogeneous' name='exterior'/>"), "");
  }
}

}  // namespace
}  // namespace kinome::test::curve_test
