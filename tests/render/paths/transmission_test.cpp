/// Light that goes through surfaces: against closed forms, light tracing against paths, and
/// `clustered` against `path`.
#include <gtest/gtest.h>

#include "path_scenes.h"

namespace kinome::test::transmission_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 40 z-tests

struct Material {
  const char* name;
  std::string xml;
};
std::vector<Material> materials() {
  return {
      {"glass", "<bsdf type=\"dielectric\"/>"},
      {"bubble",
       "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1\"/><float name=\"ext_ior\" "
       "value=\"1.5\"/></bsdf>"},
      {"pane", "<bsdf type=\"thindielectric\"/>"},
      {"null", "<bsdf type=\"null\"/>"},
  };
}
/// A mask that is half opaque, with the given BSDF.
Material mask(const char* name, const std::string& bsdf) {
  return {name, "<bsdf type=\"mask\"><texture type=\"checkerboard\" name=\"opacity\"><float "
                "name=\"color0\" value=\"0.3\"/><float name=\"color1\" value=\"0.8\"/><transform "
                "name=\"to_uv\"><scale value=\"3\"/></transform></texture>" +
                    bsdf + "</bsdf>"};
}
std::vector<Material> materials_and_masks() {
  std::vector<Material> all = materials();
  all.push_back(mask("masked diffuse", "<bsdf type=\"twosided\">" + diffuse_xml("0.8 0.5 0.2") +
                                           "</bsdf>"));
  all.push_back(mask("masked gloss", "<bsdf type=\"twosided\"><bsdf type=\"roughplastic\"><float "
                                     "name=\"alpha\" value=\"0.3\"/></bsdf></bsdf>"));
  all.push_back(mask("masked mirror", "<bsdf type=\"twosided\"><bsdf type=\"conductor\"/></bsdf>"));
  return all;
}
std::vector<Material> rough_materials() {
  return {
      {"ground glass", "<bsdf type=\"roughdielectric\"><float name=\"alpha\" value=\"0.3\"/></bsdf>"},
      {"brushed glass",
       "<bsdf type=\"roughdielectric\"><string name=\"distribution\" value=\"ggx\"/><float "
       "name=\"alpha_u\" value=\"0.1\"/><float name=\"alpha_v\" value=\"0.5\"/></bsdf>"},
      {"disney's glass",
       "<bsdf type=\"principled\"><float name=\"spec_trans\" value=\"0.7\"/><float "
       "name=\"clearcoat\" value=\"1\"/></bsdf>"},
      {"bumpy glass",
       "<bsdf type=\"bumpmap\"><texture type=\"bitmap\"><string name=\"filename\" "
       "value=\"" KINOME_TEST_SOURCE "/tests/support/bumps.pfm\"/><boolean name=\"raw\" "
       "value=\"true\"/></texture><float name=\"scale\" value=\"0.2\"/><bsdf "
       "type=\"roughdielectric\"><float name=\"alpha\" value=\"0.3\"/></bsdf></bsdf>"},
      {"leaf",
       "<bsdf type=\"principledthin\"><float name=\"diff_trans\" value=\"0.8\"/><float "
       "name=\"spec_trans\" value=\"0.4\"/></bsdf>"},
  };
}

/// A solid without absorption in uniform light has the radiance of that light: refraction increases
/// it on the way in and decreases it on the way out.
TEST(Transmission, SolidsVanishInAnEvenLight) {
  for (const Material& m : materials()) {
    for (const char* const shape : {"sphere", "cube"}) {
      const auto scene = scene_from(
          shape_xml(shape, "<scale value=\"0.5\"/><rotate y=\"1\" angle=\"20\"/>", m.xml) +
          constant_xml("1 1 1") + integrator_xml("path", -1, rr_depth_xml(5)) +
          sensor_xml("perspective", look_at("0 0.5 2", "0 0 0", "0 1 0"), 6, 64));
      const auto picture = estimate_pixels(*scene, 16);
      expect_equal(picture, std::vector<Estimate>(picture.size(), {1, 0}), kAlpha,
                   m.name + std::string(" ") + shape);
    }
  }
}

/// A broad lamp above a slab above a floor. Light tracing doesn't show what is seen through glass,
/// so that the camera looks only at the floor.
TEST(Transmission, LightTracingAgreesWithPaths) {
  const std::string lamp = shape_xml(
      "rectangle", "<scale value=\"0.7\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"1.6\"/>",
      area_xml("9 6 3"));
  const std::string camera =
      sensor_xml("perspective", look_at("0 0.25 1.2", "0.1 0 0", "0 1 0"), 4, 256);
  auto all = materials_and_masks();
  for (const Material& m : rough_materials()) all.push_back(m);
  all.push_back(mask("masked ground glass", rough_materials().front().xml));
  for (const Material& m : all) {
    const std::string slab = shape_xml("cube",
                                       "<scale x=\"0.6\" y=\"0.15\" z=\"0.6\"/><rotate z=\"1\" "
                                       "angle=\"12\"/><translate y=\"0.8\"/>",
                                       m.xml);
    const auto estimate = [&](const char* type, uint64_t seed) {
      // Sums of four pixels. Single pixels behind glass have too few of the rare bright samples for
      // normally distributed means.
      return estimate_tiles(*scene_from(floor_xml(diffuse_xml("0.5")) + slab + lamp + camera +
                                        integrator_xml(type, 6, rr_depth_xml(3))),
                            2 * kRenders, 2, seed);
    };
    expect_equal(estimate("path", 1), estimate("ptracer", 50001), kAlpha, m.name);
  }
}

/// Camera and floor are under water, the lamp above: light enters, and doesn't leave again.
TEST(Transmission, LightTracingAgreesWithPathsUnderWater) {
  const std::string scene =
      floor_xml(diffuse_xml("0.5")) +
      shape_xml("rectangle",
                "<scale value=\"50\"/><rotate x=\"1\" angle=\"-90\"/><translate y=\"1\"/>",
                "<bsdf type=\"dielectric\"><string name=\"int_ior\" value=\"water\"/></bsdf>") +
      shape_xml("rectangle",
                "<scale value=\"0.7\"/><rotate x=\"1\" angle=\"90\"/><translate y=\"1.6\"/>",
                area_xml("9 6 3")) +
      sensor_xml("perspective", look_at("0 0.7 0.3", "0.1 0 0", "0 1 0"), 4, 256);
  const auto estimate = [&](const char* type, uint64_t seed) {
    return estimate_pixels(*scene_from(scene + integrator_xml(type, 4, rr_depth_xml(9))), kRenders,
                           seed);
  };
  expect_equal(estimate("path", 1), estimate("ptracer", 50001), kAlpha, "water");
}

/// Compares emitter samples on the other side of the surface with BSDF samples.
TEST(Transmission, WaysToSampleDirectLightAgreeBehindRoughGlass) {
  for (const Material& m : rough_materials()) {
    const std::string scene =
        shape_xml("rectangle", "<scale value=\"2\"/>", m.xml) +
        shape_xml("rectangle", "<translate x=\"0.3\" z=\"-1.5\"/>", area_xml("9 6 3")) +
        sensor_xml("perspective", look_at("0.1 0.2 2", "0 0 0", "0 1 0"), 6, 256);
    const auto estimate = [&](const std::string& integrator, uint64_t seed) {
      return estimate_pixels(*scene_from(scene + integrator), kRenders, seed);
    };
    const auto direct = [](int emitter_samples, int bsdf_samples) {
      return "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"" +
             std::to_string(emitter_samples) + "\"/><integer name=\"bsdf_samples\" value=\"" +
             std::to_string(bsdf_samples) + "\"/></integrator>";
    };
    const auto expected = estimate(direct(1, 0), 1);
    expect_equal(expected, estimate(direct(0, 1), 50001), kAlpha, m.name + std::string(", BSDF"));
    expect_equal(expected, estimate(direct(1, 1), 70001), kAlpha, m.name + std::string(", both"));
    expect_equal(expected, estimate(integrator_xml("path", 2, rr_depth_xml(9)), 90001), kAlpha,
                 m.name + std::string(", path"));
  }
}

struct Light {
  const char* name;
  std::string xml;
  const char* turn = "0";  ///< of the surface, in degrees
};
std::vector<Light> lights() {
  return {
      {"lamp", shape_xml("rectangle",
                         "<scale value=\"0.5\"/><rotate x=\"1\" angle=\"90\"/><translate "
                         "y=\"1.6\"/>",
                         area_xml("9 6 3"))},
      {"sky", constant_xml("1 2 3")},
      {"sky, from behind", constant_xml("1 2 3"), "180"},
  };
}
/// Compares `clustered` with `path` for surfaces of all materials.
void expect_clustered_agrees(const Light& light, int depth) {
  for (const Material& m : materials_and_masks()) {
    // The floor is no larger than the visible part, so that light that bounces off it has enough
    // light points.
    const std::string scene =
        shape_xml("rectangle", "<scale value=\"5\"/><rotate x=\"1\" angle=\"-90\"/>",
                  diffuse_xml("0.5")) +
        shape_xml("rectangle",
                  std::string("<scale value=\"0.6\"/><rotate y=\"1\" angle=\"") + light.turn +
                      "\"/><translate y=\"0.4\" z=\"0.3\"/>",
                  m.xml) +
        shape_xml("sphere", "<scale value=\"0.3\"/><translate y=\"0.3\" z=\"-0.4\"/>",
                  diffuse_xml("0.8 0.4 0.2")) +
        light.xml + sensor_xml("perspective", look_at("0.1 0.5 2", "0 0.3 0", "0 1 0"), 8, 64);
    const auto estimate = [&](const std::string& integrator, int renders, uint64_t seed) {
      return estimate_tiles(*scene_from(scene + integrator), renders, 4, seed);
    };
    // Most of a small render's time goes into its light points. Half as many rays per pixel and
    // twice as many renders find the same bias, in nearly twice the time.
    const std::string product =
        "<integrator type=\"clustered\"><string name=\"importance\" value=\"product\"/>"
        "<boolean name=\"trial\" value=\"false\"/>"
        "<float name=\"rays_per_pixel\" value=\"192\"/><integer name=\"max_depth\" value=\"" +
        std::to_string(depth) + "\"/></integrator>";
    expect_equal(estimate(integrator_xml("path", depth, rr_depth_xml(9)), kRenders, 1),
                 estimate(product, kRenders / 2, 50001), kAlpha,
                 m.name + std::string(", ") + light.name + ", depth " + std::to_string(depth));
  }
}

/// Edges of all numbers pass a surface, with light of a lamp, a sky and a point light. `clustered`
/// finds light of a point light through glass on a floor; `path` doesn't.
TEST(Transmission, ClusteredAgreesWithPaths) {
  for (const Light& light : lights()) expect_clustered_agrees(light, 5);
  expect_clustered_agrees({"point", point_xml("0.5 1.5 0.5", "2 2 3")}, 2);
}
/// The first or second edge passes a surface.
TEST(Transmission, ClusteredAgreesWithShortPaths) {
  for (const Light& light : lights()) {
    for (const int depth : {2, 3}) expect_clustered_agrees(light, depth);
  }
}

}  // namespace
}  // namespace kinome::test::transmission_test
