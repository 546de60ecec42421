/// One bounce by virtual point lights: closed forms, hard cases, and skipped emitters.
#include <algorithm>
#include <cmath>

#include "direct_scenes.h"
#include "kinome/bsdf.h"
#include "kinome/log.h"

namespace kinome::test {
namespace {

constexpr float kRadius = 2;

/// A closed diffuse sphere, seen from inside.
std::string inside_sphere(const std::string& bsdf) {
  return "<shape type=\"sphere\"><float name=\"radius\" value=\"" + std::to_string(kRadius) +
         "\"/><boolean name=\"flip_normals\" value=\"true\"/>" + bsdf + "</shape>";
}
const std::string kLamp =
    "<emitter type=\"point\"><rgb name=\"intensity\" value=\"4 8 12\"/></emitter>";
const std::string kView = sensor_xml("perspective", look_at("0.7 0.2 0.1", "0 -1 0.3"), 4, 2);

std::string bounce_xml(const std::string& integrator, int points, const std::string& more = "") {
  return "<integrator type=\"" + integrator +
         "\"><integer name=\"max_depth\" value=\"3\"/><integer name=\"light_samples\" value=\"" +
         std::to_string(points) + "\"/>" + more + "</integrator>";
}
/// Without a bounce.
std::string depth_2(const std::string& integrator, const std::string& more = "") {
  return "<integrator type=\"" + integrator + "\"><integer name=\"max_depth\" value=\"2\"/>" +
         more + "</integrator>";
}
/// `clustered` with light points.
const std::string kJoint = "<string name=\"importance\" value=\"joint\"/>";
std::string clustered_xml(int points) {
  return bounce_xml("clustered", points, kJoint);
}
std::string vpl_xml(const std::string& emitters, const std::string& placement,
                    const std::string& more = "") {
  return "<emitter type=\"vpl\">" + emitters + "<string name=\"placement\" value=\"" + placement +
         "\"/>" + more + "</emitter>";
}

/// Returns the error of loading the scene, or "".
std::string error_text(const std::string& scene_xml) {
  try {
    scene_from(scene_xml);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Relative error of an image in single precision: about sixteen roundings by 2^-24 for a light
/// path, and one more for each point in a sum.
double rounding(int points = 0) {
  return (16 + points) * 0x1p-24;
}

void expect_everywhere(const Image& image, const Rgb& expected, double tolerance) {
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(image.at(x, y, c), expected[c], tolerance * expected[c]) << x << ", " << y;
      }
    }
  }
}

std::string skipped(const std::string& scene_xml) {
  const auto scene = scene_from(scene_xml);
  RenderContext context({.threads = 1});
  render(*scene, *scene->sensors()[0], context);
  std::string all;
  for (const Skipped& s : context.job.stats().skipped) all += s.what + ": " + s.why + "\n";
  return all;
}

/// `min_value`: minimum of the values. With product sampling, dark pixels may be negative.
Image render_finite(const std::string& scene_xml, unsigned threads = 0, float min_value = 0) {
  const auto scene = scene_from(scene_xml);
  RenderContext context({.threads = threads, .seed = 3});
  const Image image = render(*scene, *scene->sensors()[0], context);
  EXPECT_EQ(context.job.stats().non_finite_samples, 0u);
  for (const float v : image.data) EXPECT_TRUE(std::isfinite(v) && v >= min_value) << v;
  return image;
}

/// A lamp in the centre of a sphere: E0 = I / R², and after a bounce rho E0 again, since cos
/// cos'/d² is 1 / (4 R²) between any two points of a sphere. One point suffices for the exact
/// value.
TEST(Vpl, OneBounceInASphereIsExactWithAnyNumberOfPoints) {
  const Rgb rho(0.2, 0.5, 0.8);
  const Rgb direct = rho * Rgb(4, 8, 12) / (kRadius * kRadius * kPi);
  const Rgb expected = direct * (1.f + rho);
  for (const char* placement : {"surface", "traced"}) {
    for (const int points : {1, 7, 4096}) {
      const std::string scene_xml = inside_sphere(diffuse_xml("0.2 0.5 0.8")) +
                                    vpl_xml(kLamp, placement) + kView +
                                    bounce_xml("groundtruth", points);
      expect_everywhere(render_finite(scene_xml), expected, rounding(points));
    }
  }
}

TEST(Vpl, ClusteredMakesItsOwnPointsWhereTheSceneHasNone) {
  const Rgb rho(0.2, 0.5, 0.8);
  const Rgb expected = rho * Rgb(4, 8, 12) / (kRadius * kRadius * kPi) * (1.f + rho);
  const std::string scene_xml = inside_sphere(diffuse_xml("0.2 0.5 0.8")) + kLamp + kView;
  const auto clustered = scene_from(scene_xml + clustered_xml(500));
  ASSERT_EQ(clustered->indirect_emitters().size(), 1u);
  expect_equal(estimate_pixels(*clustered, kRenders), exactly(expected, 16), 1e-4, "clustered");
  EXPECT_EQ(scene_from(scene_xml + "<integrator type=\"clustered\"/>")->indirect_emitters().size(),
            1u);
  const auto direct = scene_from(scene_xml + depth_2("clustered"));
  EXPECT_TRUE(direct->indirect_emitters().empty());
  expect_everywhere(render_scene(*direct), rho * Rgb(4, 8, 12) / (kRadius * kRadius * kPi),
                    rounding());
}

/// cos cos'/d² is 1/16 everywhere: a bound of 1/32 halves the bounce, and a bound above 1/16 has no
/// effect.
TEST(Vpl, GeometryTermIsBounded) {
  const Rgb rho(0.5f);
  const Rgb direct = rho * Rgb(4, 8, 12) / (kRadius * kRadius * kPi);
  const std::string scene_xml = inside_sphere(diffuse_xml("0.5")) + kLamp + kView;
  const auto with_bound = [&](const std::string& bound) {
    return render_finite(scene_xml +
                         bounce_xml("groundtruth", 100,
                                    "<float name=\"max_geometry_term\" value=\"" + bound + "\"/>"));
  };
  expect_everywhere(with_bound("0.03125"), direct * (1.f + 0.5f * rho), rounding(100));
  expect_everywhere(with_bound("0.07"), direct * (1.f + rho), rounding(100));
  EXPECT_NE(error_text(scene_xml + bounce_xml("groundtruth", 1,
                                              "<float name=\"max_geometry_term\" value=\"-1\"/>"))
                .find("max_geometry_term"),
            std::string::npos);
}

/// Two lamps of half the power equal one lamp. An emitter that is referred to twice emits once.
TEST(Vpl, EmittersAddUp) {
  const std::string half =
      "<emitter type=\"point\"><rgb name=\"intensity\" value=\"2 4 6\"/></emitter>";
  const std::string shared =
      "<emitter type=\"point\" id=\"lamp\"><rgb name=\"intensity\" "
      "value=\"4 8 12\"/></emitter><emitter type=\"vpl\"><ref "
      "id=\"lamp\"/></emitter>";
  const std::string rest =
      inside_sphere(diffuse_xml("0.5")) + kView + bounce_xml("groundtruth", 64);
  const Image one = render_finite(rest + kLamp);
  const Image two = render_finite(rest + half + half);
  const Image wrapped = render_finite(rest + vpl_xml(half + half, "traced"));
  const Image referred = render_finite(rest + shared);
  for (size_t i = 0; i < one.data.size(); ++i) {
    // 64 points in one image, 128 in the other.
    EXPECT_NEAR(two.data[i], one.data[i], rounding(192) * one.data[i]);
    EXPECT_NEAR(wrapped.data[i], one.data[i], rounding(192) * one.data[i]);
    EXPECT_EQ(referred.data[i], one.data[i]);
  }
}

/// There are more emitters than are evaluated for one position, so that some are chosen at random.
/// The mean must be correct. The image has one pixel, because all pixels of a render share the same
/// points.
TEST(Vpl, ManyEmitters) {
  std::string lamps;
  for (int i = 0; i < 20; ++i) {
    lamps += "<emitter type=\"point\"><rgb name=\"intensity\" value=\"" + std::to_string(i) +
             " 1 2\"/></emitter>";
  }
  const Rgb rho(0.5f);
  const Rgb expected = rho * Rgb(190, 20, 40) / (kRadius * kRadius * kPi) * (1.f + rho);
  const std::string scene_xml = inside_sphere(diffuse_xml("0.5")) + lamps +
                                sensor_xml("perspective", look_at("0.7 0.2 0.1", "0 -1 0.3"), 1, 1);
  for (const char* placement : {"surface", "traced"}) {
    const auto scene =
        scene_from(scene_xml + bounce_xml("groundtruth", 50) + vpl_xml("", placement));
    expect_equal(estimate_pixels(*scene, kRenders), exactly(expected, 1), 1e-4, placement);
  }
}

TEST(Vpl, SameBitsAtAnyThreadCount) {
  const std::string scene_xml =
      inside_sphere("<bsdf type=\"roughplastic\"/>") + kLamp + kView + clustered_xml(5000);
  const Image one = render_finite(scene_xml, 1);
  const Image three = render_finite(scene_xml, 3);
  EXPECT_EQ(one.data, three.data);
}

/// Scales from 1e-6 to 1e6: the radiance is that of the unit scene if intensity grows with the
/// square of the size.
TEST(Vpl, DoesNotDependOnTheUnitOfLength) {
  for (const float scale : {1e-6f, 1e6f}) {
    char intensity[32], radius[32], eye[32];
    std::snprintf(intensity, sizeof intensity, "%.9g", 4.0 * scale * scale);
    std::snprintf(radius, sizeof radius, "%.9g", kRadius * static_cast<double>(scale));
    std::snprintf(eye, sizeof eye, "%.9g", 0.7 * scale);
    const std::string scene_xml =
        "<shape type=\"sphere\"><float name=\"radius\" value=\"" + std::string(radius) +
        "\"/><boolean name=\"flip_normals\" value=\"true\"/>" + diffuse_xml("0.5") +
        "</shape><emitter type=\"point\"><float name=\"intensity\" value=\"" + intensity +
        "\"/></emitter><sensor type=\"perspective\"><float name=\"near_clip\" value=\"1e-12\"/>"
        "<float name=\"far_clip\" value=\"1e9\"/><transform name=\"to_world\">" +
        look_at(std::string(eye) + " 0 0", "0 0 0") +
        "</transform><film type=\"hdrfilm\"><integer name=\"width\" value=\"3\"/><integer "
        "name=\"height\" value=\"3\"/><rfilter type=\"box\"/></film></sensor>" +
        bounce_xml("groundtruth", 200);
    expect_everywhere(render_finite(scene_xml), Rgb(0.5f / kPi * 1.5f), rounding(200));
  }
}

TEST(Vpl, LightThatNothingReflects) {
  const std::string view = kView + clustered_xml(300);
  const std::string ball = "<shape type=\"sphere\"><bsdf type=\"diffuse\"/></shape>";
  // A lamp inside a solid that reflects only on its outside; a lamp that emits away from the solid;
  // a mirror; a black surface.
  const std::string away = "<emitter type=\"spot\"><transform name=\"to_world\">" +
                           look_at("0 0 5", "0 0 9", "0 1 0") + "</transform></emitter>";
  const std::string mirror = "<shape type=\"sphere\"><bsdf type=\"conductor\"/></shape>";
  const std::string black = "<shape type=\"sphere\">" + diffuse_xml("0") + "</shape>";
  for (const std::string& scene : {ball + kLamp, ball + away, mirror + kLamp, black + kLamp}) {
    for (const std::string& vpl : {vpl_xml("", "surface"), vpl_xml("", "traced"), std::string()}) {
      testing::internal::CaptureStderr();
      render_finite("\n" + vpl + scene + view);
      const std::string warning = testing::internal::GetCapturedStderr();
      // The warning is at the emitter's position if the scene has one, and never names a plugin
      // that the scene doesn't.
      EXPECT_EQ(warning.find(vpl.empty() ? "kinome: warning: test.xml: no "
                                         : "kinome: warning: test.xml:2:1: no "),
                0u)
          << warning;
      EXPECT_NE(warning.find("the image shows direct light only"), std::string::npos);
      EXPECT_EQ(warning.find("vpl"), std::string::npos) << warning;
      EXPECT_EQ(std::count(warning.begin(), warning.end(), '\n'), 1) << warning;
      set_log_level(LogLevel::kQuiet);
      EXPECT_NE(skipped(scene + vpl + view).find("indirect light: no "), std::string::npos);
      set_log_level(LogLevel::kWarn);
    }
  }
}

/// Returns the warnings of loading a scene.
std::string warning_text(const std::string& scene_xml) {
  testing::internal::CaptureStderr();
  scene_from(scene_xml);
  return testing::internal::GetCapturedStderr();
}

/// An integrator that doesn't use the emitter warns once, with its position.
TEST(Vpl, WarnsIfItIsIgnored) {
  const std::string scene_xml = "\n" + vpl_xml(kLamp, "traced") + inside_sphere("") + kView;
  const std::string distant = "<string name=\"mode\" value=\"distant\"/>";
  const auto plain = [](const std::string& type) { return "<integrator type=\"" + type + "\"/>"; };
  for (const std::string& integrator :
       {plain("direct"), plain("path"), plain("ptracer"), depth_2("clustered"),
        depth_2("groundtruth"), bounce_xml("clustered", 10, distant)}) {
    const std::string warning = warning_text(scene_xml + integrator);
    EXPECT_EQ(warning.find("kinome: warning: test.xml:2:1: "), 0u) << integrator << warning;
    EXPECT_NE(warning.find("this emitter is ignored: it represents one bounce"), std::string::npos)
        << warning;
    EXPECT_EQ(std::count(warning.begin(), warning.end(), '\n'), 1) << warning;
  }
  EXPECT_EQ(warning_text(scene_xml + bounce_xml("clustered", 10)), "");
  EXPECT_EQ(warning_text(inside_sphere("") + kLamp + kView + plain("path")), "");
}

TEST(Vpl, LightsOfEveryKindAtOnce) {
  const std::string lamps =
      kLamp + "<emitter type=\"constant\"/>" +
      "<emitter type=\"spot\"><transform name=\"to_world\">" + look_at("0 3 3", "0 0 0") +
      "</transform></emitter><emitter type=\"spot\"><transform name=\"to_world\">" +
      look_at("2 3 0", "0 0 0") + "</transform></emitter>" +
      "<shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"90\"/>"
      "<translate y=\"4\"/></transform><emitter type=\"area\"/></shape>";
  const std::string scene_xml = lamps + floor_xml("<bsdf type=\"roughplastic\"/>") +
                                "<shape type=\"sphere\"/>" +
                                sensor_xml("perspective", look_at("0 2 6", "0 0 0", "0 1 0"), 6, 4);
  render_finite(scene_xml + bounce_xml("groundtruth", 200));
  render_finite(scene_xml + bounce_xml("clustered", 200), 0, -1);
}

/// Light points close to the visible points, in their plane and in corners, and a million of them.
TEST(Vpl, HardPoints) {
  const std::string tiny =
      "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"1e-3\"/></transform>"
      "<bsdf type=\"twosided\"><bsdf type=\"diffuse\"/></bsdf></shape>"
      "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"1\"/></emitter>" +
      sensor_xml("perspective", look_at("0 0 2e-2", "0 0 0", "0 1 0"), 8, 16);
  render_finite(tiny + clustered_xml(3000));
  const std::string corner =
      floor_xml(diffuse_xml("0.5")) +
      "<shape type=\"cube\"><bsdf type=\"diffuse\"/></shape><emitter type=\"point\"><point "
      "name=\"position\" x=\"3\" y=\"3\" z=\"3\"/></emitter>" +
      sensor_xml("perspective", look_at("1.01 0.1 1.4", "1 0 1", "0 1 0"), 16, 16);
  render_finite(corner + clustered_xml(1000));
  render_finite(inside_sphere(diffuse_xml("0.5")) + kLamp +
                sensor_xml("perspective", look_at("0.7 0.2 0.1", "0 -1 0.3"), 1, 1) +
                clustered_xml(1 << 20));
}

TEST(Vpl, ReportsErrors) {
  const std::string rest = inside_sphere(diffuse_xml("0.5")) + kView;
  EXPECT_NE(error_text(rest + vpl_xml(vpl_xml(kLamp, "traced"), "traced"))
                .find("must not be another 'vpl'"),
            std::string::npos);
  EXPECT_NE(error_text(rest + vpl_xml(kLamp, "trace")).find("'traced'"), std::string::npos);
  EXPECT_NE(error_text(rest + vpl_xml("<emitter type=\"area\"/>", "traced"))
                .find("isn't part of a shape"),
            std::string::npos);
  EXPECT_NE(
      error_text(rest + vpl_xml(kLamp, "traced", "<integer name=\"light_samples\" value=\"-1\"/>"))
          .find("light_samples"),
      std::string::npos);
  EXPECT_NE(error_text(rest + kLamp +
                       "<integrator type=\"clustered\"><integer name=\"max_depth\" "
                       "value=\"-2\"/></integrator>")
                .find("max_depth"),
            std::string::npos);
}

TEST(Vpl, SkipsUnusedPoints) {
  const std::string rest = inside_sphere(diffuse_xml("0.5")) + kLamp + kView;
  const std::string direct = skipped(rest + depth_2("clustered", kJoint));
  EXPECT_NE(direct.find("indirect light: max_depth is 2"), std::string::npos) << direct;
  EXPECT_NE(direct.find("light tree: no emitter has light points"), std::string::npos);
  const std::string distant = skipped(
      rest + bounce_xml("clustered", 10, kJoint + "<string name=\"mode\" value=\"distant\"/>"));
  EXPECT_NE(distant.find("indirect light: mode is 'distant'"), std::string::npos) << distant;
}

}  // namespace
}  // namespace kinome::test
