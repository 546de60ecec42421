/// `moment` on samples with only two values, 0 and v: the mean of their squares is v times their
/// mean for any samples. Also tests the channel names, which are Mitsuba's.
#include <gtest/gtest.h>

#include "direct_scenes.h"
#include "kinome/color.h"

namespace kinome::test::moment_test {
namespace {

/// A black wall covers half of an image of 3 x 3 pixels, and half of its central column. The rest
/// is sky.
std::string scene_xml(const std::string& integrator, const std::string& pixel_format = "rgb",
                      int samples = 16) {
  return "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"2\" y=\"4\"/><translate "
         "x=\"-2\"/></transform>" +
         diffuse_xml("0") + "</shape>" + constant_xml("0.5 1 4") +
         sensor_xml("orthographic", look_at("0 0 5", "0 0 0", "0 1 0"), 3, samples, "independent",
                    pixel_format) +
         integrator;
}

std::string moment_xml(const std::string& nested) {
  return "<integrator type=\"moment\">" + nested + "</integrator>";
}
std::string named(const std::string& type, const std::string& name,
                  const std::string& content = "") {
  return "<integrator type=\"" + type + "\" name=\"" + name + "\">" + content + "</integrator>";
}

float value(const Image& image, int x, int y, const std::string& name) {
  for (int c = 0; c < image.channel_count(); ++c) {
    if (image.channels[c] == name) return image.at(x, y, c);
  }
  ADD_FAILURE() << "no channel " << name;
  return 0;
}

const Rgb kSky(0.5f, 1, 4);

/// Tests the central column, where both values occur.
void expect_two_values(const Image& image, const std::string& name, float v) {
  bool both = false;
  for (int y = 0; y < 3; ++y) {
    const float mean = value(image, 1, y, name);
    EXPECT_NEAR(value(image, 1, y, "m2_" + name), v * mean, 2e-6f * v * v) << name;
    both = both || (mean > 0.2f * v && mean < 0.8f * v);
  }
  EXPECT_TRUE(both) << name << ": nothing was tested";
}

TEST(Moment, IsTheMeanOfSquares) {
  const glm::dvec3 sky = xyz(glm::dvec3(kSky));
  for (const char* type : {"direct", "path", "groundtruth", "depth"}) {
    const Image image = render_scene(*scene_from(scene_xml(moment_xml(named(type, "a")))), 3);
    if (std::string(type) == "depth") {
      const double depth = 5 - 0.01;
      expect_two_values(image, "a.X", static_cast<float>(xyz(glm::dvec3(depth)).x));
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      expect_two_values(image, std::string("a.") + "XYZ"[c], static_cast<float>(sky[c]));
    }
  }
}

/// The image of which moments are computed is identical with and without `moment`.
TEST(Moment, LeavesColourUnchanged) {
  for (const char* format : {"rgba", "luminance"}) {
    const Image plain = render_scene(*scene_from(scene_xml(named("path", "a"), format)), 9);
    const Image with =
        render_scene(*scene_from(scene_xml(moment_xml(named("path", "a")), format)), 9);
    for (int y = 0; y < 3; ++y) {
      for (int x = 0; x < 3; ++x) {
        for (int c = 0; c < plain.channel_count(); ++c) {
          EXPECT_NEAR(with.at(x, y, c), plain.at(x, y, c), 1e-6f) << format;
        }
      }
    }
  }
}

TEST(Moment, NamesChannelsAsMitsubaDoes) {
  const auto channels = [](const std::string& integrator, const char* format = "rgb") {
    return render_scene(*scene_from(scene_xml(integrator, format, 1))).channels;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(channels(moment_xml("<integrator type=\"path\"/>"), "rgba"),
            (Names{"R", "G", "B", "A", "_arg_0.X", "_arg_0.Y", "_arg_0.Z", "m2__arg_0.X",
                   "m2__arg_0.Y", "m2__arg_0.Z"}));
  EXPECT_EQ(channels(moment_xml(named("path", "a") + named("direct", "b"))),
            (Names{"R", "G", "B", "a.X", "a.Y", "a.Z", "b.X", "b.Y", "b.Z", "m2_a.X", "m2_a.Y",
                   "m2_a.Z", "m2_b.X", "m2_b.Y", "m2_b.Z"}));
  const std::string aovs = "<string name=\"aovs\" value=\"dd:depth\"/>";
  EXPECT_EQ(channels(moment_xml(named("aov", "q", aovs + named("path", "img")))),
            (Names{"R", "G", "B", "q.img.R", "q.img.G", "q.img.B", "q.img.A", "q.dd.T", "q.X",
                   "q.Y", "q.Z", "m2_q.img.R", "m2_q.img.G", "m2_q.img.B", "m2_q.img.A",
                   "m2_q.dd.T", "m2_q.X", "m2_q.Y", "m2_q.Z"}));
  EXPECT_EQ(channels(named("aov", "outer", aovs + named("moment", "m", named("path", "a")))),
            (Names{"R", "G", "B", "m.R", "m.G", "m.B", "m.A", "m.a.X", "m.a.Y", "m.a.Z",
                   "m.m2_a.X", "m.m2_a.Y", "m.m2_a.Z", "dd.T"}));
}

/// Alpha of nested integrators has moments even if the film has no alpha.
TEST(Moment, IncludesOutputVariablesAndAlpha) {
  const std::string aov = named("aov", "q",
                                "<string name=\"aovs\" value=\"dd:depth\"/>" + named("path", "a") +
                                    named("depth", "b"));
  const Image image = render_scene(*scene_from(scene_xml(moment_xml(aov))), 3);
  const float depth = 5 - 0.01f;
  expect_two_values(image, "q.dd.T", depth);
  expect_two_values(image, "q.b.A", 1);  // `path` alone gives the sky an alpha of 1
  EXPECT_EQ(value(image, 1, 1, "q.a.A"), 1);
  EXPECT_EQ(value(image, 1, 1, "m2_q.a.A"), 1);
  expect_two_values(image, "q.a.B", kSky.z);
  expect_two_values(image, "q.b.R", depth);
  EXPECT_EQ(value(image, 2, 1, "q.a.G"), 1);
  EXPECT_EQ(value(image, 2, 1, "q.b.G"), 0);
  EXPECT_EQ(value(image, 2, 1, "G"), 1);
}

/// The second moment of a second moment is the fourth.
TEST(Moment, Nests) {
  const Image image =
      render_scene(*scene_from(scene_xml(moment_xml(named("moment", "m", named("path", "a"))))), 3);
  const auto sky = static_cast<float>(xyz(glm::dvec3(kSky)).y);
  for (int y = 0; y < 3; ++y) {
    EXPECT_NEAR(value(image, 1, y, "m2_m.m2_a.Y"), sky * sky * sky * value(image, 1, y, "m.a.Y"),
                1e-5f);
  }
}

TEST(Moment, RefusesIntegratorsWithoutSamples) {
  for (const char* type : {"ptracer", "clustered"}) {
    const std::string aov = named("aov", "q",
                                  "<string name=\"aovs\" value=\"d:depth\"/>" + named(type, "a"));
    for (const std::string& nested : {named(type, "a"), aov}) {
      try {
        make<Integrator>(moment_xml(nested));
        ADD_FAILURE() << type;
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("there are no second moments of 'integrator/"),
                  std::string::npos)
            << error.what();
      }
    }
  }
  make<Integrator>(moment_xml(
      named("clustered", "a", "<string name=\"importance\" value=\"joint\"/>")));
}

}  // namespace
}  // namespace kinome::test::moment_test
