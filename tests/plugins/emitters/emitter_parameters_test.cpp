/// Tests which parameters emitters accept and reject.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <optional>

#include "kinome/emitter.h"
#include "support/shape_helpers.h"

namespace kinome::test::emitter_parameters_test {
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
const std::string kHuge = "<transform name='to_world'><scale z='1e35'/></transform>";
const std::string kProjective =
    "<transform name='to_world'><matrix value='1 0 0 0  0 1 0 0  0 0 1 0  0 1 0 1'/></transform>";
const std::string kShear =
    "<transform name='to_world'><scale x='2'/><rotate z='1' angle='30'/><scale x='2'/></transform>";
const std::string kTurn = "<transform name='to_world'><rotate x='1' angle='20'/></transform>";
const std::string kChecks = "<texture type='checkerboard' name='texture'/>";

const std::string kBright = "<rgb name='irradiance' value='1 1 6e35'/>";

struct Refused {
  std::string type;
  std::string parameters;
  std::string name;     ///< of the parameter that the error names
  std::string message;  ///< part of the error
};

TEST(EmitterParameters, BadValuesAreErrorsThatNameThem) {
  const auto negative = [&](const std::string& name) {
    return "<rgb name='" + name + "' value='1 -1 1'/>";
  };
  const std::vector<Refused> cases = {
      {"point", negative("intensity"), "intensity", "between 0 and 1e36, got 1 -1"},
      {"spot", negative("intensity"), "intensity", "between 0 and 1e36"},
      {"spot", negative("texture"), "texture", "between 0 and 1e36"},
      {"directional", negative("irradiance"), "irradiance", "between 0 and 1e36"},
      {"projector", negative("irradiance"), "irradiance", "between 0 and 1e36"},
      {"area", negative("radiance"), "radiance", "between 0 and 1e36"},
      {"constant", negative("radiance"), "radiance", "between 0 and 1e36"},
      {"projector", number("scale", "-1"), "scale", "not negative, got -1"},
      {"point", kTurn + "<point name='position' value='1 2 3'/>", "to_world", "position"},
      {"directional", kTurn + "<vector name='direction' value='1 2 3'/>", "to_world", "direction"},
      {"directional", "<vector name='direction' value='0 0 0'/>", "direction", "not zero"},
      {"spot", number("cutoff_angle", "0"), "cutoff_angle", "greater than 0"},
      {"spot", number("cutoff_angle", "-20"), "cutoff_angle", "got -20"},
      {"spot", number("cutoff_angle", "180.5"), "cutoff_angle", "at most 180"},
      {"spot", angles("20", "21"), "beam_width", "between 0 and cutoff_angle (20"},
      {"spot", angles("20", "-1"), "beam_width", "got -1"},
      {"spot", number("cutoff_angle", "90") + kChecks, "texture", "less than 90 degrees, got 90"},
      {"spot", number("cutoff_angle", "135") + kChecks, "texture", "got 135"},
      {"spot", kStretch, "to_world", "must have a uniform scale"},
      {"spot", kShear, "to_world", "without shear"},
      {"spot", kProjective, "to_world", "affine"},
      {"point", kProjective, "to_world", "affine"},
      {"directional", kProjective, "to_world", "affine"},
      {"projector", kProjective, "to_world", "affine"},
      {"projector", kShear, "to_world", "without shear"},
      {"directional", kHuge + "<rgb name='irradiance' value='1e3 1 1'/>", "to_world",
       "beyond 1e36"},
      {"projector", number("scale", "1e37"), "scale", "at most 1e36"},
      {"projector", number("scale", "3e38") + "<rgb name='irradiance' value='0 1e-3 0'/>", "scale",
       "at most 1e36, got"},
      {"projector", number("scale", "5e35") + number("fov", "170"), "scale", "at most 1e36, got"},
      {"projector", number("scale", "2") + kBright, "scale", "at most 1e36"},
      {"spot", "<rgb name='intensity' value='1 2 3e36'/>", "intensity", "between 0 and 1e36"},
      {"spot", "<rgb name='intensity' value='1 2 1e36'/><rgb name='texture' value='1 3 1'/>",
       "intensity", "at most 1e36"},
      {"projector", number("fov", "0"), "fov", "greater than 0 and less than 180 degrees, got 0"},
      {"projector", number("fov", "180"), "fov", "got 180"},
      {"projector", number("fov", "-30"), "fov", "got -30"},
      {"projector", number("fov", "40") + "<string name='focal_length' value='50mm'/>",
       "focal_length", "can't be combined with 'fov'"},
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

TEST(EmitterParameters, TexelsBeyondTheBoundOfLightAreErrors) {
  const TemporaryFolder folder;
  for (const float texel : {2e36f, -2e36f}) {
    std::string image = "PF\n1 1\n-1\n";
    for (const float value : {1.f, texel, 1.f}) {
      const auto bytes = std::bit_cast<std::array<char, sizeof(float)>>(value);
      image.append(bytes.begin(), bytes.end());
    }
    const std::string file = folder.write("texel.pfm", image);
    for (const auto& [type, name] : {std::pair<std::string, std::string>{"area", "radiance"},
                                     {"spot", "texture"},
                                     {"projector", "irradiance"}}) {
      const std::string xml = emitter_xml(
          type, "<texture type='bitmap' name='" + name + "'><string name='filename' value='" +
                    file + "'/><boolean name='raw' value='true'/></texture>");
      const std::string error = error_of([&] { make<Emitter>(xml); });
      EXPECT_NE(error.find("'" + name + "'"), std::string::npos) << xml << ": " << error;
      EXPECT_NE(error.find("at most 1e36, got 2e36"), std::string::npos) << xml << ": " << error;
    }
  }
}

/// Limits of the ranges, and values that Mitsuba accepts, too.
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
        {"projector", kStretch},
        {"projector", kScale},
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

/// <float> is grey, <rgb> is unchanged, and <spectrum> uses the equal-energy white of light.
TEST(EmitterParameters, ColoursAreOfEmittedLight) {
  const auto green_of = [](const std::string& color) {
    const auto light = make<Emitter>(emitter_xml("projector", number("fov", "90") + color))
                           ->sample_direct(Vec3(0, 0, 1), Vec2(0.5f));
    return light->radiance * kInvPi;
  };
  EXPECT_NEAR(green_of("<float name='irradiance' value='2'/>").x, 2, 1e-5);
  EXPECT_NEAR(green_of("<rgb name='irradiance' value='1 2 3'/>").z, 3, 1e-5);
  const Rgb white = green_of("<spectrum name='irradiance' value='2'/>");
  EXPECT_NEAR(white.x, 2 * 1.204794f, 1e-4);
  EXPECT_NEAR(white.z, 2 * 0.908916f, 1e-4);
  // Value of Mitsuba 3.9.1 for the light of the Cornell box.
  const Rgb box =
      green_of("<spectrum name='irradiance' value='400:0, 500:8, 600:15.6, 700:18.4'/>");
  EXPECT_NEAR(box.x, 20.7108f, 1e-2);
  EXPECT_NEAR(box.y, 10.8546f, 1e-2);
  EXPECT_NEAR(box.z, 2.7712f, 1e-2);
}

/// Light that arrives at a point, and the warnings that loading the emitter caused.
struct Scaled {
  std::optional<DirectSample> light;
  std::string warning;
};
Scaled scaled_light(const std::string& type, const std::string& scale, const Vec3& p) {
  testing::internal::CaptureStderr();
  const auto emitter =
      make<Emitter>(emitter_xml(type, "<transform name='to_world'>" + scale + "</transform>" +
                                          (type == "projector" ? number("fov", "60") : "")));
  return {emitter->sample_direct(p, Vec2(0.5f)), testing::internal::GetCapturedStderr()};
}

/// Values of Mitsuba 3.9.1, scalar_rgb, for a white diffuse floor across the axis at distance 1.
/// The irradiance of a projector is scaled by the scale of z, and its image has the half width
/// tan(30°) times x / z. The irradiance of a directional light is scaled by the scale of z.
TEST(EmitterParameters, ScaleHasMitsubasMeaning) {
  const float half = std::tan(kPi / 6);
  for (const Vec3& scale :
       {Vec3(1), Vec3(2), Vec3(.5f), Vec3(2, 1, 1), Vec3(1, 2, 1), Vec3(1, 1, 2), Vec3(-1, 1, 1)}) {
    const std::string xml = "<scale x='" + std::to_string(scale.x) + "' y='" +
                            std::to_string(scale.y) + "' z='" + std::to_string(scale.z) + "'/>";
    const Vec2 edge = half * Vec2(std::abs(scale.x), scale.y) / scale.z;
    for (const float side : {-1.f, 1.f}) {
      for (const Vec2& axis : {Vec2(1, 0), Vec2(0, 1)}) {
        const Vec2 inside = side * 0.999f * edge * axis, outside = side * 1.001f * edge * axis;
        const auto seen = scaled_light("projector", xml, Vec3(inside, 1)).light;
        ASSERT_TRUE(seen) << xml;
        const float cosine = -seen->d.z;
        EXPECT_NEAR(seen->radiance.x * cosine, kPi * scale.z, 1e-5f * kPi * scale.z) << xml;
        EXPECT_FALSE(scaled_light("projector", xml, Vec3(outside, 1)).light) << xml;
      }
    }
    const Scaled parallel = scaled_light("directional", xml, Vec3(0.f));
    EXPECT_NEAR(parallel.light->radiance.x, scale.z, 1e-6f * scale.z) << xml;
    EXPECT_EQ(parallel.light->d, Vec3(0, 0, -1));
    EXPECT_EQ(parallel.warning.find("kinome: warning: test.xml:1:"),
              scale.z == 1 ? std::string::npos : 0u)
        << parallel.warning;
  }
}

/// The cosines of the angles of such a narrow spot are equal in single precision.
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

/// At the position of the light there is no direction. Next to it, all values are finite.
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
}  // namespace kinome::test::emitter_parameters_test
