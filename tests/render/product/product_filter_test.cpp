/// Product sampling with filters wider than a pixel: samples contribute to all pixels within the
/// filter's radius.
#include "render/paths/path_scenes.h"
#include "product_scenes.h"

namespace kinome::test::product_filter_test {
namespace {

/// A film of 16x12 pixels. Squares of the checkerboards are about three pixels wide, so that light
/// attributed to a wrong position in its pixel changes the neighbouring pixels.
std::string film_of(const std::string& filter) {
  return integer("width", 16) + integer("height", 12) + "<rfilter type=\"" + filter + "\"/>";
}

/// A checkerboard for the parameter `name`. Both colours reflect light, because points that don't
/// would belong to no group of a pixel.
std::string checks(const std::string& name) {
  return "<texture type=\"checkerboard\" name=\"" + name +
         "\"><rgb name=\"color0\" value=\".05 .1 .2\"/><rgb name=\"color1\" "
         "value=\".9 .6 .3\"/><transform name=\"to_uv\"><scale value=\"7\"/></transform></texture>";
}

/// Compares each pixel's expectation with that of `direct` or `path`, which add samples one by one.
void expect_same_pixels(Arrangement s, int renders) {
  s.direct_samples = 64;
  for (const char* const filter : {"gaussian", "mitchell"}) {
    s.film = film_of(filter);
    expect_equal(estimate_tiles(*product_scene(s), renders, 1),
                 estimate_tiles(*direct_scene(s), renders, 1, 5000), kAlpha, filter);
  }
}

TEST(ProductFilter, SkyOnDiffuseChecks) {
  Arrangement s;
  s.shapes = shapes_xml(bsdf("diffuse", checks("reflectance")));
  s.rays = 48;
  expect_same_pixels(s, 128);
}

TEST(ProductFilter, SkyOnGlossyChecks) {
  Arrangement s;
  s.shapes = shapes_xml(bsdf("roughconductor", number("alpha", .2) + checks("specular_reflectance")));
  s.rays = 48;
  expect_same_pixels(s, 128);
}

TEST(ProductFilter, LampAndBounceOnChecks) {
  Arrangement s;
  s.shapes = shapes_xml(bsdf("roughplastic", number("alpha", .2) + checks("diffuse_reflectance")));
  s.light = shape_xml("rectangle",
                      "<scale value=\"1\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"2.5\"/>",
                      area_xml("9 5 2")) +
            point_xml("2,3,2", "3 2 6");
  s.max_depth = 3;
  s.rays = 48;
  expect_same_pixels(s, 128);
}

/// A gaussian filter with a standard deviation of 1/2 averages about 1 / 0.32 = 3 pixels, and
/// reduces independent noise by that factor. Without the neighbours' samples, the noise would be
/// that of a box filter.
TEST(ProductFilter, NeighboursLowerTheNoise) {
  const auto mean_variance = [](const std::string& filter) {
    Arrangement s;
    s.rays = 48;
    s.film = film_of(filter);
    double sum = 0;
    const auto pixels = estimate_pixels(*product_scene(s), 32);
    for (const Estimate& pixel : pixels) sum += pixel.variance_of_mean;
    return sum / static_cast<double>(pixels.size());
  };
  // Each side has a relative deviation of about sqrt(2 / (32 * 100)) = 2.5 %, or below 5 % if
  // pixels share noise.
  EXPECT_LT(mean_variance("gaussian"), 0.5 * mean_variance("box"));
}

}  // namespace
}  // namespace kinome::test::product_filter_test
