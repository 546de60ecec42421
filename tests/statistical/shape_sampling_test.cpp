/// Tests of points sampled on shapes: uniform by area, and as seen from other points.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <glm/gtc/matrix_transform.hpp>

#include "direction_test.h"
#include "shape_cells.h"

namespace kinome::test::shape_sampling_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 80 tests
constexpr double kPiD = std::numbers::pi;

std::string shape_xml(const std::string& type, const glm::mat4& to_world) {
  std::string numbers;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      numbers += " " + std::to_string(to_world[column][row]);
    }
  }
  return "<shape type='" + type + "'><transform name='to_world'><matrix value='" + numbers +
         "'/></transform></shape>";
}

/// Returns transforms that scale all areas of a shape by the same factor.
std::vector<glm::mat4> transforms_of(const std::string& type) {
  const glm::mat4 one(1.f);
  std::vector<glm::mat4> all = {
      one,
      glm::translate(one, {100, -7, 3}) * glm::rotate(one, 1.3f, {1, 2, -1}) *
          glm::scale(one, Vec3(3)),
      glm::rotate(one, 0.5f, {0, 1, 0}) * glm::scale(one, {-.1f, .1f, .1f}),
  };
  const bool is_flat = type == "disk" || type == "rectangle";
  if (is_flat) all.push_back(glm::rotate(one, 0.9f, {1, 0, 0}) * glm::scale(one, {5, .2f, 3}));
  if (type == "cylinder") all.push_back(glm::scale(one, {.5f, .5f, 9}));
  return all;
}

class EachShape : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(All, EachShape,
                         testing::Values("sphere", "disk", "rectangle", "cube", "cylinder"),
                         [](const auto& test) { return test.param; });

TEST_P(EachShape, IsSampledUniformlyByArea) {
  const ShapeCells& grid = shape_cells().at(GetParam());
  constexpr int kCount = 50000;
  for (const glm::mat4& to_world : transforms_of(GetParam())) {
    const auto shape = make<Shape>(shape_xml(GetParam(), to_world));
    const glm::dmat4 to_object = glm::inverse(glm::dmat4(to_world));
    std::vector<double> observed(static_cast<size_t>(grid.count));
    Random random(31);
    for (int i = 0; i < kCount; ++i) {
      const SurfaceInteraction si = shape->sample_surface({random.unit(), random.unit()});
      observed[grid.cell(Vec3(to_object * glm::dvec4(si.p, 1)))] += 1;
    }
    const std::vector<double> expected(observed.size(), double{kCount} / grid.count);
    const Verdict verdict = chi2_test(observed, expected, kAlpha);
    EXPECT_TRUE(verdict.passed) << shape_xml(GetParam(), to_world) << ": " << verdict.text;
  }
}

/// A ray to a sampled point finds the same values as the sample contains.
TEST_P(EachShape, SampledPointsLieOnIt) {
  for (const glm::mat4& to_world : transforms_of(GetParam())) {
    const std::string xml = shape_xml(GetParam(), to_world);
    const auto scene = scene_from(xml);
    const Shape& shape = *scene->shapes()[0];
    const float size = glm::length(scene->bounds().extent());
    Random random(32);
    int found = 0;
    for (int i = 0; i < 1000; ++i) {
      const SurfaceInteraction si = shape.sample_surface({random.unit(), random.unit()});
      ASSERT_EQ(si.shape, &shape);
      const RayHit hit = trace(*scene, si.p + si.n * (0.05f * size), -si.n);
      ASSERT_TRUE(hit.hit.valid()) << xml;
      const SurfaceInteraction at = scene->interaction(hit);
      if (glm::dot(at.n, si.n) < 0.5f) continue;  // an edge
      ++found;
      ASSERT_LT(glm::length(at.p - si.p), 1e-6f * size + 2 * si.p_error) << xml;
      ASSERT_LT(glm::length(at.n - si.n), 1e-3f) << xml;
      ASSERT_LT(glm::length(at.frame.n - si.frame.n), 1e-3f) << xml;
    }
    EXPECT_GT(found, 990) << xml;
  }
}

/// Columns and rows of the unit square map to those of the rectangle, which preserves strata.
TEST(RectangleSampling, PositionsMatchTheSquare) {
  for (const bool flipped : {false, true}) {
    const auto shape =
        make<Shape>(std::string("<shape type='rectangle'><boolean name='flip_normals' "
                                "value='") +
                    (flipped ? "true" : "false") + "'/></shape>");
    Random random(35);
    for (int i = 0; i < 1000; ++i) {
      const Vec2 u(random.unit(), random.unit());
      const SurfaceInteraction si = shape->sample_surface(u);
      ASSERT_NEAR(si.p.x, 2 * u.x - 1, 1e-6f);
      ASSERT_NEAR(si.p.y, 2 * u.y - 1, 1e-6f);
      ASSERT_NEAR(si.uv.x, u.x, 1e-6f);
      ASSERT_NEAR(si.uv.y, u.y, 1e-6f);
    }
  }
}

/// Tests triangles of very different sizes, some of them degenerate.
TEST(MeshSampling, IsUniformByArea) {
  const TemporaryFolder folder;
  // From x = 0 to 1: strips [0, .01], [.01, .3], [.3, .3], [.3, 1] between y = 0 and 1.
  const std::string path = folder.write("mesh.obj",
                                        "v 0 0 0\nv 0 1 0\nv .01 0 0\nv .01 1 0\nv .3 0 0\n"
                                        "v .3 1 0\nv 1 0 0\nv 1 1 0\n"
                                        "f 1 3 2\nf 3 4 2\nf 5 6 5\nf 3 5 4\nf 5 6 4\n"
                                        "f 5 7 6\nf 7 8 6\n");
  const auto shape =
      make<Shape>("<shape type='obj'><string name='filename' value='" + path + "'/></shape>");
  constexpr int kCount = 100000, kSide = 16;
  std::vector<double> observed(kSide * kSide);
  Random random(33);
  for (int i = 0; i < kCount; ++i) {
    const SurfaceInteraction si = shape->sample_surface({random.unit(), random.unit()});
    ASSERT_EQ(si.p.z, 0);
    ASSERT_NE(si.primitive, 2u);
    observed[part(si.p.x, kSide) * kSide + part(si.p.y, kSide)] += 1;
  }
  const std::vector<double> expected(observed.size(), double{kCount} / (kSide * kSide));
  const Verdict verdict = chi2_test(observed, expected, kAlpha);
  EXPECT_TRUE(verdict.passed) << verdict.text;
}

TEST(MeshSampling, NothingIsSeenOfAMeshWithoutArea) {
  const TemporaryFolder folder;
  const std::string path = folder.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  const auto shape = make<Shape>("<shape type='obj'><string name='filename' value='" + path +
                                 "'/><emitter type='area'/></shape>");
  Random random(34);
  for (int i = 0; i < 1000; ++i) {
    const Vec2 u(random.unit(), random.unit());
    EXPECT_TRUE(is_finite(shape->sample_surface(u).p));
    EXPECT_FALSE(shape->sample_solid_angle(random.direction(), u));
    EXPECT_FALSE(shape->emitter()->sample_direct(random.direction(), u));
    EXPECT_FALSE(shape->emitter()->sample_emission(u, u));
  }
}

// ---- a sphere, as seen from a point ----

struct SphereView {
  Vec3 centre;
  float radius;
  float distance;  ///< distance of the point from the centre, in radii
};

std::vector<SphereView> sphere_views() {
  std::vector<SphereView> views;
  for (const auto& [centre, radius] : {std::pair{Vec3(0.f), 1.f},
                                       {Vec3(3, -2, 5), 0.25f},
                                       {Vec3(0.f), 1e5f},
                                       {Vec3(0.f), 1e-5f}}) {
    for (const float distance :
         {0.f, 1e-4f, 0.5f, 0.99f, 1 - 1e-4f, 1.f, 1 + 1e-4f, 1.01f, 2.f, 100.f, 1e4f}) {
      views.push_back({centre, radius, distance});
    }
  }
  return views;
}

std::string sphere_xml(const SphereView& view) {
  char text[256];
  std::snprintf(text, sizeof text,
                "<shape type='sphere'><point name='center' value='%g %g %g'/>"
                "<float name='radius' value='%g'/></shape>",
                view.centre.x, view.centre.y, view.centre.z, view.radius);
  return text;
}

/// Samples are uniform over the visible solid angle, with an exact density, at every distance.
TEST(SphereSampling, IsUniformOverTheVisiblePart) {
  constexpr int kCount = 40000, kRings = 8, kSectors = 12;
  for (const SphereView& view : sphere_views()) {
    const auto shape = make<Shape>(sphere_xml(view));
    const glm::dvec3 centre(view.centre);
    const double radius = view.radius;
    Random random(35);
    const Vec3 p = view.centre + view.radius * view.distance * random.direction();
    const double distance = glm::length(glm::dvec3(p) - centre);
    const bool is_inside = distance <= radius;
    // 1 - cos of the cone's half angle.
    const double sine = radius / distance;
    const double height = is_inside ? 2 : sine * sine / (1 + std::sqrt(1 - sine * sine));
    const glm::dvec3 axis =
        distance > 0 ? (centre - glm::dvec3(p)) / distance : glm::dvec3(0, 0, 1);
    const Frame frame = Frame::from_normal(Vec3(axis));
    std::vector<double> observed(kRings * kSectors);
    int count = 0;
    for (int i = 0; i < kCount; ++i) {
      const auto sample = shape->sample_solid_angle(p, {random.unit(), random.unit()});
      const std::string where = sphere_xml(view) + " from " + std::to_string(view.distance);
      if (!sample) continue;
      ++count;
      const SurfaceInteraction& si = sample->si;
      ASSERT_NEAR(sample->pdf * 2 * kPiD * height, 1, 1e-5) << where;
      ASSERT_NEAR(shape->pdf_solid_angle(p, si) / sample->pdf, 1, 1e-6) << where;
      const glm::dvec3 radial = glm::dvec3(si.p) - centre;
      ASSERT_NEAR(glm::length(radial), radius, 2 * si.p_error) << where;
      ASSERT_NEAR(glm::length(glm::dvec3(si.n) - radial / radius), 0, 2e-6 + si.p_error / radius)
          << where;
      const glm::dvec3 to = glm::dvec3(si.p) - glm::dvec3(p);
      const double length = glm::length(to);
      // From outside, the near side is sampled.
      if (!is_inside) {
        ASSERT_LT(glm::dot(to, radial), 4 * si.p_error * (radius + length)) << where;
      }
      // The direction to a point within its own rounding error is undefined.
      const double across2 = length * length - std::pow(glm::dot(to, axis), 2);
      const double depth = glm::dot(to, axis) > 0 && across2 < 1e-4 * length * length
                               ? across2 / (length * length) / 2  // 1 - cos for narrow cones
                               : 1 - glm::dot(to, axis) / length;
      const double phi = turn(glm::dot(to, glm::dvec3(frame.s)), glm::dot(to, glm::dvec3(frame.t)));
      observed[part(depth / height, kRings) * kSectors + part(phi, kSectors)] += 1;
    }
    EXPECT_GE(count, kCount / 2 - 600) << view.distance;
    if (!is_inside || distance < 0.999 * radius) {
      EXPECT_EQ(count, kCount) << view.distance;
    }
    // Closer to the surface, rounding of the sampled points changes the directions. There only the
    // densities are tested.
    const double error = 4e-7 * max_component(glm::abs(p));
    if (std::abs(distance - radius) < 100 * error) continue;
    const std::vector<double> expected(observed.size(), double(count) / (kRings * kSectors));
    const Verdict verdict = chi2_test(observed, expected, kAlpha);
    EXPECT_TRUE(verdict.passed) << sphere_xml(view) << " from " << view.distance << ": "
                                << verdict.text;
  }
}

/// Tests the directions of each shape's points against the sum of the densities of all points in
/// that direction.
TEST_P(EachShape, IsSampledByItsDensityPerSolidAngle) {
  const glm::mat4 one(1.f);
  const glm::mat4 to_world =
      glm::translate(one, {.3f, -.2f, .1f}) * glm::rotate(one, 0.7f, {1, 2, 2});
  const auto scene = scene_from(shape_xml(GetParam(), to_world));
  const Shape& shape = *scene->shapes()[0];
  // Seen edge on, a curved surface sampled by area has a density with infinite variance. A cylinder
  // is therefore seen from within its radius.
  std::vector<Vec3> places = {{.4f, -.1f, .3f}, {.3f, .5f, -1.8f}, {-.1f, .6f, 4}};
  if (GetParam() != "cylinder") places.insert(places.end(), {{1.5f, .5f, -1.8f}, {-8, 3, 2}});
  for (const Vec3& place : places) {
    const Vec3 p(to_world * glm::vec4(place, 1));
    DirectionTest directions;
    directions.sample = [&](Vec2 u) -> std::optional<Vec3> {
      const auto sample = shape.sample_solid_angle(p, u);
      if (!sample) return std::nullopt;
      return glm::normalize(sample->si.p - p);
    };
    directions.pdf = [&](const Vec3& d) {
      return density_along(
          *scene, p, d, [&](const SurfaceInteraction& si) { return shape.pdf_solid_angle(p, si); });
    };
    aim_at(directions, p, scene->bounds());
    const Verdict verdict = direction_test(directions, kAlpha);
    EXPECT_TRUE(verdict.passed) << "from " << place.x << ": " << verdict.text;
  }
}

}  // namespace
}  // namespace kinome::test::shape_sampling_test
