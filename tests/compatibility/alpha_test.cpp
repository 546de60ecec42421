/// Alpha of the background and of transparent surfaces, as Mitsuba 3.9.1's `path` renders it.
#include <gtest/gtest.h>

#include "support/render.h"

namespace kinome::test {
namespace {

/// A 4x4 RGBA film that sees the whole of a constant environment of radiance 1.
std::string sky_xml(bool hide_emitters) {
  std::string xml = "<integrator type=\"path\"><boolean name=\"hide_emitters\" value=\"";
  xml += hide_emitters ? "true" : "false";
  xml += "\"/></integrator><emitter type=\"constant\"/>"
         "<sensor type=\"perspective\"><film type=\"hdrfilm\"><rfilter type=\"box\"/>"
         "<string name=\"pixel_format\" value=\"rgba\"/>"
         "<integer name=\"width\" value=\"4\"/><integer name=\"height\" value=\"4\"/>"
         "</film></sensor>";
  return xml;
}

TEST(Alpha, OfAHiddenBackgroundIsZero) {
  const Image image = render_scene(*scene_from(sky_xml(true)));
  ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
  EXPECT_EQ(image.data, std::vector<float>(4 * 4 * 4, 0.f));
}

}  // namespace
}  // namespace kinome::test
