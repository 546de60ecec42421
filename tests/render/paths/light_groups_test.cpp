/// Light groups. The groups add up to the image, and each has the light of its own emitters alone.
/// Three rooms without light from each other show the latter: a group must be black in the others'
/// rooms.
#include <gtest/gtest.h>

#include <cmath>

#include "path_scenes.h"

namespace kinome::test::light_groups_test {
namespace {

constexpr int kWidth = 24, kHeight = 8, kRooms = 3;

/// Walls of the rooms at x = -1 and x = 1. Their backs are black.
std::string walls_xml() {
  std::string walls;
  for (const char* const x : {"-1", "1"}) {
    const std::string at = std::string("<translate x=\"") + x + "\"/>";
    walls += shape_xml("rectangle", "<scale value=\"50\"/><rotate y=\"1\" angle=\"90\"/>" + at,
                       diffuse_xml("0.5 0.6 0.4"));
  }
  return walls;
}

std::string lamp_xml(const std::string& id, const std::string& position) {
  return "<emitter type=\"point\"" + (id.empty() ? "" : " id=\"" + id + "\"") +
         "><point name=\"position\" value=\"" + position +
         "\"/><rgb name=\"intensity\" value=\"0.5 0.3 0.2\"/></emitter>";
}

/// A small emitting sphere, which the camera sees.
std::string ball_xml(const std::string& id, const std::string& centre) {
  return "<shape type=\"sphere\"" + (id.empty() ? "" : " id=\"" + id + "\"") +
         "><point name=\"center\" value=\"" + centre +
         "\"/><float name=\"radius\" value=\"0.3\"/>" + diffuse_xml("0") + area_xml("2 3 4") +
         "</shape>";
}

/// The rooms seen from above, each as a third of the image. The emitters of the left room are in a
/// group of two, that of the middle room is in a group by the id of its shape, and those of the
/// right room are in no group.
std::unique_ptr<Scene> rooms(const std::string& integrator, const std::string& groups) {
  const std::string sensor =
      "<sensor type=\"orthographic\"><transform name=\"to_world\"><scale value=\"3\"/>" +
      look_at("0 5 0", "0 0 0", "0 0 -1") +
      "</transform><sampler type=\"independent\"><integer name=\"sample_count\" value=\"16\"/>"
      "</sampler><film type=\"hdrfilm\"><integer name=\"width\" value=\"24\"/><integer "
      "name=\"height\" value=\"8\"/><rfilter type=\"box\"/></film></sensor>";
  const std::string aov = "<integrator type=\"aov\"><string name=\"light_groups\" value=\"" +
                          groups + "\"/>" + integrator + "</integrator>";
  return scene_from(aov + sensor + floor_xml(diffuse_xml("0.7 0.6 0.5")) + walls_xml() +
                    lamp_xml("lamp", "-2.5 1 0.3") + ball_xml("left", "-1.7 0.5 -0.3") +
                    ball_xml("middle", "0.2 0.6 0.1") + ball_xml("", "2.2 0.4 0") +
                    lamp_xml("", "1.5 1 -0.4"));
}

int channel_of(const Image& image, const std::string& name) {
  const int channel = image.find_channel(name);
  EXPECT_GE(channel, 0) << name;
  return std::max(channel, 0);
}

struct Divided {
  const char* name;
  const char* integrator;
  /// Maximum light of other groups relative to the room's own. The expected visible light of
  /// `clustered` and the rays that correct it cancel only in expectation.
  double noise;
};

class LightGroups : public testing::TestWithParam<Divided> {};

TEST_P(LightGroups, DivideTheLight) {
  const std::string groups[kRooms] = {"pair", "single", "rest"};
  const auto scene = rooms(GetParam().integrator, "pair: lamp left; single: middle");
  const Image image = render_scene(*scene, 3);
  ASSERT_EQ(image.channel_count(), 3 + 3 * kRooms);
  for (int c = 0; c < 3; ++c) {
    const std::string letter(1, "RGB"[c]);
    const int color = channel_of(image, letter);
    double mean[kRooms][kRooms] = {};  // by group and room
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const int x = i % kWidth, y = i / kWidth;
      double sum = 0, magnitude = 0;
      for (int g = 0; g < kRooms; ++g) {
        const double light =
            image.at(x, y, channel_of(image, "lights." + groups[g] + "." + letter));
        sum += light;
        magnitude += std::abs(light);
        mean[g][x * kRooms / kWidth] += light / (kWidth / kRooms * kHeight);
      }
      EXPECT_NEAR(sum, image.at(x, y, color), 1e-6 * magnitude + 1e-9) << x << "," << y;
    }
    for (int g = 0; g < kRooms; ++g) {
      for (int room = 0; room < kRooms; ++room) {
        if (g == room) {
          EXPECT_GT(mean[g][room], 0.05) << groups[g];
        } else {
          EXPECT_LE(std::abs(mean[g][room]), GetParam().noise * mean[room][room])
              << groups[g] << " in room " << room;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Integrators, LightGroups,
    testing::Values(Divided{"Path", "<integrator type=\"path\"/>", 0},
                    Divided{"Direct", "<integrator type=\"direct\"/>", 0},
                    Divided{"Clustered",
                            "<integrator type=\"clustered\"><boolean name=\"trial\" "
                            "value=\"false\"/></integrator>",
                            0.02}),
    [](const auto& tested) { return tested.param.name; });

/// Returns the error of loading the rooms, or "".
std::string fault_of(const std::string& integrator, const std::string& groups) {
  try {
    rooms(integrator, groups);
  } catch (const Error& error) {
    return error.message();
  }
  return "";
}

TEST(LightGroupNames, AreUnique) {
  const std::string path = "<integrator type=\"path\"/>";
  EXPECT_EQ(
      fault_of(path, "rest: left"),
      "'light_groups' has two groups 'rest': the one that it names, and that of the emitters in "
      "no group: rename the group");
  EXPECT_EQ(fault_of(path, "rest: left; left: middle"), fault_of(path, "rest: left"));
}

/// '.' separates the layers of an EXR file.
TEST(LightGroupNames, AreIdsWithoutSeparators) {
  const auto scene_with = [](const std::string& ids) {
    return "<integrator type=\"aov\"><string name=\"light_groups\" value=\"all\"/><integrator "
           "type=\"path\"/></integrator>" +
           ids;
  };
  const auto scene =
      scene_from(scene_with(lamp_xml("Point.001", "0 0 1") + lamp_xml("a/b=c", "0 0 2")));
  std::vector<std::string> names;
  for (const FilmChannel& channel : scene->integrator().channels()) names.push_back(channel.name);
  EXPECT_EQ(names, (std::vector<std::string>{"lights.Point_001.R", "lights.Point_001.G",
                                             "lights.Point_001.B", "lights.a_b_c.R",
                                             "lights.a_b_c.G", "lights.a_b_c.B"}));
  const auto fault = [&](const std::string& ids) {
    try {
      scene_from(scene_with(ids));
    } catch (const Error& error) {
      return error.message();
    }
    return std::string();
  };
  EXPECT_EQ(fault(lamp_xml("a.b", "0 0 1") + lamp_xml("a_b", "0 0 2")),
            "'light_groups' has two groups 'a_b': of the emitter 'a.b' and of 'a_b': rename one of "
            "them");
  EXPECT_EQ(
      fault(lamp_xml("rest", "0 0 1") + lamp_xml("", "0 0 2")),
      "'light_groups' has two groups 'rest': of the emitter 'rest', and of the emitters without "
      "an id: rename the emitter");
  EXPECT_EQ(fault(lamp_xml("rest", "0 0 1")), "");
}

}  // namespace
}  // namespace kinome::test::light_groups_test
