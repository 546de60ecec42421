// Product sampling at its discontinuities: horizons, shadow edges, and borders of tiles, of groups
// of points, and of cells. z-tests against `direct` at these positions, each with a false-alarm
// rate of 1e-4.
#include <gtest/gtest.h>

#include "product_scenes.h"

namespace kinome::test::product_places_test {
namespace {

/// Direction to the sun of sun_xml(), column 20.5 of 32 and row 7 of 16, and the point at the
/// image's centre.
const Vec3 kSun(-0.758f, 0.195f, 0.622f);
const Vec3 kMiddle(0, 0.4f, 0);

std::string point(const Vec3& p) {
  return std::to_string(p.x) + "," + std::to_string(p.y) + "," + std::to_string(p.z);
}
std::string sphere(const Vec3& centre, double radius, const std::string& material) {
  return "<shape type=\"sphere\"><point name=\"center\" value=\"" + point(centre) + "\"/>" +
         number("radius", radius) + material + "</shape>";
}
/// A plane through the point at the image's centre.
std::string plane(const Vec3& normal, const std::string& material) {
  return "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/>" +
         look_at(point(kMiddle), point(kMiddle + normal), "0,1,0.1") + "</transform>" + material +
         "</shape>";
}

const std::pair<const char*, std::string> kMaterials[] = {
    {"diffuse", kGrey},
    {"rough plastic", bsdf("roughplastic", number("alpha", .15))},
    {"phong", bsdf("phong", number("exponent", 30))},
    {"metal", metal(.2)},
};

/// Returns a normal that faces the camera at a right angle to the sun: the sun's cells straddle the
/// surface's horizon.
Vec3 grazed_normal() {
  const Vec3 viewer = glm::normalize(Vec3(0, 2, 5) - kMiddle);
  return glm::normalize(viewer - kSun * glm::dot(viewer, kSun) / glm::dot(kSun, kSun));
}

/// Calls expect_unbiased for each number of cells.
void expect_unbiased_with_cells(Arrangement s, std::initializer_list<int> counts, int tile) {
  const auto direct = estimate_tiles(*direct_scene(s), kRenders, tile, 5000);
  for (const int cells : counts) {
    s.parameters = integer("cut_size", cells);
    expect_equal(estimate_tiles(*product_scene(s), kRenders, tile), direct, kAlpha,
                 std::to_string(cells) + " cells");
  }
}

TEST(ProductPlaces, HorizonThroughTheSun) {
  Arrangement s;
  for (const auto& [name, material] : kMaterials) {
    SCOPED_TRACE(name);
    s.shapes = plane(grazed_normal(), material);
    expect_unbiased(s);
  }
}

/// The sun sets within the image: from pixel to pixel, and within each.
TEST(ProductPlaces, SunsetOnASphere) {
  Arrangement s;
  s.optics = number("fov", 20);
  for (const auto& [name, material] : kMaterials) {
    SCOPED_TRACE(name);
    s.shapes = sphere(kMiddle - 3.f * grazed_normal(), 3, material);
    expect_unbiased_with_cells(s, {512, 24}, 2);
  }
}

/// Metal under a small lamp at grazing view. The values that pixels share change between them.
/// First, the mean point's lobe reaches less far than that of others (1 to 8 degrees above the
/// surface). Second, a lobe is as wide as the distance between the points that share it, or isn't.
TEST(ProductPlaces, BordersOfSharedCandidates) {
  Arrangement s;
  s.direct_samples = 64;
  for (const double degrees : {1., 2., 4., 8.}) {
    SCOPED_TRACE(degrees);
    const Vec3 viewer = glm::normalize(Vec3(0, 2, 5) - kMiddle);
    const Vec3 side = glm::normalize(glm::cross(viewer, Vec3(0, 1, 0)));
    const auto angle = static_cast<float>(degrees * kPi / 180);
    const Vec3 normal = glm::cross(side, viewer) * std::cos(angle) + viewer * std::sin(angle);
    s.shapes = plane(normal, metal(.3));
    expect_unbiased(s, 48);
  }
  for (const double alpha : {.02, .05, .1, .2, .4}) {
    SCOPED_TRACE(alpha);
    s.direct_samples = 512;
    s.shapes = sphere(kMiddle, .7, metal(alpha));
    expect_unbiased(s, 160);
  }
}

/// A ball with the sun behind it, which lights its rim. There the normals of a tile differ most,
/// and much of the light that others reflect is below the horizon of the mean point.
TEST(ProductPlaces, RimsThatPixelsShare) {
  Arrangement s;
  s.light = map_xml("behind", 32, 17, harsh,
                    "<rotate y=\"1\" angle=\"230\"/><rotate x=\"1\" angle=\"16\"/>");
  s.optics = number("fov", 12);
  s.rays = 48;
  s.direct_samples = 256;
  for (const double alpha : {.1, .25, .5}) {
    SCOPED_TRACE(alpha);
    s.shapes = sphere(kMiddle + Vec3(-2.9f, 0, 0), 3, metal(alpha));
    expect_unbiased(s, 64);
  }
}

/// The penumbra of a ball is several pixels wide; each pixel is tested.
TEST(ProductPlaces, EdgesOfAShadow) {
  Arrangement s;
  s.optics = number("fov", 10);
  s.direct_samples = 64;
  for (const auto& [name, material] : kMaterials) {
    SCOPED_TRACE(name);
    s.shapes = plane({0, 1, 0}, material) + sphere(kMiddle + kSun, .15, kGrey);
    expect_unbiased(s, kRenders, 1);
  }
}

/// Sums over all pixels at one position in their tile, and over the lines along the borders of the
/// blocks that are a thread's unit of work.
TEST(ProductPlaces, BordersOfTilesAndBlocks) {
  constexpr int kTile = 4, kBlock = 32, kWidth = 38, kHeight = 35;
  Arrangement s;
  s.film = integer("width", kWidth) + integer("height", kHeight) + "<rfilter type=\"box\"/>";
  s.shapes = shapes_xml(bsdf("roughplastic", number("alpha", .1)));
  const auto estimate = [&](const Scene& scene, uint64_t first_seed) {
    std::vector<Moments> moments((kTile * kTile + 4) * 3);
    for (uint64_t seed = first_seed; seed < first_seed + kRenders; ++seed) {
      const Image image = render_scene(scene, seed);
      std::vector<double> sums(moments.size());
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          for (int c = 0; c < 3; ++c) {
            const double value = image.at(x, y, c);
            sums[(y % kTile * kTile + x % kTile) * 3 + c] += value;
            const bool at_border[4] = {x == kBlock - 1, x == kBlock, y == kBlock - 1, y == kBlock};
            for (int k = 0; k < 4; ++k) {
              if (at_border[k]) sums[(kTile * kTile + k) * 3 + c] += value;
            }
          }
        }
      }
      for (size_t i = 0; i < sums.size(); ++i) moments[i].add(sums[i]);
    }
    std::vector<Estimate> estimates;
    for (const Moments& m : moments) estimates.push_back({m.mean(), m.variance_of_mean()});
    return estimates;
  };
  expect_equal(estimate(*product_scene(s), 1), estimate(*direct_scene(s), 5000), kAlpha, "places");
}

/// The lobe is so sharp, and the surface so curved, that a pixel's points exceed the maximum number
/// of groups.
TEST(ProductPlaces, MoreGroupsThanThereMayBe) {
  Arrangement s;
  s.film = integer("width", 3) + integer("height", 2) + "<rfilter type=\"box\"/>";
  s.rays = 400;
  s.direct_samples = 512;
  s.shapes = sphere(kMiddle, 1, metal(.02));
  s.finds = 0.3;
  expect_unbiased(s, kRenders, 1);
}

/// More surfaces in one tile than there may be patches: cubes in all orientations.
TEST(ProductPlaces, MorePatchesThanATileKeeps) {
  Arrangement s;
  s.film = integer("width", 4) + integer("height", 4) + "<rfilter type=\"box\"/>";
  s.rays = 60;
  s.direct_samples = 256;
  s.shapes.clear();
  for (int i = 0; i < 60; ++i) {
    const Vec3 centre(.4 * (i % 8) - 1.4, .3 * (i / 8), .1 * (i % 3));
    s.shapes += "<shape type=\"cube\"><transform name=\"to_world\"><scale value=\".14\"/>" +
                std::string("<rotate x=\"1\" y=\".3\" angle=\"") + std::to_string(37 * i) +
                "\"/><rotate z=\"1\" y=\".2\" angle=\"" + std::to_string(61 * i) +
                "\"/><translate value=\"" + point(centre) + "\"/></transform>" + kGrey + "</shape>";
  }
  expect_unbiased(s, 3 * kRenders / 2, 1);
}

/// Light that changes exactly at borders of cells: along the map's horizon, its seam, and its
/// poles.
TEST(ProductPlaces, BordersOfCells) {
  Arrangement s;
  s.light = map_xml("borders", 32, 17, [](int x, int y) {
    if (y == 8) return Rgb(20, 10, 5);
    if (x == 0 || x == 31) return Rgb(5, 10, 20);
    return y < 2 || y > 14 ? Rgb(8, 8, 2) : Rgb(0.1f);
  });
  s.direct_samples = 64;
  for (const auto& [name, material] : kMaterials) {
    SCOPED_TRACE(name);
    s.shapes = sphere(kMiddle, 1.2, material);
    expect_unbiased_with_cells(s, {512, 40}, 4);
  }
  s.shapes = sphere(kMiddle, 1.2, metal(.03));
  expect_unbiased(s);
}

}  // namespace
}  // namespace kinome::test::product_places_test
