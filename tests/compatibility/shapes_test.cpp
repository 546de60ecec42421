/// Shapes that shadow themselves because of rounding, instances too small to trace, and spheres and
/// cylinders under nonuniform scales, as Mitsuba 3.9.1 renders them.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/shape_helpers.h"

namespace kinome::test::shapes_test {
namespace {

std::string number(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", v);
  return text;
}

/// An image of `size` x `size` units around the point (x, 0, 0), under a sky of 1. All samples are
/// BSDF samples: a diffuse surface of reflectance 0.5 without shadows is 0.5 in each.
std::string close_up_xml(double size, double x) {
  return "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"0\"/>"
         "<integer name=\"bsdf_samples\" value=\"1\"/></integrator><emitter type=\"constant\"/>"
         "<sensor type=\"orthographic\"><float name=\"near_clip\" value=\"1e-6\"/>"
         "<transform name=\"to_world\"><scale x=\"" +
         number(size / 2) + "\" y=\"" + number(size / 2) + "\"/><lookat origin=\"" + number(x) +
         ",0,3\" target=\"" + number(x) +
         ",0,0\" up=\"0,1,0\"/></transform><sampler type=\"independent\">"
         "<integer name=\"sample_count\" value=\"64\"/></sampler><film type=\"hdrfilm\">"
         "<integer name=\"width\" value=\"8\"/><integer name=\"height\" value=\"8\"/>"
         "<string name=\"component_format\" value=\"float32\"/><rfilter type=\"box\"/></film>"
         "</sensor>";
}

TEST(ThinCurve, DoesNotShadowItself) {
  const TemporaryFolder folder;
  for (const char* type : {"bsplinecurve", "linearcurve"}) {
    for (const double radius : {1e-2, 1e-4, 1e-5}) {
      // At 40, neighbouring floats are 4e-6 apart.
      for (const double x : {0., radius < 1e-4 ? 0. : 40.}) {
        std::string points;
        for (int k = -3; k <= 3; ++k) {
          points += std::to_string(x + 0.5 * k) + " 0 0 " + number(radius) + "\n";
        }
        const std::string file = folder.write("curve.txt", points);
        const Image image = render_scene(
            *scene_from(close_up_xml(3 * radius, x) + "<shape type=\"" + type +
                        "\"><string name=\"filename\" value=\"" + file +
                        "\"/><bsdf type=\"diffuse\"/></shape>"));
        // Some rays pass through very thin curves because of rounding, and see the sky.
        for (const float value : image.data) {
          ASSERT_GE(value, 0.5f - 1e-6f) << type << ' ' << radius << ' ' << x;
        }
      }
    }
  }
}

TEST(SmallInstance, IsRenderedOrAnError) {
  const auto scene = [](const char* scale) {
    return scene_from(std::string("<integrator type=\"path\"/><emitter type=\"constant\"/>") +
                      "<sensor type=\"perspective\"><transform name=\"to_world\">"
                      "<lookat origin=\"0,1,6\" target=\"0,0,0\" up=\"0,1,0\"/></transform>"
                      "<film type=\"hdrfilm\"><integer name=\"width\" value=\"4\"/>"
                      "<integer name=\"height\" value=\"4\"/></film></sensor>"
                      "<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"/></shape>"
                      "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><scale "
                      "value=\"" +
                      scale + "\"/></transform></shape>");
  };
  for (const char* scale : {"1e-6", "1e-12"}) {
    for (const float value : render_scene(*scene(scale)).data) EXPECT_NEAR(value, 1, 1e-6) << scale;
  }
  const auto expect_error = [&](const char* scale, const char* expected) {
    const std::string error = error_of([&] { scene(scale); });
    EXPECT_NE(error.find(expected), std::string::npos) << scale << ": " << error;
  };
  // The determinant exceeds the range of float.
  for (const char* scale : {"1e-13", "1e-17", "1e-30", "1e13"}) {
    expect_error(scale, "scales by too much");
  }
  // Rays from the camera exceed that of the ray tracer.
  expect_error("1e-18, 1, 1", "scaled down too far: rays from 6 units away");
}

std::string shape_xml(const std::string& type, const std::string& to_world,
                      const std::string& more = "") {
  return "<shape type=\"" + type + "\">" + more + "<transform name=\"to_world\">" + to_world +
         "</transform></shape>";
}
const std::string kShear = "<matrix value=\"1 .5 0 0  0 1 0 0  0 0 1 0  0 0 0 1\"/>";

/// The radius is scaled like the x axis.
TEST(UnevenScale, LeavesASphereASphere) {
  const struct {
    std::string shape;
    Vec3 centre;
    float radius;
  } cases[] = {
      {shape_xml("sphere", "<scale x=\"2\" y=\"1\" z=\"0.5\"/>"), Vec3(0), 2},
      {shape_xml("sphere", kShear), Vec3(0), 1},
      {shape_xml("sphere", "<rotate z=\"1\" angle=\"30\"/><scale x=\"2\" y=\"1\" z=\"0.5\"/>"),
       Vec3(0), 1.8027756f},
      {shape_xml("sphere", "<scale x=\"2\" y=\"1\" z=\"0.5\"/>",
                 "<point name=\"center\" x=\"1\" y=\"1\" z=\"1\"/>"
                 "<float name=\"radius\" value=\"3\"/>"),
       Vec3(2, 1, 0.5f), 6},
  };
  for (const auto& c : cases) {
    const Aabb bounds = make<Shape>(c.shape)->bounds();
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(bounds.lo[k], c.centre[k] - c.radius, 1e-5f) << c.shape;
      EXPECT_NEAR(bounds.hi[k], c.centre[k] + c.radius, 1e-5f) << c.shape;
    }
  }
}

/// The hits and normals are those of Mitsuba.
TEST(UnevenScale, MakesCylindersEllipticOrOblique) {
  const auto hit = [](const std::string& shape, const Vec3& o, const Vec3& d) {
    const auto scene = scene_from(shape);
    RayHit ray{{}, {}};
    ray.ray.o = o, ray.ray.d = d;
    RenderCounters counters;
    scene->intersect({&ray, 1}, Coherence::kIncoherent, counters);
    return scene->interaction(ray);
  };
  const auto expect_near = [](const Vec3& a, const Vec3& b) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(a[k], b[k], 1e-5f);
  };
  const std::string elliptic = shape_xml("cylinder", "<scale x=\"2\" y=\"1\" z=\"3\"/>");
  const SurfaceInteraction a = hit(elliptic, {1, 10, 0.5f}, {0, -1, 0});
  expect_near(a.p, {1, std::sqrt(0.75f), 0.5f});
  expect_near(a.n, glm::normalize(Vec3(0.25f, std::sqrt(0.75f), 0)));
  const SurfaceInteraction b =
      hit(shape_xml("cylinder", kShear), {10, 0, 0.5f}, {-1, 0, 0});
  expect_near(b.p, {1, 0, 0.5f});
  expect_near(b.n, glm::normalize(Vec3(2, -1, 0)));
}

/// The perimeter of an ellipse with half axes 2 and 1 is 9.68844822. The mean of x² over the area
/// is computed by quadrature. Evenly spaced samples agree except for rounding.
TEST(UnevenScale, LeavesCylindersSampledByArea) {
  const auto shape = make<Shape>(shape_xml("cylinder", "<scale x=\"2\" y=\"1\" z=\"3\"/>"));
  EXPECT_NEAR(shape->area(), 3 * 9.68844822f, 1e-4f);
  double length = 0, expected = 0;
  constexpr int kSteps = 100000;
  for (int k = 0; k < kSteps; ++k) {
    const double phi = 2 * kPi * (k + 0.5) / kSteps;
    const double step = std::hypot(2 * std::sin(phi), std::cos(phi));
    length += step;
    expected += step * 4 * std::cos(phi) * std::cos(phi);
  }
  Moments squares;
  for (uint32_t k = 0; k < 100000; ++k) {
    const Vec2 u((static_cast<float>(k) + 0.5f) / 100000, 0.5f);
    const double x = static_cast<double>(shape->sample_surface(u).p.x);
    squares.add(x * x);
  }
  EXPECT_NEAR(squares.mean(), expected / length, 1e-4);
}

}  // namespace
}  // namespace kinome::test::shapes_test
