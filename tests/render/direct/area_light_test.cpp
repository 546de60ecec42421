#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "direct_scenes.h"
#include "kinome/image_files.h"
#include "render/direct/local_light.h"

/// Tests the irradiance of emitting surfaces against closed forms.
namespace kinome::test::area_light_test {
namespace {

using namespace local_light;

std::string area_xml(const std::string& shape, const std::string& transform,
                     const std::string& emitter = "<rgb name=\"radiance\" value=\"1 2 3\"/>") {
  return "<shape type=\"" + shape + "\"><transform name=\"to_world\">" + transform +
         "</transform><emitter type=\"area\">" + emitter + "</emitter></shape>";
}

/// Tests the image of the floor at (x, z) under an area light with a known irradiance at radiance
/// 1, with emitter samples, BSDF samples and both.
void expect_area_irradiance(const std::string& light, float x, float z, double expected,
                            const std::string& name) {
  const auto shown = static_cast<float>(kAlbedo * expected / kPiD);
  for (const auto& [emitter, bsdf] : {std::pair{1, 1}, {1, 0}, {0, 1}, {2, 3}}) {
    const auto scene = scene_from(floor_at(x, z) + light + direct_xml(samples_xml(emitter, bsdf)));
    // BSDF samples alone rarely find a small emitter.
    const int renders = emitter == 0 ? 8 * kRenders : kRenders;
    expect_equal(estimate_pixels(*scene, renders), exactly(shown * Rgb(1, 2, 3), 9), kAlpha,
                 name + ", " + std::to_string(emitter) + " + " + std::to_string(bsdf));
  }
}

/// Form factor of a rectangle by Lambert's sum over its edges, seen from the origin with the normal
/// +y. The rectangle is entirely above the horizon.
double polygon_irradiance(const std::vector<glm::dvec3>& corners) {
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 a = glm::normalize(corners[i]);
    const glm::dvec3 b = glm::normalize(corners[(i + 1) % corners.size()]);
    sum += std::acos(glm::dot(a, b)) * glm::normalize(glm::cross(a, b)).y;
  }
  return std::abs(sum) / 2;
}

TEST(LocalLight, RectangleIsLambertsSum) {
  // Turned down by 110 degrees about x, then moved.
  const double angle = 110 * kPiD / 180;
  for (const auto& [x, z] : {std::pair{0.f, 0.f}, {0.8f, 0.5f}, {-2.f, 1.f}}) {
    std::vector<glm::dvec3> corners;
    for (const auto& [u, v] : {std::pair{-1., -1.}, {1., -1.}, {1., 1.}, {-1., 1.}}) {
      const double y = 0.5 * v;
      corners.push_back({u - x, y * std::cos(angle) + 1.5, y * std::sin(angle) - 0.7 - z});
    }
    expect_area_irradiance(area_xml("rectangle",
                                    "<scale x=\"1\" y=\".5\"/><rotate x=\"1\" angle=\"110\"/>"
                                    "<translate value=\"0 1.5 -.7\"/>"),
                           x, z, polygon_irradiance(corners), "rectangle");
  }
}

/// Form factor of a parallel disk of radius r above, at height h and offset d: pi / 2 (1 - (d² + h²
/// - r²) / sqrt((d² + h² + r²)² - 4 r² d²)) (Howell, Catalog of radiation heat transfer
/// configuration factors, B-13).
TEST(LocalLight, DiskIsItsFormFactor) {
  const double radius = 0.6, height = 1.2;
  for (const float offset : {0.f, 0.4f, 1.5f}) {
    const double d = offset, sum = d * d + height * height;
    const double expected =
        kPiD / 2 *
        (1 - (sum - radius * radius) /
                 std::sqrt(std::pow(sum + radius * radius, 2) - 4 * radius * radius * d * d));
    expect_area_irradiance(area_xml("disk",
                                    "<scale value=\".6\"/><rotate x=\"1\" angle=\"90\"/>"
                                    "<translate y=\"1.2\"/>"),
                           offset, 0, expected, "disk at " + std::to_string(offset));
  }
}

/// Form factor of a sphere above the horizon: pi (R / D)² cos(theta), near and far.
TEST(LocalLight, SphereIsItsFormFactor) {
  for (const auto& [radius, height] : {std::pair{0.5, 2.}, {0.5, 0.8}, {0.01, 30.}, {40., 40.25}}) {
    const float x = height > 3 * radius ? 1.3f : 0.f;
    const double distance2 = height * height + static_cast<double>(x * x);
    const double expected = kPiD * radius * radius / distance2 * height / std::sqrt(distance2);
    if (radius == 0.01) {  // too small for BSDF samples
      const auto scene =
          scene_from(floor_at(x, 0) + direct_xml(samples_xml(1, 0)) +
                     area_xml("sphere", "<scale value=\".01\"/><translate y=\"30\"/>"));
      expect_equal(estimate_pixels(*scene, kRenders),
                   exactly(static_cast<float>(kAlbedo * expected / kPiD) * Rgb(1, 2, 3), 9), kAlpha,
                   "small sphere");
      continue;
    }
    expect_area_irradiance(
        area_xml("sphere", "<scale value=\"" + std::to_string(radius) + "\"/><translate y=\"" +
                               std::to_string(height) + "\"/>"),
        x, 0, expected, "sphere of radius " + std::to_string(radius));
  }
}

/// Inside a sphere that emits inward, all points receive the same irradiance.
TEST(LocalLight, SphereAroundEverythingIsAnEvenSky) {
  const std::string light =
      "<shape type=\"sphere\"><boolean name=\"flip_normals\" value=\"true\"/><float "
      "name=\"radius\" "
      "value=\"90\"/><emitter type=\"area\"><rgb name=\"radiance\" value=\"1 2 3\"/></emitter>"
      "</shape>";
  expect_area_irradiance(light, 20, 5, kPiD, "sky");
}

/// A rectangle that faces away is dark, and black to the camera from behind. Its front shows its
/// radiance and reflects nothing.
TEST(LocalLight, AreaLightIsOneSided) {
  const auto away = scene_from(floor_at(0, 0) + direct_xml() +
                               area_xml("rectangle",
                                        "<rotate x=\"1\" angle=\"-90\"/>"
                                        "<translate y=\"1\"/>"));
  for (const Estimate& value : estimate_pixels(*away, 2)) EXPECT_EQ(value.mean, 0);
  for (const bool front : {true, false}) {
    const auto scene =
        scene_from(area_xml("rectangle", front ? "" : "<rotate y=\"1\" angle=\"180\"/>") +
                   direct_xml() + constant_xml("1") +
                   sensor_xml("orthographic",
                              "<scale value=\".1\"/>" + look_at("0 0 4", "0 0 0", "0 1 0"), 3, 4));
    const Image image = render_scene(*scene);
    for (int c = 0; c < 3; ++c) EXPECT_EQ(image.at(1, 1, c), front ? 1 + c : 0) << c;
  }
}

/// An emitter with a texture that is half black. The other half has the closed form of its own
/// rectangle.
TEST(LocalLight, AreaLightHasATexture) {
  const TemporaryFolder folder;
  Image image{2, 1, {"R", "G", "B"}, {1, 2, 3, 0, 0, 0}};
  write_pfm(folder.path("image.pfm"), image);
  const std::vector<glm::dvec3> left = {{-1, 1, -1}, {0, 1, -1}, {0, 1, 1}, {-1, 1, 1}};
  expect_area_irradiance(area_xml("rectangle", "<rotate x=\"1\" angle=\"90\"/><translate y=\"1\"/>",
                                  nearest_xml("radiance", folder.path("image.pfm"))),
                         0, 0, polygon_irradiance(left), "left half");
}

/// All kinds together: the sum of the images with each of them.
TEST(LocalLight, EmittersAddUp) {
  const std::vector<std::string> lights = {
      light_xml("point", "<translate y=\"2\"/>", ""),
      light_xml("spot", kDown, "<float name=\"intensity\" value=\"2\"/>"),
      light_xml("projector", kDown, number_xml("fov", 40)),
      light_xml("directional", "<rotate x=\"1\" angle=\"60\"/>", ""),
      area_xml("rectangle",
               "<scale value=\".3\"/><rotate x=\"1\" angle=\"110\"/>"
               "<translate value=\"1 1 -1\"/>"),
      constant_xml("0.1 0.2 0.3")};
  std::string all;
  std::vector<Estimate> sum(27);
  const auto rendered = [&](const std::string& light, uint64_t seed) {
    return estimate_pixels(
        *scene_from(floor_at(0.1f, 0.2f) + light + direct_xml(samples_xml(4, 1))), kRenders, seed);
  };
  // The area light hides part of the sky: both are rendered together.
  for (size_t i = 0; i < lights.size(); ++i) {
    all += lights[i];
    if (i == 4) continue;
    const std::string light = i == 5 ? lights[4] + lights[5] : lights[i];
    const auto one = rendered(light, 1000 * (i + 1));
    for (size_t k = 0; k < sum.size(); ++k) {
      sum[k].mean += one[k].mean;
      sum[k].variance_of_mean += one[k].variance_of_mean;
    }
  }
  expect_equal(rendered(all, 90001), sum, kAlpha, "all");
}

}  // namespace
}  // namespace kinome::test::area_light_test
