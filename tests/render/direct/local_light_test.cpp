/// Emitters of local light in the `direct` integrator, against irradiances in closed form.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "direct_scenes.h"
#include "kinome/image_files.h"
#include "render/direct/local_light.h"

namespace kinome::test::local_light_test {
namespace {

using namespace local_light;

/// Returns the irradiance of the floor at (x, z), from the image's green channel. It has no noise
/// for lamps.
double rendered_irradiance(const std::string& light, float x, float z) {
  const auto scene = scene_from(floor_at(x, z) + light + direct_xml());
  RenderContext context({});
  const Image image = render(*scene, *scene->sensors()[0], context);
  EXPECT_EQ(context.job.stats().non_finite_samples, 0u);
  // A BSDF sample can't hit any emitter, so none is drawn.
  EXPECT_EQ(context.job.stats().counters.rays[static_cast<int>(RayKind::kBsdf)], 0u);
  return static_cast<double>(image.at(1, 1, 1)) * kPiD / kAlbedo;
}

/// Relative; the camera sees the point to 1e-4, as does the distance to it.
void expect_irradiance(const std::string& light, float x, float z, double expected,
                       const std::string& name) {
  EXPECT_NEAR(rendered_irradiance(light, x, z), expected, 1e-3 * expected)
      << name << " at " << x << ", " << z;
}

/// Positions on the floor, and their direction from an emitter at (0, height, 0).
struct Place {
  float x, z;
  double distance2(double height) const { return x * x + z * z + height * height; }
  double cosine(double height) const { return height / std::sqrt(distance2(height)); }
};
constexpr Place kPlaces[] = {{0, 0}, {0.5f, 0}, {-1, 0.25f}, {0.3f, -1.5f}, {4, 3}};

TEST(LocalLight, PointFallsOffWithTheSquare) {
  const std::string intensity = "<rgb name=\"intensity\" value=\"1 2 3\"/>";
  for (const Place& place : kPlaces) {
    const double expected = 2 * place.cosine(2) / place.distance2(2);
    expect_irradiance(light_xml("point", "<translate y=\"2\"/>", intensity), place.x, place.z,
                      expected, "to_world");
    expect_irradiance("<emitter type=\"point\"><point name=\"position\" value=\"0 2 0\"/>" +
                          intensity + "</emitter>",
                      place.x, place.z, expected, "position");
  }
}

TEST(LocalLight, SpotFallsOffLinearlyInTheAngle) {
  for (const auto& [cutoff, beam] :
       {std::pair{20., 15.}, {40., 10.}, {60., 0.}, {30., 30.}, {90., 20.}, {180., 100.}}) {
    const std::string light = light_xml(
        "spot", kDown,
        "<float name=\"intensity\" value=\"3\"/>" + number_xml("cutoff_angle", cutoff) +
            (cutoff == 20 ? "" : number_xml("beam_width", beam)));  // default: 3/4 of the cutoff
    for (const double share : {0., 0.3, 0.6, 0.74, 0.76, 0.8, 0.9, 0.99, 1.01, 1.3}) {
      const double theta = share * cutoff * kPiD / 180;
      if (theta > 1.5) continue;
      const auto x = static_cast<float>(2 * std::tan(theta) * std::cos(0.7));
      const auto z = static_cast<float>(2 * std::tan(theta) * std::sin(0.7));
      const double degrees = share * cutoff;
      const double falloff = degrees <= beam     ? 1
                             : degrees >= cutoff ? 0
                                                 : (cutoff - degrees) / (cutoff - beam);
      const Place place{x, z};
      const double expected = 3 * falloff * place.cosine(2) / place.distance2(2);
      // The camera's view is 1e-4 wide: such an angle, relative to the width of the falloff.
      const double blur = 3e-4 * 3 / (beam < cutoff ? (cutoff - beam) * kPiD / 180 : 1);
      EXPECT_NEAR(rendered_irradiance(light, x, z), expected, 1e-3 * expected + blur)
          << cutoff << ", " << beam << " at " << degrees;
    }
  }
}

/// The values number the texels: rows from the top, each from the left.
Image numbered_image(int width, int height) {
  Image image{width, height, {"R", "G", "B"}, {}};
  for (int i = 0; i < width * height; ++i) {
    const auto value = static_cast<float>(i + 1);
    image.data.insert(image.data.end(), {value, value, value});
  }
  return image;
}

/// (u, v) = 1/2 + 1/2 (x, y) / (z tan(cutoff)). Looking down with up = +z, the emitter's axes x and
/// y are the world's x and z.
TEST(LocalLight, SpotShowsItsTexture) {
  const TemporaryFolder folder;
  write_pfm(folder.path("image.pfm"), numbered_image(4, 2));
  const std::string light =
      light_xml("spot", kDown,
                number_xml("cutoff_angle", 45) + number_xml("beam_width", 45) +
                    nearest_xml("texture", folder.path("image.pfm")));
  for (int row = 0; row < 2; ++row) {
    for (int column = 1; column < 3; ++column) {  // the others are in the corners
      const float x = (static_cast<float>(column) + 0.5f) / 4 * 2 - 1;
      const float y = (static_cast<float>(row) + 0.5f) / 2 * 2 - 1;
      const Place place{2 * x, 2 * y};
      expect_irradiance(light, place.x, place.z,
                        (row * 4 + column + 1) * place.cosine(2) / place.distance2(2),
                        "texel " + std::to_string(row) + ", " + std::to_string(column));
    }
  }
}

/// A white diffuse surface across the axis at z = 1 shows the image: irradiance / pi is the image.
TEST(LocalLight, ProjectorShowsItsImageAtDistanceOne) {
  const TemporaryFolder folder;
  write_pfm(folder.path("image.pfm"), numbered_image(4, 2));
  const std::string down = "<lookat origin=\"0 1 0\" target=\"0 0 0\" up=\"0 0 1\"/>";
  const auto light = [&](const std::string& more) {
    return light_xml("projector", down, more + nearest_xml("irradiance", folder.path("image.pfm")));
  };
  const double tangent = std::tan(35 * kPiD / 180);
  // The emitter's axes x, to the image's left, and y, up, are the world's x and z.
  const auto expect_image = [&](const std::string& xml, double half_width, double scale) {
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < 4; ++column) {
        const auto x = static_cast<float>(half_width * (1 - (column + 0.5) / 2));
        const auto z = static_cast<float>(half_width / 2 * (1 - (row + 0.5)));
        expect_irradiance(xml, x, z, kPiD * scale * (row * 4 + column + 1), "texel");
      }
    }
    // Just inside and outside of the image.
    const auto edge = static_cast<float>(half_width);
    EXPECT_GT(rendered_irradiance(xml, 0.999f * edge, 0), 0);
    EXPECT_EQ(rendered_irradiance(xml, 1.001f * edge, 0), 0);
    EXPECT_GT(rendered_irradiance(xml, 0, 0.499f * edge), 0);
    EXPECT_EQ(rendered_irradiance(xml, 0, 0.501f * edge), 0);
  };
  expect_image(light(number_xml("fov", 70)), tangent, 1);
  expect_image(light(number_xml("fov", 70) + number_xml("scale", 0.25)), tangent, 0.25);
  const auto axis = [](const char* name) {
    return number_xml("fov", 70) + "<string name=\"fov_axis\" value=\"" + name + "\"/>";
  };
  expect_image(light(axis("larger")), tangent, 1);
  expect_image(light(axis("y")), 2 * tangent, 1);
  expect_image(light(axis("smaller")), 2 * tangent, 1);
  expect_image(light(axis("diagonal")), tangent * 2 / std::sqrt(5.), 1);
  const double by_focal_length = std::hypot(36, 24) / 2 / 50 * 2 / std::sqrt(5.);
  expect_image(light(""), by_focal_length, 1);
}

/// Without an image: a white square, whose brightness falls with 1 / z².
TEST(LocalLight, ProjectorWithoutAnImageIsWhite) {
  const std::string light =
      light_xml("projector", kDown, number_xml("fov", 90) + number_xml("irradiance", 3));
  for (const float x : {0.f, 0.5f, -1.9f}) {
    expect_irradiance(light, x, 1.9f, 3 * kPiD / 4, "white");
  }
  EXPECT_EQ(rendered_irradiance(light, 2.1f, 0), 0);
  EXPECT_EQ(rendered_irradiance(light, 0, -2.1f), 0);
}

TEST(LocalLight, DirectionalIsTheSameEverywhere) {
  const double cosine = 2 / std::sqrt(1. + 4 + 0.25);
  for (const Place& place : kPlaces) {
    expect_irradiance(
        "<emitter type=\"directional\"><vector name=\"direction\" value=\"1 -2 .5\"/>"
        "<rgb name=\"irradiance\" value=\"1 2 3\"/></emitter>",
        place.x, place.z, 2 * cosine, "direction");
    expect_irradiance(light_xml("directional", "<rotate x=\"1\" angle=\"120\"/>", ""), place.x,
                      place.z, std::sqrt(3.) / 2, "to_world");
  }
  EXPECT_EQ(rendered_irradiance(light_xml("directional", "", ""), 0, 0), 0);  // along the floor
}

/// An emitter inside a solid, under the floor, or exactly at a floor point lights nothing, and
/// causes no error.
TEST(LocalLight, EnclosedLightIsDark) {
  const std::string solid =
      "<shape type=\"sphere\"><point name=\"center\" value=\"0 2 0\"/><float name=\"radius\" "
      "value=\".5\"/></shape>";
  const std::string projector = light_xml("projector", kDown, number_xml("fov", 40));
  const std::string spot = light_xml("spot", kDown, "");
  const std::string point = light_xml("point", "<translate y=\"2\"/>", "");
  for (const std::string& light : {projector, spot, point}) {
    EXPECT_GT(rendered_irradiance(light, 0.1f, 0), 0);
    EXPECT_EQ(rendered_irradiance(light + solid, 0.1f, 0), 0);
  }
  EXPECT_EQ(rendered_irradiance(light_xml("point", "<translate y=\"-1\"/>", ""), 0, 0), 0);
  for (const char* type : {"point", "spot", "projector"}) {
    EXPECT_TRUE(std::isfinite(rendered_irradiance(light_xml(type, "", ""), 0, 0)));
  }
}

/// A scene with only black emitters renders a valid image.
TEST(LocalLight, BlackLightIsDark) {
  const TemporaryFolder folder;
  Image black = numbered_image(4, 2);
  for (float& value : black.data) value = 0;
  write_pfm(folder.path("black.pfm"), black);
  const std::string zero = "<float name=\"intensity\" value=\"0\"/>";
  for (const std::string& light :
       {light_xml("point", "<translate y=\"2\"/>", zero), light_xml("spot", kDown, zero),
        light_xml("projector", kDown, nearest_xml("irradiance", folder.path("black.pfm"))),
        light_xml("projector", kDown, number_xml("scale", 0)),
        light_xml("directional", "<rotate x=\"1\" angle=\"90\"/>", number_xml("irradiance", 0))}) {
    EXPECT_EQ(rendered_irradiance(light, 0.1f, 0), 0);
    const auto scene = scene_from(floor_at(0, 0) + light);
    EXPECT_FALSE(scene->emitters()[0]->sample_direct(Vec3(0.f), Vec2(0.5f)));
    EXPECT_FALSE(scene->emitters()[0]->sample_emission(Vec2(0.5f), Vec2(0.5f)));
  }
}

// ---- area lights ----

}  // namespace
}  // namespace kinome::test::local_light_test
