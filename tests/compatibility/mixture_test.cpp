/// Smooth glass in blends and masks, and conductors with negative parts of the index. Mitsuba 3.9.1
/// renders blends with smooth parts too dark (docs/limits.md). Expected values are therefore closed
/// forms, or come from paths traced from the other end.
#include <gtest/gtest.h>

#include <cmath>

#include "support/shape_helpers.h"

namespace kinome::test::mixture_test {
namespace {

const std::string kGlass = "<bsdf type=\"dielectric\"/>";
const std::string kDiffuse = "<bsdf type=\"diffuse\"/>";
const std::string kNull = "<bsdf type=\"null\"/>";

std::string blend(const char* weight, const std::string& first, const std::string& second) {
  return std::string("<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"") + weight +
         "\"/>" + first + second + "</bsdf>";
}
std::string mask(const char* opacity, const std::string& nested) {
  return std::string("<bsdf type=\"mask\"><float name=\"opacity\" value=\"") + opacity + "\"/>" +
         nested + "</bsdf>";
}
std::string integrator_xml(const std::string& type) {
  return "<integrator type=\"" + type + "\"/>";
}
std::string sensor_xml(const char* type, const char* lookat, int samples, int side) {
  return std::string("<sensor type=\"") + type + "\"><transform name=\"to_world\"><lookat " +
         lookat + "/></transform><sampler type=\"independent\"><integer name=\"sample_count\" "
                  "value=\"" +
         std::to_string(samples) + "\"/></sampler><film type=\"hdrfilm\"><integer name=\"width\" "
                                   "value=\"" +
         std::to_string(side) + "\"/><integer name=\"height\" value=\"" + std::to_string(side) +
         "\"/><rfilter type=\"box\"/><string name=\"component_format\" value=\"float32\"/></film>"
         "</sensor>";
}

/// Estimates the mean of an image's red channel.
Estimate mean_over_renders(const Scene& scene, int renders) {
  Moments means;
  for (int seed = 1; seed <= renders; ++seed) {
    const Image image = render_scene(scene, static_cast<uint64_t>(seed));
    double sum = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, 0));
    }
    means.add(sum / (image.width * image.height));
  }
  return {means.mean(), means.variance_of_mean()};
}

constexpr int kRenders = 16;
/// Student's t with 15 degrees of freedom, which is exceeded with probability 1e-5.
constexpr double kMaxDeviations = 6.5;

TEST(Mixture, OfSmoothGlassIsTheSumOfItsParts) {
  const double eta = 1.5046 / 1.000277, reflected = std::pow((eta - 1) / (eta + 1), 2);
  // Seen at normal incidence, under a sky of 1. Radiance from inside is divided by the squared
  // index.
  const double glass = reflected + (1 - reflected) / (eta * eta);
  const struct {
    std::string bsdf;
    double expected;
  } cases[] = {
      {blend("0.3", kGlass, kDiffuse), 0.7 * glass + 0.3 * 0.5},
      {blend("0.3", kDiffuse, kGlass), 0.7 * 0.5 + 0.3 * glass},
      {blend("0.3", kGlass, kNull), 0.7 * glass + 0.3},
      {mask("0.4", kGlass), 0.4 * glass + 0.6},
      {blend("0.5", kGlass, mask("0.5", kGlass)), 0.75 * glass + 0.25},
  };
  for (const auto& c : cases) {
    const std::string rest =
        sensor_xml("orthographic", "origin=\"0,0,4\" target=\"0,0,0\" up=\"0,1,0\"", 32, 8) +
        "<emitter type=\"constant\"/><shape type=\"rectangle\"><transform name=\"to_world\">"
        "<scale value=\"9\"/></transform>" +
        c.bsdf + "</shape>";
    for (const char* type : {"path", "direct", "clustered"}) {
      const Estimate mean = mean_over_renders(*scene_from(integrator_xml(type) + rest), kRenders);
      EXPECT_NEAR(mean.mean, c.expected, kMaxDeviations * std::sqrt(mean.variance_of_mean) + 1e-5)
          << type << c.bsdf;
    }
  }
}

/// Light paths distinguish delta lobes that refract from those that transmit straight through.
TEST(Mixture, OfSmoothGlassIsTheSameFromBothEnds) {
  const std::string rest =
      sensor_xml("perspective", "origin=\"0,0.5,1\" target=\"0,-1,0\" up=\"0,1,0\"", 256, 8) +
      "<shape type=\"rectangle\"><transform name=\"to_world\"><rotate x=\"1\" angle=\"90\"/>"
      "<translate y=\"2\"/></transform><emitter type=\"area\"><rgb name=\"radiance\" value=\"9\"/>"
      "</emitter></shape>"
      "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/>"
      "<rotate x=\"1\" angle=\"-90\"/><translate y=\"-1\"/></transform></shape>"
      "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"4\"/>"
      "<rotate x=\"1\" angle=\"-90\"/><translate y=\"1\"/></transform>";
  for (const std::string& bsdf :
       {blend("0.4", kGlass, kDiffuse), blend("0.4", kNull, kGlass), mask("0.5", kGlass)}) {
    const std::string body = rest + bsdf + "</shape>";
    const Estimate path = mean_over_renders(*scene_from(integrator_xml("path") + body), kRenders);
    const Estimate back =
        mean_over_renders(*scene_from(integrator_xml("ptracer") + body), kRenders);
    EXPECT_GT(path.mean, 0.05);
    const double deviation = std::sqrt(path.variance_of_mean + back.variance_of_mean);
    EXPECT_NEAR(path.mean, back.mean, kMaxDeviations * deviation) << bsdf;
    EXPECT_LT(deviation, 0.015 * path.mean) << bsdf;
  }
}

TEST(Mixture, OfTwoIndicesOfSmoothGlassIsAnError) {
  const std::string other =
      "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.2\"/></bsdf>";
  const std::string error = error_of([&] { make<Bsdf>(blend("0.5", kGlass, other)); });
  EXPECT_NE(error.find("different indices of refraction"), std::string::npos) << error;
}

/// Fresnel reflectance depends only on the squares of the index's parts.
TEST(Conductor, SignsOfTheIndexHaveNoEffect) {
  for (const char* type : {"conductor", "roughconductor"}) {
    const auto picture = [&](const char* eta, const char* k) {
      return render_scene(*scene_from(
          integrator_xml("path") +
          sensor_xml("perspective", "origin=\"0,1,5\" target=\"0,0,0\" up=\"0,1,0\"", 4, 8) +
          "<emitter type=\"constant\"/><shape type=\"sphere\"><bsdf type=\"" + type +
          "\"><rgb name=\"eta\" value=\"" + eta + "\"/><rgb name=\"k\" value=\"" + k +
          "\"/></bsdf></shape>"));
    };
    EXPECT_EQ(picture("-0.05, 4.1, 4.7", "-0.04, 0.09, -1.3").data,
              picture("0.05, 4.1, 4.7", "0.04, 0.09, 1.3").data)
        << type;
  }
}

}  // namespace
}  // namespace kinome::test::mixture_test
