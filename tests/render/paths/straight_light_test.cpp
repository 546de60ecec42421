/// Light that passes straight through surfaces (panes, masks). Compares `path`, whose emitter
/// samples pass them, too, with path tracing by BSDF samples alone, and `clustered`, whose shadow
/// rays and light points pass them, with `path`.
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <tuple>

#include "path_scenes.h"
#include "support/bsdf_cases.h"

namespace kinome::test::straight_light_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 300 z-tests

constexpr int kSide = 4;  // pixels

/// Path tracing by BSDF samples alone. With max_depth -1, roulette ends paths.
class PlainPaths {
 public:
  PlainPaths(const Scene& scene, int max_depth) : scene_(scene), max_depth_(max_depth) {}

  /// Sum of the pixels, because a single pixel has too few of the rare paths to a lamp.
  std::vector<Estimate> sum(int samples) const {
    constexpr double kPixels = kSide * kSide;
    std::array<Moments, 3> moments;
    RandomDirections random(7);
    for (int i = 0; i < samples; ++i) {
      const Vec2 position = static_cast<float>(kSide) * random.unit2();
      const Rgb light =
          radiance(scene_.sensors().front()->sample_ray(position, random.unit2()), random);
      for (int c = 0; c < 3; ++c) moments[static_cast<size_t>(c)].add(kPixels * double{light[c]});
    }
    std::vector<Estimate> all;
    for (const Moments& m : moments) all.push_back({m.mean(), m.variance_of_mean()});
    return all;
  }

 private:
  Rgb radiance(Ray ray, RandomDirections& random) const {
    Rgb sum(0.f), throughput(1.f);
    RenderCounters counters;
    for (int depth = 1; max_depth_ < 0 || depth <= max_depth_; ++depth) {
      RayHit hit{ray, Hit{}};
      scene_.intersect({&hit, 1}, Coherence::kIncoherent, counters);
      if (!hit.hit.valid()) {
        const Emitter* const sky = scene_.environment();
        return sky ? sum + throughput * sky->eval_environment(ray.d) : sum;
      }
      const SurfaceInteraction si = scene_.interaction(hit);
      if (si.shape->emitter()) sum += throughput * si.shape->emitter()->eval_surface(si);
      const float u1 = random.unit();
      const auto sample = si.shape->bsdf().sample(si, Lobe::kAll, u1, random.unit2());
      if (!sample || is_black(sample->weight)) return sum;
      throughput *= sample->weight;
      if (depth > 6) {
        if (random.unit() >= 0.7f) return sum;
        throughput /= 0.7f;
      }
      ray = Ray{};
      ray.d = si.frame.to_world(sample->wo);
      ray.o = si.ray_origin(ray.d);
    }
    return sum;
  }

  const Scene& scene_;
  const int max_depth_;
};

struct Part {
  const char* name;
  std::string xml;
};

const std::string kPane =
    "<bsdf type=\"thindielectric\"><rgb name=\"specular_transmittance\" "
    "value=\"0.9 0.6 0.3\"/></bsdf>";
const std::string kLeaf = "<bsdf type=\"twosided\">" + diffuse_xml("0.2 0.7 0.1") + "</bsdf>";

std::string mask(const std::string& opacity, const std::string& nested) {
  return "<bsdf type=\"mask\">" + opacity + nested + "</bsdf>";
}
std::string uniform(const char* value) {
  return std::string("<float name=\"opacity\" value=\"") + value + "\"/>";
}
std::string checkers(const char* a, const char* b) {
  return std::string(
             "<texture type=\"checkerboard\" name=\"opacity\"><float name=\"color0\" "
             "value=\"") +
         a + "\"/><float name=\"color1\" value=\"" + b +
         "\"/><transform name=\"to_uv\"><scale value=\"3\"/></transform></texture>";
}

/// A wide horizontal surface, slightly tilted.
std::string sheet(const std::string& bsdf, const std::string& y = "0.8") {
  return shape_xml(
      "rectangle",
      "<scale value=\"1.2\"/><rotate x=\"1\" angle=\"80\"/><translate y=\"" + y + "\"/>", bsdf);
}

std::vector<Part> sheets() {
  return {
      {"pane", sheet(kPane)},
      {"two panes", sheet(kPane) + sheet(kPane, "1.1")},
      {"null", sheet("<bsdf type=\"null\"/>")},
      {"coloured mask", sheet(mask(uniform("0.4"), kLeaf))},
      {"leaf texture", sheet(mask(checkers("0", "1"), kLeaf))},
      {"two leaves",
       sheet(mask(checkers("0.2", "0.9"), kLeaf)) + sheet(mask(checkers("0", "1"), kLeaf), "1.1")},
      {"masked pane", sheet(mask(uniform("0.3"), kPane))},
      {"blend", sheet("<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.5\"/>" + kPane +
                      kLeaf + "</bsdf>")},
      {"lamp in a box of panes",
       shape_xml("cube",
                 "<scale value=\"1.1\"/><rotate z=\"1\" angle=\"12\"/><translate "
                 "y=\"1.7\"/>",
                 kPane)},
      {"emitting mask", shape_xml("rectangle",
                                  "<scale value=\"0.6\"/><rotate x=\"1\" angle=\"90\"/><translate "
                                  "y=\"0.9\"/>",
                                  mask(uniform("0.5"), kLeaf) + area_xml("1 2 3"))},
      {"pane behind glass", sheet(kPane) + sheet("<bsdf type=\"dielectric\"/>", "1.1")},
  };
}
std::vector<Part> lights() {
  return {
      {"lamp", shape_xml("rectangle", "<rotate x=\"1\" angle=\"90\"/><translate y=\"1.6\"/>",
                         area_xml("9 6 3"))},
      {"sky", constant_xml("1 2 3")},
      {"sky and ball", constant_xml("0.5 0.5 0.5") +
                           "<shape type=\"sphere\"><point name=\"center\" x=\"0.2\" y=\"1.6\" "
                           "z=\"0.1\"/><float name=\"radius\" value=\"0.4\"/>" +
                           area_xml("9 6 3") + "</shape>"},
  };
}
/// A view of the floor and of the back of the sheet.
std::string view(int samples) {
  return sensor_xml("perspective", look_at("0 0.6 2", "0 0.3 0", "0 1 0"), kSide, samples);
}
std::string floor_and_ball() {
  return floor_xml(diffuse_xml("0.5")) +
         shape_xml("sphere", "<scale value=\"0.25\"/><translate x=\"0.3\" y=\"0.25\"/>",
                   "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.2\"/></bsdf>");
}

void expect_path_is_plain(const Part& part, const Part& light, int depth) {
  const auto scene = scene_from(floor_and_ball() + part.xml + light.xml +
                                integrator_xml("path", depth, rr_depth_xml(4)) + view(64));
  const auto plain = PlainPaths(*scene, depth).sum(100000);
  expect_equal(plain, estimate_tiles(*scene, kRenders, kSide), kAlpha,
               std::string(part.name) + ", " + light.name + ", depth " + std::to_string(depth));
}

/// Paths of any length contain the shorter ones; a sky with a ball contains both kinds of light.
TEST(StraightLight, EqualsPathsByBsdfSamplesAlone) {
  for (const Part& part : sheets()) {
    expect_path_is_plain(part, lights().at(0), 2);
    for (const size_t light : {0u, 2u}) expect_path_is_plain(part, lights().at(light), -1);
  }
}
/// Tests each length and each light by itself.
TEST(StraightLight, EqualsPathsByBsdfSamplesAloneOneByOne) {
  for (size_t light = 0; light < lights().size(); ++light) {
    for (const Part& part : sheets()) {
      if (light > 0) expect_path_is_plain(part, lights().at(light), 2);
      for (const int depth : {3, 4}) expect_path_is_plain(part, lights().at(light), depth);
      if (light == 1) expect_path_is_plain(part, lights().at(light), -1);
    }
  }
}

/// A floor, no larger than the region for light points, with its objects, and a wall.
std::string corner() {
  return shape_xml("rectangle", "<scale value=\"2\"/><rotate x=\"1\" angle=\"-90\"/>",
                   diffuse_xml("0.5")) +
         shape_xml("rectangle", "<translate x=\"-0.5\" y=\"0.5\" z=\"-1\"/>",
                   "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.1\"/></bsdf>") +
         shape_xml("sphere", "<scale value=\"0.25\"/><translate x=\"0.3\" y=\"0.25\"/>",
                   "<bsdf type=\"roughconductor\"><float name=\"alpha\" value=\"0.2\"/></bsdf>");
}
/// A surface between parts of the floor and the wall.
std::string upright(const std::string& bsdf) {
  return shape_xml("rectangle", "<scale value=\"0.8\"/><rotate y=\"1\" angle=\"60\"/>", bsdf);
}

/// Parameters of product sampling, and number of its renders. Most of a small render's time goes
/// into its light points, so that many rays per pixel cost less than many renders: with a quarter
/// of the rays and twice the renders, the smallest bias found is 1.2 times as large, in 1.7 times
/// the time.
const std::string kProduct =
    "<boolean name=\"trial\" value=\"false\"/><float name=\"rays_per_pixel\" value=\"384\"/>";
constexpr int kProductRenders = kRenders / 2;

/// Compares product sampling of the scene with `path`.
void expect_product_is_path(const std::string& scene, int depth, const std::string& parameters,
                            const std::string& name, const std::string& camera = view(64)) {
  const auto estimate = [&](const std::string& type, const std::string& own, int renders,
                            uint64_t seed) {
    return estimate_tiles(
        *scene_from(scene + camera + integrator_xml(type, depth, parameters + own)), renders, kSide,
        seed);
  };
  expect_equal(estimate("path", "", 2 * kRenders, 1),
               estimate("clustered", kProduct, kProductRenders, 50001), kAlpha,
               name + ", depth " + std::to_string(depth));
}

/// Sheets between emitters and surfaces, and between surfaces.
std::vector<Part> sheets_and_uprights() {
  std::vector<Part> parts = sheets();
  parts.push_back({"upright pane", upright(kPane)});
  parts.push_back({"upright pane and mask", upright(kPane) + sheet(mask(uniform("0.4"), kLeaf))});
  parts.push_back({"panes and mirror",
                   upright("<bsdf type=\"conductor\"/>") + sheet(kPane) + sheet(kPane, "1.1")});
  return parts;
}
void expect_product_is_path(const Part& part, const Part& light, int depth) {
  expect_product_is_path(corner() + part.xml + light.xml, depth, rr_depth_xml(4),
                         std::string(part.name) + ", " + light.name);
}

/// Paths of any length contain the shorter ones; a sky with a ball contains both kinds of light.
TEST(StraightLight, EqualsPathByProductSampling) {
  for (const Part& part : sheets_and_uprights()) {
    for (const size_t light : {0u, 2u}) expect_product_is_path(part, lights().at(light), -1);
  }
}
/// Each length and each light by itself.
TEST(StraightLight, EqualsPathByProductSamplingOneByOne) {
  for (const Part& part : sheets_and_uprights()) {
    for (const size_t light : {0u, 1u, 2u}) expect_product_is_path(part, lights().at(light), 3);
    expect_product_is_path(part, lights().at(0), 5);
    expect_product_is_path(part, lights().at(1), -1);
  }
}

/// A sheet divides a room, with the lamp behind the camera: all light passes the sheet, most of it
/// after a bounce.
TEST(StraightLight, FillsADividedRoomByProductSampling) {
  const std::string lamp = shape_xml(
      "rectangle",
      "<scale value=\"0.2\"/><rotate x=\"1\" angle=\"-90\"/><translate y=\"-0.6\" z=\"-0.6\"/>",
      area_xml("9 6 3"));
  const std::string camera =
      sensor_xml("perspective", look_at("0 0.1 0.05", "0.1 -0.2 1", "0 1 0"), kSide, 64);
  for (const std::string& bsdf : {kPane, std::string("<bsdf type=\"null\"/>"),
                                  mask(checkers("0.2", "0.7"), kLeaf)}) {
    for (const int depth : {4, 6, -1}) {
      expect_product_is_path(room_xml() + lamp + shape_xml("rectangle", "", bsdf), depth, "", bsdf,
                             camera);
    }
  }
}

/// The sky stays hidden where the camera sees it through a pane or a mask, and nowhere else.
TEST(StraightLight, EqualsPathByProductSamplingUnderAHiddenSky) {
  for (const Part& part : {sheets()[0], sheets()[5], Part{"upright pane", upright(kPane)}}) {
    for (const int depth : {3, -1}) {
      expect_product_is_path(corner() + part.xml + lights()[2].xml, depth, kHideEmitters,
                             part.name);
    }
  }
}

/// A wall that a spot lights, seen from behind a sheet: panes don't hide surfaces that lamps light.
TEST(StraightLight, OfSurfacesThatLampsLightPassesByProductSampling) {
  const std::string spot =
      "<emitter type=\"spot\"><transform name=\"to_world\"><lookat origin=\"0.3 2.5 -0.4\" "
      "target=\"-0.5 0.5 -1\" up=\"0 1 0\"/></transform><rgb name=\"intensity\" value=\"9 8 7\"/>"
      "<float name=\"cutoff_angle\" value=\"10\"/></emitter>";
  for (const std::string& bsdf : {kPane, mask(uniform("0.4"), kLeaf)}) {
    for (const int depth : {3, 4, -1}) {
      expect_product_is_path(corner() + upright(bsdf) + spot, depth, "", bsdf);
    }
  }
}

double mean_of(const std::vector<Estimate>& pixels) {
  double sum = 0;
  for (const Estimate& pixel : pixels) sum += pixel.mean;
  return sum / static_cast<double>(pixels.size());
}
double variance_of(const std::vector<Estimate>& pixels) {
  double sum = 0;
  for (const Estimate& pixel : pixels) sum += pixel.variance_of_mean;
  return sum / static_cast<double>(pixels.size());
}

/// Light of lamps stops at panes, as in Mitsuba's `path`.
TEST(StraightLight, OfPointsStopsAtPanes) {
  for (const std::string& bsdf :
       {kPane, std::string("<bsdf type=\"null\"/>"), mask(uniform("0"), kLeaf)}) {
    const std::string scene = floor_xml(diffuse_xml("0.5")) +
                              shape_xml("sphere", "<translate y=\"2\"/>", bsdf) +
                              integrator_xml("path", -1) + view(16);
    const std::string point = point_xml("0 2 0", "5 5 5");
    EXPECT_EQ(mean_of(estimate_pixels(*scene_from(scene + point), 4)), 0) << bsdf;
    // The same beside an emitter with area.
    const std::string sky = constant_xml("1 1 1");
    expect_equal(estimate_pixels(*scene_from(scene + sky), kRenders),
                 estimate_pixels(*scene_from(scene + sky + point), kRenders, 50001), kAlpha, bsdf);
  }
}

/// Emitter samples of paths pass at most 32 surfaces; light behind more of them is left to BSDF
/// samples. Product sampling has no limit.
TEST(StraightLight, PassesAnyNumberOfSurfaces) {
  const std::string scene =
      floor_xml(diffuse_xml("0.5")) + constant_xml("1 2 3") +
      integrator_xml("path", -1, rr_depth_xml(100)) +
      sensor_xml("perspective", look_at("0 0.2 2", "0 0 1", "0 1 0"), kSide, 64);
  const auto expected = estimate_tiles(*scene_from(scene), kRenders, kSide);
  for (const int count : {5, 32, 33, 40}) {
    std::string sheets;
    for (int k = 0; k < count; ++k) {
      sheets += sheet("<bsdf type=\"null\"/>", std::to_string(0.5 + 0.02 * k));
    }
    expect_equal(expected, estimate_tiles(*scene_from(scene + sheets), kRenders, kSide, 50001),
                 kAlpha, std::to_string(count));
    if (count == 5 || count == 33) {
      expect_product_is_path(corner() + sheets + constant_xml("1 2 3"), -1, rr_depth_xml(100),
                             std::to_string(count) + " by product sampling");
    }
  }
}

/// Points on large surfaces, and far from the origin, are inaccurate. Light that passes such
/// surfaces on its way to a flat lamp must not be lost. If rays were offset from each surface, they
/// could end behind the lamp, and hit it.
TEST(StraightLight, PassesLargeSurfaces) {
  for (const auto& [count, scale, x] :
       {std::tuple(8, "20", 0), {1, "1000", 0}, {1, "1", 0}, {4, "20", 100}}) {
    const std::string there = "<translate x=\"" + std::to_string(x) + "\"/>";
    const auto flat = [&, at = there](const std::string& size, const std::string& turn, double y,
                                      const std::string& inside) {
      return shape_xml("rectangle",
                       "<scale value=\"" + size + "\"/><rotate x=\"1\" angle=\"" + turn +
                           "\"/><translate y=\"" + std::to_string(y) + "\"/>" + at,
                       inside);
    };
    const std::string near = std::to_string(x), middle = std::to_string(x + 0.5);
    const std::string scene =
        flat("8", "-90", 0, diffuse_xml("0.5")) + flat("0.4", "90", 1.6, area_xml("9 6 3")) +
        sensor_xml("perspective", look_at(near + " 0.6 2", middle + " 0 -1", "0 1 0"), kSide, 64);
    std::string sheets;
    for (int k = 0; k < count; ++k) {
      sheets += flat(scale, "90", 0.8 + 0.05 * k, "<bsdf type=\"null\"/>");
    }
    const auto estimate = [&](const std::string& integrator, const std::string& between,
                              uint64_t seed, int renders = kRenders) {
      return estimate_tiles(*scene_from(scene + between + integrator), renders, kSide, seed);
    };
    const std::string path = integrator_xml("path", -1, rr_depth_xml(100));
    const auto expected = estimate(path, "", 1);
    const std::string name = std::to_string(count) + " of scale " + scale;
    expect_equal(expected, estimate(path, sheets, 50001), kAlpha, name);
    expect_equal(expected,
                 estimate(integrator_xml("clustered", -1, rr_depth_xml(100) + kProduct), sheets,
                          50001, kProductRenders),
                 kAlpha, name + " by product sampling");
  }
}

/// A small lamp behind a pane is as easy to find as without the pane.
TEST(StraightLight, HasLittleMoreNoiseThanWithoutPanes) {
  const std::string lamp =
      "<shape type=\"sphere\"><point name=\"center\" x=\"0\" y=\"1.6\" z=\"0\"/><float "
      "name=\"radius\" value=\"0.02\"/>" +
      area_xml("900 900 900") + "</shape>";
  const std::string rest =
      floor_xml(diffuse_xml("0.5")) + lamp + integrator_xml("path", 4) +
      sensor_xml("perspective", look_at("0 0.6 2", "0 0 0.5", "0 1 0"), kSide, 16);
  const auto relative = [&](const std::string& between) {
    const auto pixels = estimate_pixels(*scene_from(rest + between), kRenders);
    const double mean = mean_of(pixels);
    return variance_of(pixels) / (mean * mean);
  };
  const double without = relative("");
  for (const std::string& bsdf : {kPane, mask(uniform("0.4"), kLeaf)}) {
    // The sheet also mirrors or scatters some light to the floor, which adds noise.
    EXPECT_LT(relative(sheet(bsdf)), 2 * without) << bsdf;
  }
}

}  // namespace
}  // namespace kinome::test::straight_light_test
