/// `ptracer` against `path`, closed forms and itself.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "kinome/bsdf.h"
#include "path_scenes.h"
#include "support/sanitizer.h"

namespace kinome::test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 50 z-tests
constexpr double kPiD = std::numbers::pi;
constexpr int kSamples = kHasSanitizer ? 64 : 256;  // of most images, per render

/// Compares each pixel and the whole image of light paths with that of camera paths.
void expect_same_light(const std::string& scene, int max_depth, const std::string& name) {
  const auto estimate = [&](const char* type, uint64_t seed) {
    return estimate_pixels(*scene_from(scene + integrator_xml(type, max_depth, rr_depth_xml(2))),
                           kRenders, seed);
  };
  expect_equal(estimate("path", 1), estimate("ptracer", 50001), kAlpha, name);
}

struct Light {
  const char* name;
  std::string xml;
};
std::vector<Light> lights() {
  return {
      {"point", point_xml("0.3 0.6 0.1", "1 2 1.5")},
      {"spot",
       "<emitter type=\"spot\"><transform name=\"to_world\">" +
           look_at("0.1 0.3 0.4", "0.5 -0.3 -1", "0 1 0") +
           "</transform><rgb name=\"intensity\" value=\"3 2 1\"/><float name=\"cutoff_angle\" "
           "value=\"35\"/></emitter>"},
      {"area",
       shape_xml("rectangle",
                 "<scale value=\"0.3\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"0.9\"/>",
                 area_xml("9 6 3"))},
      {"sphere", shape_xml("sphere", "<scale value=\"0.2\"/><translate y=\"0.5\"/>",
                           diffuse_xml("0.4") + area_xml("3 6 9"))},
  };
}

/// Eight triangles with the smooth normals of a sphere: shading normals deviate by up to 50
/// degrees.
std::string octahedron(const TemporaryFolder& folder, const std::string& bsdf) {
  const std::string file =
      folder.write("octahedron.obj",
                   "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n"
                   "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n");
  return shape_xml("obj", "<scale value=\"0.5\"/><translate x=\"0.2\" y=\"-0.3\" z=\"-0.4\"/>",
                   "<string name=\"filename\" value=\"" + file + "\"/>" + bsdf);
}

TEST(LightTracing, AgreesWithPathsInARoom) {
  const TemporaryFolder folder;
  const std::string objects =
      octahedron(folder, diffuse_xml("0.8 0.6 0.4")) +
      shape_xml("sphere", "<scale value=\"0.3\"/><translate x=\"-0.5\" y=\"-0.6\" z=\"-0.3\"/>",
                "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.3\"/></bsdf>") +
      shape_xml("cube", "<scale value=\"0.2\"/><translate x=\"0.6\" y=\"-0.8\" z=\"0.2\"/>",
                "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"Cu\"/><float "
                "name=\"alpha\" value=\"0.4\"/></bsdf>");
  for (const Light& light : lights()) {
    for (const int depth : {2, 4}) {
      expect_same_light(room_xml() + objects + light.xml + room_view(5, 64), depth,
                        light.name + (", depth " + std::to_string(depth)));
    }
  }
}

/// Close-ups of materials that aren't reciprocal, or have their own shading normals.
TEST(LightTracing, EvaluatesMaterialsAsPathsDo) {
  const TemporaryFolder folder;
  const std::string normal_map =
      "<bsdf type=\"twosided\"><bsdf type=\"normalmap\"><texture type=\"checkerboard\" "
      "name=\"normalmap\"><rgb name=\"color0\" value=\"0.75 0.6 0.9\"/><rgb name=\"color1\" "
      "value=\"0.3 0.4 0.9\"/></texture>";
  const std::pair<const char*, std::string> materials[] = {
      {"diffuse", diffuse_xml("0.8 0.6 0.4")},
      {"ward",
       "<bsdf type=\"ward\"><float name=\"alpha_u\" value=\"0.3\"/><float "
       "name=\"alpha_v\" value=\"0.5\"/></bsdf>"},
      {"rough plastic", "<bsdf type=\"roughplastic\"><float name=\"alpha\" value=\"0.3\"/></bsdf>"},
      {"normal map", normal_map + diffuse_xml("0.8 0.6 0.4") + "</bsdf></bsdf>"},
      {"rough normal map", normal_map + "<bsdf type=\"roughconductor\"><float name=\"alpha\" "
                                        "value=\"0.5\"/></bsdf></bsdf></bsdf>"},
  };
  const std::string camera =
      sensor_xml("perspective", look_at("0 0.2 0.9", "0.2 -0.3 -0.4", "0 1 0"), 4, kSamples);
  for (const auto& [name, bsdf] : materials) {
    expect_same_light(
        room_xml() + octahedron(folder, bsdf) + point_xml("0.6 0.5 0.6", "1 1 1") + camera, 3,
        name);
  }
}

TEST(LightTracing, FindsTheFilmOfEveryCamera) {
  const std::string scene = room_xml() + lights()[3].xml;
  for (const char* const filter : {"box", "tent", "gaussian"}) {
    // One pixel, since neighbours share samples under a wide filter.
    const std::string film =
        "<sampler type=\"independent\"><integer name=\"sample_count\" value=\"" +
        std::to_string(kSamples / 2) +
        "\"/></sampler>"
        "<film type=\"hdrfilm\"><integer name=\"width\" value=\"3\"/><integer name=\"height\" "
        "value=\"2\"/><integer name=\"crop_offset_x\" value=\"1\"/><integer name=\"crop_width\" "
        "value=\"1\"/><integer name=\"crop_height\" value=\"1\"/><boolean name=\"sample_border\" "
        "value=\"true\"/><rfilter type=\"" +
        std::string(filter) + "\"/></film></sensor>";
    const auto camera = [&](const std::string& type, const std::string& parameters,
                            const std::string& scale = "") {
      return "<sensor type=\"" + type + "\">" + parameters + "<transform name=\"to_world\">" +
             scale + look_at("0.1 0.2 0.6", "0 -0.2 -1", "0.1 1 0") + "</transform>" + film;
    };
    expect_same_light(scene + camera("perspective", "<float name=\"fov\" value=\"70\"/>"), 3,
                      filter + std::string(", perspective"));
    expect_same_light(scene + camera("thinlens",
                                     "<float name=\"fov\" value=\"70\"/><float "
                                     "name=\"aperture_radius\" value=\"0.1\"/><float "
                                     "name=\"focus_distance\" value=\"0.8\"/>"),
                      3, filter + std::string(", thin lens"));
    expect_same_light(scene + camera("orthographic", "", "<scale x=\"0.5\" y=\"0.4\" z=\"2\"/>"), 3,
                      filter + std::string(", orthographic"));
  }
}

/// A choice among lobes, one of them a delta: light that a plastic wall reflects to a floor.
TEST(LightTracing, ScattersDeltaAndOtherLobesOfOneMaterial) {
  expect_same_light(
      floor_xml(diffuse_xml("0.5")) +
          shape_xml("rectangle", "<rotate y=\"1\" angle=\"90\"/><translate x=\"-1.2\" y=\"1\"/>",
                    "<bsdf type=\"plastic\"><rgb name=\"diffuse_reflectance\" value=\"0.1 0.4 "
                    "0.8\"/></bsdf>") +
          shape_xml("rectangle",
                    "<scale value=\"0.5\"/><rotate y=\"1\" angle=\"-90\"/><rotate z=\"1\" "
                    "angle=\"30\"/><translate x=\"0.5\" y=\"2\"/>",
                    area_xml("5 5 5")) +
          sensor_xml("orthographic", look_at("0 1 0", "0 0 0", "0 0 1"), 3, kSamples),
      3, "plastic");
}

/// Normals that are flipped toward the viewer (flip_invalid_normals): light reaches points from
/// which they are visible, though they face away when seen from the lamp.
TEST(LightTracing, ScattersByNormalsThatTurnToTheViewer) {
  const std::pair<const char*, std::string> normals[] = {{"tilted", "0.93 0.5 0.75"},
                                                         {"below the surface", "0.15 0.5 0.4"}};
  const std::pair<const char*, std::string> materials[] = {{"diffuse", diffuse_xml("0.8 0.6 0.4")},
                                                           {"plastic", "<bsdf type=\"plastic\"/>"}};
  for (const auto& [tilt, colour] : normals) {
    for (const auto& [name, nested] : materials) {
      for (const char* const z : {"0", "2"}) {  // z coordinate of the lamp
        expect_same_light(
            floor_xml(diffuse_xml("0.5")) +
                shape_xml("rectangle",
                          "<rotate y=\"1\" angle=\"90\"/><scale y=\"0.7\"/>"
                          "<translate x=\"-1.2\" y=\"1.2\"/>",
                          "<bsdf type=\"twosided\"><bsdf type=\"normalmap\"><texture "
                          "type=\"checkerboard\" name=\"normalmap\"><rgb name=\"color0\" value=\"" +
                              colour + "\"/><rgb name=\"color1\" value=\"" + colour +
                              "\"/></texture>" + nested + "</bsdf></bsdf>") +
                "<emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"15\"/><transform "
                "name=\"to_world\">" +
                look_at("0.8 1.2 " + std::string(z), "-1.2 1.2 0", "0 1 0") +
                "</transform></emitter>" +
                sensor_xml("orthographic", look_at("0 1 0", "0 0 0", "0 0 1"), 3, kSamples),
            3, std::string(name) + ", " + tilt + ", lamp at " + z);
      }
    }
  }
}

/// A mirror below a normal map shows a different point to each side. The first lamp shines along
/// the wall, so that the normal turns to it. With the second, on the other side, lamp and viewer
/// disagree about the shadowing by the tilt.
TEST(LightTracing, MirrorsByNormalsAsTheViewerSeesThem) {
  const std::string normals =
      "<bsdf type=\"twosided\"><bsdf type=\"normalmap\"><texture type=\"checkerboard\" "
      "name=\"normalmap\"><rgb name=\"color0\" value=\"0.75 0.5 0.933\"/><rgb name=\"color1\" "
      "value=\"0.75 0.5 0.933\"/></texture>";
  for (const char* const lamp : {"-0.68 1.3 1.8", "-0.27 1.3 -1.61"}) {
    for (const char* const mirror : {"plastic", "conductor"}) {
      expect_same_light(
          floor_xml(diffuse_xml("0.5")) +
              shape_xml("rectangle",
                        "<scale x=\"0.6\" y=\"0.5\"/><rotate y=\"1\" angle=\"90\"/>"
                        "<translate x=\"-1.2\" y=\"0.6\"/>",
                        normals + "<bsdf type=\"" + mirror + "\"/></bsdf></bsdf>") +
              shape_xml("rectangle",
                        "<scale value=\"0.5\"/>" + look_at(lamp, "-1.2 0.6 0", "0 1 0"),
                        area_xml("5 5 5")) +
              sensor_xml("orthographic", look_at("0 1 0", "0 0 0", "0 0 1"), 3, kSamples),
          3, std::string(mirror) + ", lamp at " + lamp);
    }
  }
}

/// An environment lights the surfaces that the camera sees, but is black itself.
TEST(LightTracing, TakesLightFromEnvironments) {
  // The floor is small, because light paths must find each pixel often enough for normally
  // distributed means.
  const std::string scene = shape_xml("rectangle", "<scale value=\"5\"/><rotate x=\"1\" angle=\"-90\"/>",
                                      diffuse_xml("0.5 0.6 0.7")) +
                            shape_xml("sphere", "<translate y=\"1\"/>", diffuse_xml("0.7"));
  const std::string camera = sensor_xml("perspective", look_at("0 6 3", "0 0 0", "0 1 0"), 4, 256);
  const std::string sun =
      "<emitter type=\"directional\"><vector name=\"direction\" value=\"0.3 -1 -0.2\"/></emitter>";
  for (const std::string& light : {constant_xml("1 2 3"), sun}) {
    expect_same_light(scene + light + camera, 3, light);
  }
  const Image sky = render_scene(*scene_from(constant_xml("1") + camera +
                                             shape_xml("sphere", "<translate y=\"-90\"/>", "") +
                                             integrator_xml("ptracer", 3)));
  EXPECT_EQ(sky.at(0, 0, 0), 0);
}

TEST(LightTracing, ShowsAndHidesEmitters) {
  const std::string light =
      shape_xml("rectangle", "<rotate y=\"1\" angle=\"30\"/>", area_xml("1 2 3")) +
      sensor_xml("orthographic", "<scale value=\"1.2\"/>" + look_at("0 0 5", "0 0 0", "0 1 0"), 4,
                 64);
  expect_same_light(light, 1, "a light alone");
  const Image hidden =
      render_scene(*scene_from(light + integrator_xml("ptracer", 1, kHideEmitters)));
  for (const float value : hidden.data) EXPECT_EQ(value, 0);
}

/// Radiance of a floor after one bounce from a ceiling above that faces it, by midpoints over the
/// ceiling. Both are [-1, 1]² and diffuse, with a point light of intensity 1 between them.
struct Plates {
  static constexpr double kFloor = 0.6, kCeiling = 0.8, kHeight = 1, kLight = 0.4;

  static double radiance(double x, double y) {
    constexpr int kSteps = 60;
    double bounce = 0;
    for (int i = 0; i < kSteps * kSteps; ++i) {
      const double u = 2 * (i % kSteps + 0.5) / kSteps - 1, v = 2 * (i / kSteps + 0.5) / kSteps - 1;
      const double up = kHeight - kLight;
      const double irradiance = up / std::pow(u * u + v * v + up * up, 1.5);
      const double d2 = (u - x) * (u - x) + (v - y) * (v - y) + kHeight * kHeight;
      bounce += kCeiling / kPiD * irradiance * kHeight * kHeight / (d2 * d2);
    }
    bounce *= 4.0 / (kSteps * kSteps);
    const double direct = kLight / std::pow(x * x + y * y + kLight * kLight, 1.5);
    return kFloor / kPiD * (direct + bounce);
  }
};

TEST(LightTracing, OneBounceBetweenPlatesIsItsIntegral) {
  const std::string scene =
      shape_xml("rectangle", "", diffuse_xml(std::to_string(Plates::kFloor))) +
      shape_xml("rectangle", "<rotate x=\"1\" angle=\"180\"/><translate z=\"1\"/>",
                diffuse_xml(std::to_string(Plates::kCeiling))) +
      point_xml("0 0 0.4", "1 1 1") +
      // Below the ceiling, and 2 x 2 like the floor.
      sensor_xml("orthographic", look_at("0 0 0.9", "0 0 0", "0 1 0"), 4, kSamples);
  std::vector<Estimate> expected;
  constexpr int kSteps = 20;
  for (int pixel = 0; pixel < 16; ++pixel) {
    double mean = 0;
    for (int i = 0; i < kSteps * kSteps; ++i) {
      mean += Plates::radiance((pixel % 4 + (i % kSteps + 0.5) / kSteps) / 2 - 1,
                               (pixel / 4 + (i / kSteps + 0.5) / kSteps) / 2 - 1);
    }
    expected.push_back({mean / (kSteps * kSteps), 0});
  }
  for (const char* const type : {"path", "ptracer"}) {
    const auto rendered = estimate_pixels(*scene_from(scene + integrator_xml(type, 3)), kRenders);
    const Verdict verdict = z_test(channel(rendered, 0), expected, kAlpha);
    EXPECT_TRUE(verdict.passed) << type << ": " << verdict.text;
  }
}

/// A mirror beside a floor: light arrives from a point light and from its image behind the mirror.
TEST(LightTracing, FindsCaustics) {
  const std::string scene =
      floor_xml(diffuse_xml("0.5")) +
      shape_xml("rectangle",
                "<scale value=\"40\"/><rotate y=\"1\" angle=\"90\"/><translate x=\"-2\"/>",
                "<bsdf type=\"conductor\"><rgb name=\"specular_reflectance\" value=\"0.7 0.5 "
                "1\"/></bsdf>") +
      point_xml("-1 2 0", "4 4 4") +
      sensor_xml("orthographic", "<scale value=\"0.2\"/>" + look_at("0 9 0", "0 0 0", "0 0 1"), 1,
                 16384);
  const auto rendered =
      estimate_pixels(*scene_from(scene + integrator_xml("ptracer", 3)), kRenders);
  // Means over the pixel, [-0.2, 0.2]², by midpoints.
  const auto from = [](double x) {
    double sum = 0;
    for (int i = 0; i < 400; ++i) {
      const double a = x - ((i % 20 + 0.5) / 50 - 0.2), b = (i / 20 + 0.5) / 50 - 0.2;
      sum += 4 * 2 / std::pow(a * a + b * b + 4, 1.5);
    }
    return 0.5 / kPiD * sum / 400;
  };
  std::vector<Estimate> expected;
  for (const double mirror : {0.7, 0.5, 1.0}) expected.push_back({from(-1) + mirror * from(-3), 0});
  expect_equal(rendered, expected, kAlpha, "point and image");
}

TEST(LightTracing, SameBitsAtAnyThreadCount) {
  for (const char* const sampler : kSamplers) {
    const auto scene = scene_from(
        room_xml() + lights()[1].xml + integrator_xml("ptracer", 6, rr_depth_xml(2)) +
        sensor_xml("perspective", look_at("0 0 0.95", "0 0 -1", "0 1 0"), 70, 4, sampler));
    const auto render_with = [&](unsigned threads, uint64_t order) {
      RenderContext context({.threads = threads, .seed = 5, .tile_order_seed = order});
      return render(*scene, *scene->sensors()[0], context).data;
    };
    const auto one = render_with(1, 0);
    EXPECT_EQ(one, render_with(3, 9)) << sampler;
    EXPECT_NE(one, render_scene(*scene, 6, 3).data) << sampler;
  }
}

/// An interrupted render has the same mean as a complete one. 80 samples of 128² pixels are two
/// passes, and the first is interrupted.
TEST(LightTracing, CutShortKeepsItsBrightness) {
  const auto mean_of = [](const Image& image) {
    double sum = 0;
    for (const float value : image.data) sum += value;
    return sum / static_cast<double>(image.data.size());
  };
  const auto scene =
      scene_from(room_xml() + lights()[0].xml + integrator_xml("ptracer", 2) + room_view(128, 80));
  const double whole = mean_of(render_scene(*scene, 99));
  Moments cut;
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    std::atomic<bool> cancel{false};
    double last = 0;
    RenderContext context({.seed = seed, .cancel = &cancel, .progress = [&](double fraction) {
                             EXPECT_GT(fraction, last);
                             last = fraction;
                             cancel = fraction > 0.1 * static_cast<double>(seed);
                           }});
    cut.add(mean_of(render(*scene, *scene->sensors()[0], context)));
    EXPECT_FALSE(context.job.stats().complete);
  }
  // There are 10^6 paths in total. One in four is visible, and its values vary by about as much as
  // their mean: .2 %, 5 sigma.
  EXPECT_NEAR(cut.mean(), whole, 0.01 * whole);
}

TEST(LightTracing, WithoutLightIsBlack) {
  const auto scene = scene_from(room_xml() + room_view(8, 4) + integrator_xml("ptracer", -1));
  RenderContext context({});
  const Image image = render(*scene, *scene->sensors()[0], context);
  for (const float value : image.data) EXPECT_EQ(value, 0);
  EXPECT_FALSE(context.job.stats().skipped.empty());
}

}  // namespace
}  // namespace kinome::test
