/// What emitters refuse, and what they take.
#include <gtest/gtest.h>

#include "kinome/emitter.h"
#include "shape_helpers.h"

namespace kinome::test {
namespace {

std::string emitter_xml(const std::string& type, const std::string& parameters) {
  return "<emitter type='" + type + "'>" + parameters + "</emitter>";
}
std::string number(const std::string& name, const std::string& value) {
  return "<float name='" + name + "' value='" + value + "'/>";
}
std::string angles(const std::string& cutoff, const std::string& beam_width) {
  return number("cutoff_angle", cutoff) + number("beam_width", beam_width);
}

const std::string kStretch = "<transform name='to_world'><scale x='2' y='1' z='1'/></transform>";
const std::string kScale = "<transform name='to_world'><scale value='2'/></transform>";
const std::string kTurn = "<transform name='to_world'><rotate x='1' angle='20'/></transform>";
const std::string kChecks = "<texture type='checkerboard' name='texture'/>";

struct Refused {
  std::string type;
  std::string parameters;
  std::string name;     ///< of the parameter that the error is about
  std::string message;  ///< part of it
};

TEST(EmitterParameters, BadValuesAreErrorsThatNameThem) {
  const auto negative = [&](const std::string& name) {
    return "<rgb name='" + name + "' value='1 -1 1'/>";
  };
  const std::vector<Refused> cases = {
      {"point", negative("intensity"), "intensity", "not negative, got 1.000000 -1"},
      {"spot", negative("intensity"), "intensity", "not negative"},
      {"spot", negative("texture"), "texture", "not negative"},
      {"directional", negative("irradiance"), "irradiance", "not negative"},
      {"projector", negative("irradiance"), "irradiance", "not negative"},
      {"area", negative("radiance"), "radiance", "not negative"},
      {"constant", negative("radiance"), "radiance", "not negative"},
      {"projector", number("scale", "-1"), "scale", "not negative, got -1"},
      {"point", kTurn + "<point name='position' value='1 2 3'/>", "to_world", "position"},
      {"directional", kTurn + "<vector name='direction' value='1 2 3'/>", "to_world", "direction"},
      {"directional", "<vector name='direction' value='0 0 0'/>", "direction", "not zero"},
      {"spot", number("cutoff_angle", "0"), "cutoff_angle", "greater than 0"},
      {"spot", number("cutoff_angle", "-20"), "cutoff_angle", "got -20"},
      {"spot", number("cutoff_angle", "180.5"), "cutoff_angle", "at most 180"},
      {"spot", angles("20", "21"), "beam_width", "between 0 and cutoff_angle (20"},
      {"spot", angles("20", "-1"), "beam_width", "got -1"},
      {"spot", number("cutoff_angle", "90") + kChecks, "texture", "below 90"},
      {"spot", kStretch, "to_world", "without shear"},
      {"projector", kStretch, "to_world", "must not scale"},
      {"projector", kScale, "to_world", "must not scale"},
      {"projector", number("fov", "0"), "fov", "between 0 and 180 degrees, got 0"},
      {"projector", number("fov", "180"), "fov", "got 180"},
      {"projector", number("fov", "-30"), "fov", "got -30"},
      {"projector", number("fov", "40") + "<string name='focal_length' value='50mm'/>",
       "focal_length", "together"},
      {"projector", "<string name='focal_length' value='0mm'/>", "focal_length", "positive"},
      {"projector", number("fov", "40") + "<string name='fov_axis' value='z'/>", "fov_axis", "'x'"},
  };
  for (const Refused& refused : cases) {
    const std::string xml = emitter_xml(refused.type, refused.parameters);
    const std::string error = error_of([&] { make<Emitter>(xml); });
    EXPECT_EQ(error.rfind("test.xml:1:", 0), 0u) << xml << ": " << error;
    EXPECT_NE(error.find("'" + refused.name + "'"), std::string::npos) << xml << ": " << error;
    EXPECT_NE(error.find(refused.message), std::string::npos) << xml << ": " << error;
  }
}

/// Limits, and what Mitsuba takes, too.
TEST(EmitterParameters, LimitsAreTaken) {
  for (const auto& [type, parameters] :
       {std::pair<std::string, std::string>{"spot", angles("20", "20")},
        {"spot", angles("20", "0")},
        {"spot", angles("90", "90")},
        {"spot", angles("180", "180")},
        {"spot", angles("1e-3", "1e-4")},
        {"spot", kScale},
        {"spot", kTurn + number("cutoff_angle", "89") + kChecks},
        {"point", kStretch},
        {"directional", kScale},
        {"projector", number("fov", "179")},
        {"projector", number("fov", "0.01")},
        {"projector", ""}}) {
    const std::string xml = emitter_xml(type, parameters);
    EXPECT_EQ(error_of([&, text = xml] {
                const auto emitter = make<Emitter>(text);
                emitter->prepare({Vec3(-1), Vec3(1)});
                Random random(51);
                for (int i = 0; i < 1000; ++i) {
                  const Vec2 u(random.unit(), random.unit()), v(random.unit(), random.unit());
                  const auto light = emitter->sample_direct(random.direction(), u);
                  EXPECT_TRUE(!light || is_finite(light->radiance)) << text;
                  const auto ray = emitter->sample_emission(u, v);
                  ASSERT_TRUE(ray || text.find("checkerboard") != std::string::npos) << text;
                  ASSERT_TRUE(!ray || (is_finite(ray->power) && is_finite(ray->d))) << text;
                }
              }),
              "");
  }
}

/// <float> is grey, <rgb> itself, <spectrum> the equal-energy white of light.
TEST(EmitterParameters, ColoursAreThoseOfLight) {
  const auto green_of = [](const std::string& color) {
    const auto light = make<Emitter>(emitter_xml("projector", number("fov", "90") + color))
                           ->sample_direct(Vec3(0, 0, 1), Vec2(0.5f));
    return light->radiance * kInvPi;
  };
  EXPECT_NEAR(green_of("<float name='irradiance' value='2'/>").x, 2, 1e-5);
  EXPECT_NEAR(green_of("<rgb name='irradiance' value='1 2 3'/>").z, 3, 1e-5);
  const Rgb white = green_of("<spectrum name='irradiance' value='2'/>");
  EXPECT_NEAR(white.x, 2 * 1.20488f, 1e-4);
  EXPECT_NEAR(white.z, 2 * 0.90927f, 1e-4);
}

/// A spot so narrow that cosines can't tell its angles apart.
TEST(EmitterParameters, NarrowSpotKeepsItsFalloff) {
  const auto spot = make<Emitter>(emitter_xml("spot", angles("0.004", "0.002")));
  for (const float degrees : {0.f, 0.001f, 0.0025f, 0.003f, 0.0035f}) {
    const float x = std::tan(degrees * kPi / 180);
    const auto light = spot->sample_direct(Vec3(x, 0, 1), Vec2(0.5f));
    ASSERT_TRUE(light);
    EXPECT_NEAR(light->radiance.x, degrees <= 0.002f ? 1 : (0.004f - degrees) / 0.002f, 1e-3);
  }
  EXPECT_FALSE(spot->sample_direct(Vec3(std::tan(0.0041f * kPi / 180), 0, 1), Vec2(0.5f)));
}

/// At the light itself there is no direction; right beside it all is finite.
TEST(EmitterParameters, NothingIsInfiniteAtTheLight) {
  for (const char* type : {"point", "spot", "projector"}) {
    const auto light = make<Emitter>(emitter_xml(type, ""));
    EXPECT_FALSE(light->sample_direct(Vec3(0.f), Vec2(0.5f))) << type;
    for (const float z : {1e-38f, 1e-20f, 1e-10f, 1e-3f, 1e10f, 1e25f, 1e38f}) {
      const auto sample = light->sample_direct(Vec3(0, 0, z), Vec2(0.5f));
      if (!sample) continue;
      EXPECT_TRUE(is_finite(sample->radiance) && is_finite(sample->d)) << type << " at " << z;
      EXPECT_NEAR(glm::length(sample->d), 1, 1e-5f) << type << " at " << z;
    }
    EXPECT_TRUE(light->sample_direct(Vec3(0, 0, 1e-10f), Vec2(0.5f))) << type;
  }
}

}  // namespace
}  // namespace kinome::test
