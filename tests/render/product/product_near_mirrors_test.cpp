#include <gtest/gtest.h>

#include <numeric>

#include "kinome/image_files.h"
#include "render/paths/path_scenes.h"
#include "product_scenes.h"
#include "render/product/product_local.h"

/// Product sampling under local light: near-mirrors, caustics and settings.
namespace kinome::test::product_near_mirrors_test {
namespace {

using namespace product_local;

/// Seen in a mirror, which is the wall.
Case narrow_in_a_mirror(const std::string& lamp) {
  Case c = lit_by("NarrowInAMirror", lamp, 3);
  c.setup.rays = 48;
  c.setup.shapes =
      shapes_xml(bsdf("roughplastic", number("alpha", .03))) +
      shape_xml("rectangle", "<scale value=\"6\"/><translate z=\"-2\"/>", bsdf("conductor"));
  return c;
}

/// Light reflected by a lobe too narrow for light points, unless it comes from lamps.
std::vector<Case> near_mirrors() {
  const auto made_of = [](const char* name, const std::string& light, const std::string& material) {
    Case c = lit_by(name, light, 3, material);
    c.setup.rays = 48;
    c.setup.direct_samples = 64;
    return c;
  };
  // Light of small emitters comes by so few paths that the reference may miss all of them.
  const std::string lamp = shape_xml(
      "rectangle", "<scale value=\"1.5\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"2.5\"/>",
      area_xml("6 5 4"));
  const std::string anisotropic =
      bsdf("roughconductor", number("alpha_u", 1e-4) + number("alpha_v", .5));
  // Light that a floor reflects to a diffuse wall.
  Case wall = made_of("WallByNarrowLobes", lamp, "");
  wall.setup.shapes =
      shape_xml("rectangle", "<scale value=\"5\"/><rotate x=\"1\" angle=\"-90\"/>", metal(.02)) +
      shape_xml("rectangle", "<scale value=\"5\"/><translate z=\"-1\"/>", kGrey);
  wall.setup.rays = 192;
  const auto plastic = [](const std::string& more) {
    return bsdf("roughplastic", number("alpha", .03) + more);
  };
  return {
      wall,
      made_of("NearMirror", lamp, metal(1e-4)),
      made_of("NearMirrorUnderTheSky", sun_xml(), metal(1e-4)),
      made_of("NearMirrorAlongOneAxis", lamp, anisotropic),
      // On either side of the limit for light points.
      made_of("NotQuiteNearMirror", lamp, metal(.014)),
      made_of("JustNearMirror", lamp, metal(.012)),
      made_of("NearMirrorOverDiffuse", lamp + kPoint, bsdf("roughplastic", number("alpha", .004))),
      made_of("SharpPhong", lamp, bsdf("phong", number("exponent", 1e5))),
      made_of("NarrowOverDiffuse", lamp + kPoint, plastic("")),
      // A lobe that is black in places but still has a density.
      made_of("NarrowOfCheckers", lamp, plastic(checkerboard("specular_reflectance"))),
      made_of("NarrowOfTwoSides", lamp, bsdf("twosided", metal(.02))),
      made_of("NarrowUnderTheSky", sun_xml(), metal(.03)),
      narrow_in_a_mirror(lamp),
  };
}
INSTANTIATE_TEST_SUITE_P(NearMirrors, Local, testing::ValuesIn(near_mirrors()), name_of);

/// Light of lamps that reaches the floor by way of a mirror beside the image.
Case caustic(const char* name, const std::string& light, const std::string& mirror) {
  Case c = lit_by(name, light, 3);
  c.setup.shapes =
      shapes_xml(kGrey) + shape_xml("rectangle",
                                    "<scale value=\"1.5\"/><rotate y=\"1\" angle=\"-90\"/>"
                                    "<translate x=\"3\" y=\"1.5\" z=\"1.5\"/>",
                                    mirror);
  c.setup.bounces = "ptracer";
  c.setup.rays = 96;
  c.setup.direct_samples = 256;
  return c;
}
std::vector<Case> caustics() {
  Case thin_lens = caustic("ByAThinLens", kPoint, bsdf("conductor"));
  thin_lens.setup.sensor = "thinlens";
  thin_lens.setup.optics += number("aperture_radius", .1) + number("focus_distance", 5);
  Case gaussian = caustic("OfAGaussianFilter", kPoint, bsdf("conductor"));
  gaussian.setup.film = integer("width", 16) + integer("height", 12);
  return {
      caustic("OfAPoint", kPoint, bsdf("conductor")),
      caustic("OfTwoLampsAndPlastic", kSpot + kPoint, bsdf("plastic")),
      caustic("OfParallelLight", kDirectional, bsdf("twosided", bsdf("conductor"))),
      caustic("OfANearMirror", kPoint, metal(1e-3)),
      caustic("OfAJustNearMirror", kPoint, metal(.012)),
      caustic("OfANearMirrorOverDiffuse", kPoint, bsdf("roughplastic", number("alpha", .004))),
      thin_lens,
      gaussian,
  };
}
INSTANTIATE_TEST_SUITE_P(Caustics, Local, testing::ValuesIn(caustics()), name_of);

std::vector<Case> settings() {
  std::vector<Case> all;
  const auto parameter = [&](const char* name, const std::string& xml) {
    Case c = lit_by(name, kSpot + kLamp + sun_xml(), 3);
    c.setup.parameters = xml;
    all.push_back(c);
  };
  parameter("NoControlVariate", off("control_variate"));
  parameter("NoLearnedSigma", off("learned_sigma"));
  parameter("NotAdaptive", off("adaptive"));
  parameter("NotGuided", off("light_guide"));
  parameter("OneCell", integer("cut_size", 1));
  for (const auto& [name, rays] : {std::pair("Rays2", 2.), {"Rays6", 6.}, {"Rays48", 48.}}) {
    Case c = lit_by(name, kSpot + kLamp, 3, bsdf("roughplastic", number("alpha", .2)));
    c.setup.rays = rays;
    all.push_back(c);
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Settings, Local, testing::ValuesIn(settings()), name_of);

/// Variance of the sum over all tiles, in 16 renders.
double total_variance(const Arrangement& setup) {
  double sum = 0;
  for (const Estimate& tile : estimate_tiles(*product_scene(setup), 16, 2))
    sum += tile.variance_of_mean;
  return sum;
}

/// The remaining noise of a pass with many rays is that of its light points, and each pass draws
/// new ones. The variance of 8 passes is an eighth of that of one. With shared points it would
/// hardly fall. If at least 16 tiles matter equally, the limit of a quarter is 5 standard
/// deviations away.
TEST(LocalPasses, DrawPointsOfTheirOwn) {
  Arrangement setup = corner("Passes", "").setup;
  setup.film = integer("width", 12) + integer("height", 12) + "<rfilter type=\"box\"/>";
  setup.rays = 512;
  const double one = total_variance(setup);
  setup.rays = 8 * 512;
  const double eight = total_variance(setup);
  EXPECT_LT(eight, one / 4);
}

}  // namespace
}  // namespace kinome::test::product_near_mirrors_test
