/// `sunsky` by learned product sampling, with cells of the sun and of the sky, against `direct`.
#include <gtest/gtest.h>

#include "render/product/product_scenes.h"

namespace kinome::test::sunsky_render_test {
namespace {

std::string sunsky_xml(double aperture, double sun_scale) {
  return "<emitter type=\"sunsky\"><vector name=\"sun_direction\" value=\"-1 2 1.5\"/>" +
         number("sun_aperture", aperture) + number("sun_scale", sun_scale) +
         "<transform name=\"to_world\"><rotate x=\"1\" angle=\"-90\"/></transform></emitter>";
}

TEST(SunSkyRender, ProductIsDirect) {
  const std::pair<const char*, std::string> materials[] = {
      {"diffuse", kGrey},
      {"rough plastic", bsdf("roughplastic", number("alpha", .15))},
  };
  for (const auto& [aperture, sun_scale] : {std::pair{0.5358, 1.}, {8., 1.}, {0.5358, 0.}}) {
    for (const auto& [name, material] : materials) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(aperture));
      Arrangement s;
      s.shapes = shapes_xml(material);
      s.light = sunsky_xml(aperture, sun_scale);
      expect_unbiased(often(s, 2));
    }
  }
}

}  // namespace
}  // namespace kinome::test::sunsky_render_test
