#include "kinome/sensor.h"

#include <gtest/gtest.h>

#include "mitsuba_rays.h"
#include "support/render.h"

namespace kinome::test::sensor_test {
namespace {

TEST(Sensor, RaysAreMitsubas) {
  for (const SensorCase& c : kSensorCases) {
    const auto sensor = make<Sensor>(c.xml);
    for (const ExpectedRay& e : c.rays) {
      const Ray ray = sensor->sample_ray(e.film_position, e.aperture);
      // Mitsuba uses single-precision matrices and their inverses: some ten roundings of 6e-8 at
      // coordinates up to 4.
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(ray.d[i], e.d[i], 2e-6f) << c.xml;
        EXPECT_NEAR(ray.at(ray.tmin)[i], e.o[i], 4e-6f) << c.xml;
      }
      EXPECT_NEAR(ray.tmax - ray.tmin, e.length, 4e-6f * e.length) << c.xml;
      EXPECT_NEAR(glm::length(ray.d), 1.f, 2e-7f);
    }
  }
}

std::shared_ptr<Sensor> make_sensor(const std::string& type, const std::string& body) {
  return make<Sensor>("<sensor type=\"" + type + "\">" + body + "</sensor>");
}

TEST(Sensor, LooksAlongZWithXToTheLeft) {
  for (const char* type : {"perspective", "orthographic"}) {
    const auto sensor = make_sensor(type, "");
    EXPECT_FALSE(sensor->needs_aperture_sample());
    const auto at = [&](float x, float y) {
      const Ray ray = sensor->sample_ray({x, y}, {0.5f, 0.5f});
      return ray.at(1.f);
    };
    EXPECT_GT(at(384, 288).z, 0.9f);
    EXPECT_GT(at(0, 288).x, 0.1f) << "the image's left is +X";
    EXPECT_LT(at(768, 288).x, -0.1f);
    EXPECT_GT(at(384, 0).y, 0.1f) << "its top is +Y";
  }
}

TEST(Sensor, ThinLensIsSharpAtItsFocus) {
  const auto sensor =
      make_sensor("thinlens",
                  "<float name=\"fov\" value=\"50\"/><float name=\"aperture_radius\" value=\".3\"/>"
                  "<float name=\"focus_distance\" value=\"4\"/>");
  const auto pinhole = make_sensor("perspective", "<float name=\"fov\" value=\"50\"/>");
  EXPECT_TRUE(sensor->needs_aperture_sample());
  const Ray straight = pinhole->sample_ray({100, 50}, {});
  const Vec3 focus = straight.at(4 / straight.d.z);
  float spread = 0;
  for (const Vec2 u : {Vec2(0.f), Vec2(0.5f), Vec2(0.9f, 0.2f), Vec2(0.1f, 0.7f)}) {
    const Ray ray = sensor->sample_ray({100, 50}, u);
    EXPECT_LE(glm::length(ray.o), 0.3f * 1.000001f);
    EXPECT_NEAR(ray.o.z, 0.f, 1e-7f);
    spread = std::max(spread, glm::length(ray.o));
    EXPECT_LT(glm::length(ray.at(4 / ray.d.z) - focus), 4e-6f);
    EXPECT_NEAR(ray.tmin * ray.d.z, 0.01f, 1e-7f);
  }
  EXPECT_NEAR(spread, 0.3f, 1e-6f) << "the square's corner maps to the lens's edge";
}

void expect_error(const std::string& type, const std::string& body, const std::string& part) {
  try {
    make_sensor(type, body);
    ADD_FAILURE() << "no error for " << type << body;
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    EXPECT_NE(e.where().line, 0) << e.what();
  }
}
std::string number(const char* name, const char* value) {
  return std::string("<float name=\"") + name + "\" value=\"" + value + "\"/>";
}
std::string text(const char* name, const char* value) {
  return std::string("<string name=\"") + name + "\" value=\"" + value + "\"/>";
}

TEST(Sensor, RefusesInvalidParameters) {
  const std::string scale = "<transform name=\"to_world\"><scale value=\"2\"/></transform>";
  expect_error("perspective", number("fov", "0"), "fov");
  expect_error("perspective", number("fov", "180"), "fov");
  expect_error("perspective", number("fov", "30") + text("focal_length", "50mm"),
               "can't be combined with 'fov'");
  expect_error("perspective", text("focal_length", "wide"), "focal_length");
  expect_error("perspective", text("focal_length", "-3mm"), "focal_length");
  expect_error("perspective", number("fov", "30") + text("fov_axis", "z"), "fov_axis");
  expect_error("perspective", number("near_clip", "0"), "near_clip");
  expect_error("perspective", number("far_clip", ".001"), "far_clip");
  expect_error("perspective", scale, "to_world");
  const std::string projective =
      "<transform name=\"to_world\"><matrix value=\"1 0 0 0  0 1 0 0  0 0 1 0  0 1 0 1\"/>"
      "</transform>";
  for (const char* type : {"perspective", "thinlens", "orthographic"}) {
    const bool has_aperture = type == std::string("thinlens");
    expect_error(type, (has_aperture ? number("aperture_radius", "1") : "") + projective,
                 "'to_world' must be an affine transform, got a projective one");
  }
  expect_error("thinlens", scale + number("aperture_radius", "1"), "to_world");
  expect_error("perspective", number("shutter_open", "1"), "shutter_close");
  expect_error("thinlens", "", "aperture_radius");
  expect_error("thinlens", number("aperture_radius", "0"), "aperture_radius");
  expect_error("thinlens", number("aperture_radius", "1") + number("focus_distance", "-1"),
               "focus_distance");
  expect_error("orthographic", number("fov", "30"), "fov");
  make_sensor("orthographic", scale);
  make_sensor("perspective", "<transform name=\"to_world\"><scale value=\"-1 1 1\"/></transform>");
}

TEST(Sensor, HasAFilmAndASamplerOfItsOwnWhereTheSceneNamesNone) {
  const auto sensor = make_sensor("perspective", "");
  EXPECT_EQ(sensor->film().width(), 768);
  EXPECT_EQ(sensor->sampler().sample_count(), 4u);
}

}  // namespace
}  // namespace kinome::test::sensor_test
