// Tests of --inspect: the samples of a pixel as a table and an image.

#include <map>

#include "cli.h"
#include "support/png.h"

namespace kinome::test::inspect_test {
namespace {

class Inspect : public Cli {
 protected:
  /// A closed room: a uniform sky lights it through its open front, and a spot lights a wall.
  static std::string room(const std::string& parameters) {
    return R"(<scene version="3.0.0">
  <integrator type="clustered"><integer name="light_samples" value="2000"/>
    <integer name="cut_size" value="60"/>)" +
           parameters + R"(</integrator>
  <sensor type="perspective"><transform name="to_world">
      <lookat origin="0,1,3.5" target="0,.2,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
  </sensor>
  <emitter type="constant"/>
  <emitter type="spot"><transform name="to_world">
    <lookat origin="-.8,1,.5" target="1,1.2,-.5" up="0,1,0"/></transform></emitter>
  <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/></transform>
    <bsdf type="roughplastic"/></shape>
  <shape type="rectangle"><transform name="to_world"><rotate y="1" angle="-90"/>
    <translate x="1" y="1"/></transform></shape>
</scene>)";
  }
  ProcessResult inspect(const std::string& pixel, const std::string& parameters = "") {
    const std::string scene = folder_.write("room.xml", room(parameters));
    return kinome({scene, "--inspect", pixel, "-o", folder_.path("out")});
  }
  /// Returns the columns by name.
  std::map<std::string, std::vector<double>> table(const std::string& name) {
    std::istringstream text(read_text(folder_.path(name)));
    std::string line, field;
    std::vector<std::string> names;
    std::getline(text, line);
    for (std::istringstream row(line); std::getline(row, field, ',');) names.push_back(field);
    std::map<std::string, std::vector<double>> columns;
    while (std::getline(text, line)) {
      size_t i = 0;
      for (std::istringstream row(line); std::getline(row, field, ',');) {
        columns[names.at(i++)].push_back(std::stod(field));
      }
      EXPECT_EQ(i, names.size());
    }
    return columns;
  }
};

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double v : values) total += v;
  return total;
}

TEST_F(Inspect, ShowsEachSetOfLightPoints) {
  for (const char* importance : {"joint", "luminance", "brdf"}) {
    const ProcessResult result =
        inspect("20,22",
                "<integer name=\"max_depth\" value=\"3\"/><string name=\"importance\" "
                "value=\"" +
                    std::string(importance) + "\"/>");
    ASSERT_EQ(result.status, 0) << result.err;
    for (const char* stem : {"out", "out-2"}) {
      EXPECT_TRUE(std::filesystem::exists(folder_.path(std::string(stem) + ".png"))) << result.err;
      auto columns = table(std::string(stem) + ".csv");
      EXPECT_EQ(columns["cluster"].size(), 60u);
      EXPECT_NEAR(sum(columns["light"]), 1, 1e-4);
      EXPECT_NEAR(sum(columns["probability"]), 1, 1e-4);
      EXPECT_EQ(sum(columns["samples"]), 128);
      EXPECT_EQ(*std::max_element(columns["geometric"].begin(), columns["geometric"].end()), 1);
      EXPECT_EQ(*std::max_element(columns["brdf"].begin(), columns["brdf"].end()), 1);
      // Only luminance sends no lobe rays.
      EXPECT_EQ(sum(columns["hits"]) > 0, std::string(importance) != "luminance") << stem;
      for (size_t c = 0; c < 60; ++c) {
        if (columns["probability"][c] == 0) {
          EXPECT_EQ(columns["samples"][c], 0) << c;
        }
      }
    }
  }
  // The table of the sky contains directions, that of the bounce positions.
  EXPECT_NE(table("out.csv")["mean_x"], table("out-2.csv")["mean_x"]);
}

/// The film has 40 x 30 pixels, too few to distinguish details.
TEST_F(Inspect, ImageOfASmallFilmIsEnlarged) {
  ASSERT_EQ(inspect("20,22", "<integer name=\"max_depth\" value=\"3\"/>").status, 0);
  const Png sky = read_png(folder_.path("out.png")), scene = read_png(folder_.path("out-2.png"));
  EXPECT_EQ(sky.width, 1024u);
  EXPECT_EQ(scene.width, 768u);
  EXPECT_GT(sky.height, 512u);  // larger because of the legend
  EXPECT_GT(scene.height, 576u);
}

/// The legend below the image has markers of samples and text on a dark ground.
TEST_F(Inspect, HasALegend) {
  ASSERT_EQ(inspect("20,22", "<integer name=\"max_depth\" value=\"3\"/>").status, 0);
  for (const auto& [name, height] : {std::pair("out.png", 512u), std::pair("out-2.png", 576u)}) {
    const Png png = read_png(folder_.path(name));
    int red = 0, blue = 0, text = 0, ground = 0;
    for (size_t i = size_t{4} * png.width * height; i < png.rgba.size(); i += 4) {
      const int r = png.rgba[i], g = png.rgba[i + 1], b = png.rgba[i + 2];
      red += r > 240 && g < 100;
      blue += b > 240 && r < 120;
      text += r > 180 && r == g && g == b;
      ground += r < 40 && r == g && g == b;
    }
    // Three disks each, with radii up to 6, and some hundred letters of about 50 pixels.
    EXPECT_GT(red, 50) << name;
    EXPECT_EQ(red, blue) << name;
    EXPECT_GT(text, 2000) << name;
    EXPECT_GT(ground, 20000) << name;
  }
}

/// Light points are slightly off their surfaces, but their clusters must be outlined anyway.
TEST_F(Inspect, ClustersAreOutlined) {
  for (const char* importance : {"joint", "product"}) {
    ASSERT_EQ(inspect("20,22",
                      "<integer name=\"max_depth\" value=\"3\"/><string "
                      "name=\"importance\" value=\"" +
                          std::string(importance) + "\"/>")
                  .status,
              0);
    for (const char* name : {"out.png", "out-2.png"}) {
      const Png png = read_png(folder_.path(name));
      int yellow = 0;
      for (size_t i = 0; i < png.rgba.size(); i += 4) {
        yellow += png.rgba[i] > 200 && png.rgba[i + 1] > 200 && png.rgba[i + 2] < 150;
      }
      // Such a small image needs few cells, of which little is visible.
      EXPECT_GT(yellow, std::string(importance) == "joint" ? 200 : 40)
          << importance << ", " << name;
    }
  }
}

/// The floor's light comes from the sky, the lamp, and the wall that the lamp lights.
TEST_F(Inspect, ShowsLearnedVisibilityOfLocalLight) {
  const ProcessResult result = inspect("20,22", "<integer name=\"max_depth\" value=\"3\"/>");
  ASSERT_EQ(result.status, 0) << result.err;
  auto sky = table("out.csv"), local = table("out-2.csv");
  EXPECT_NEAR(sum(sky["probability"]) + sum(local["probability"]), 1, 1e-3);
  EXPECT_NEAR(sum(local["light"]), 1, 1e-4);
  EXPECT_GT(sum(sky["probability"]), 0.05);
  EXPECT_GT(sum(local["probability"]), 0.001);
  // Most of the requested bounce is that of the wall, which faces -x.
  double wall = 0;
  for (size_t c = 0; c < local["normal_x"].size(); ++c) {
    if (local["normal_x"][c] < -0.9) wall += local["probability"][c];
  }
  EXPECT_GT(wall, 0.5 * sum(local["probability"]));
}

/// A floor under a uniform sky, half of which a wall hides.
TEST_F(Inspect, ShowsLearnedVisibility) {
  const std::string scene = folder_.write("wall.xml", R"(<scene version="3.0.0">
  <integrator type="clustered"><integer name="cut_size" value="200"/>
    <integer name="max_depth" value="2"/>
    <float name="rays_per_pixel" value="90"/></integrator>
  <sensor type="perspective"><transform name="to_world">
      <lookat origin="0,2,0" target="0,0,0" up="0,0,1"/></transform>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/></film>
  </sensor>
  <emitter type="constant"/>
  <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="-90"/></transform></shape>
  <shape type="rectangle"><transform name="to_world"><scale value="1000"/>
    <rotate y="1" angle="90"/><translate x="-.9"/></transform></shape>
</scene>)");
  const ProcessResult result =
      kinome({scene, "--inspect", "8,8", "-o", folder_.path("out"), "--seed", "3"});
  ASSERT_EQ(result.status, 0) << result.err;
  auto columns = table("out.csv");
  const size_t cells = columns["cluster"].size();
  EXPECT_GT(cells, 100u);
  EXPECT_NEAR(sum(columns["light"]), 1, 1e-4);
  EXPECT_NEAR(sum(columns["probability"]), 1, 1e-4);
  EXPECT_LE(sum(columns["samples"]), 90);  // directions below the horizon get none
  EXPECT_GE(sum(columns["samples"]), 70);
  int seen = 0, behind = 0;
  for (size_t c = 0; c < cells; ++c) {
    const double x = columns["mean_x"][c], y = columns["mean_y"][c];
    if (y < 0.3) {
      EXPECT_TRUE(y > -0.3 || columns["probability"][c] == 0) << "below the horizon: " << c;
      continue;
    }
    if (x > 0.3) {
      ++seen;
      EXPECT_GT(columns["visibility"][c], 0.9) << c;
    } else if (x < -0.3) {
      ++behind;
      EXPECT_LT(columns["visibility"][c], 0.1) << c;
    }
  }
  EXPECT_GT(seen, 10);
  EXPECT_GT(behind, 10);
  const Png png = read_png(folder_.path("out.png"));
  EXPECT_EQ(png.width, 1024u);
}

TEST_F(Inspect, ErrorsGiveTheReason) {
  EXPECT_NE(inspect("40,2").err.find("between 0,0 and 39,29"), std::string::npos);
  EXPECT_NE(inspect("-1,2").err.find("between 0,0 and 39,29"), std::string::npos);
  EXPECT_NE(inspect("3;4").err.find("X,Y"), std::string::npos);
  EXPECT_NE(inspect("3,4x").err.find("X,Y"), std::string::npos);
  EXPECT_NE(inspect("1,1").err.find("no surface"), std::string::npos);
  const std::string scene = folder_.write("scene.xml", small_scene());
  const ProcessResult direct = kinome({scene, "--inspect", "24,24"});
  EXPECT_NE(direct.err.find("no clusters to inspect"), std::string::npos);
  EXPECT_EQ(direct.status, 1);
  EXPECT_EQ(other_files({scene, folder_.path("room.xml")}), std::vector<std::string>{});
}

}  // namespace
}  // namespace kinome::test::inspect_test
