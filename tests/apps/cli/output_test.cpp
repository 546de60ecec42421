// Tests of crops and of the formats of output files.

#include <ctime>
#include <string>

#include <nlohmann/json.hpp>

#include "cli.h"
#include "kinome/image.h"
#include "kinome/image_files.h"

namespace kinome::test::output_test {
namespace {

class OutputFormats : public Cli {
 protected:
  OutputFormats() : scene_(folder_.write("scene.xml", small_scene())) {}

  /// Renders with these options and -q, which must print nothing. Returns the bytes of `name`.
  std::string written(const std::string& name, std::vector<std::string> options = {}) {
    options.insert(options.begin(), {"-q", scene_, "-o", folder_.path(name)});
    const ProcessResult result = kinome(options);
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return read_text(folder_.path(name));
  }

  std::string scene_;
};

TEST_F(OutputFormats, CropHasTheBitsOfTheFilmsCrop) {
  written("crop.exr", {"--crop", "8,4,20,10"});
  std::string xml = small_scene();
  const std::string width = "<integer name=\"width\" value=\"$width\"/>";
  xml.insert(xml.find(width),
             "<integer name=\"crop_offset_x\" value=\"8\"/><integer name=\"crop_offset_y\" "
             "value=\"4\"/><integer name=\"crop_width\" value=\"20\"/>"
             "<integer name=\"crop_height\" value=\"10\"/>");
  scene_ = folder_.write("cropped.xml", xml);
  written("film.exr");
  const Image by_option = read_exr(folder_.path("crop.exr"));
  const Image by_film = read_exr(folder_.path("film.exr"));
  EXPECT_EQ(by_option.width, 20);
  EXPECT_EQ(by_option.height, 10);
  EXPECT_EQ(by_option.data, by_film.data);
  // The option replaces the film's own window.
  written("whole.exr", {"--crop", "0,0,48,48"});
  EXPECT_EQ(read_exr(folder_.path("whole.exr")).width, 48);
}

TEST_F(OutputFormats, StatisticsNameTheCrop) {
  const ProcessResult text = kinome({scene_, "-o", "/dev/null", "--crop", "8,4,20,10", "--stats"});
  EXPECT_NE(text.err.find("20x10 pixels at 8,4 of 48x48"), std::string::npos) << text.err;
  const auto json = nlohmann::json::parse(
      kinome({"-q", scene_, "-o", "/dev/null", "--crop", "8,4,20,10", "--stats=json"}).out);
  EXPECT_EQ(json.at("x"), 8);
  EXPECT_EQ(json.at("y"), 4);
  EXPECT_EQ(json.at("width"), 20);
  EXPECT_EQ(json.at("film_height"), 48);
}

TEST_F(OutputFormats, ExtensionsSelectTheFormat) {
  const std::vector<std::string> options = {"--crop", "8,4,20,10"};
  EXPECT_EQ(written("a.pfm", options).substr(0, 9), "PF\n20 10\n");
  EXPECT_EQ(written("a.hdr", options).substr(0, 10), "#?RADIANCE");
  EXPECT_EQ(written("a.PNG", options).substr(0, 4), "\x89PNG");
  EXPECT_EQ(written("a.jpg", options).substr(0, 3), "\xff\xd8\xff");
  EXPECT_EQ(written("a.webp", options).substr(0, 4), "RIFF");
  EXPECT_EQ(written("a.tif", options).substr(0, 2), "II");
  EXPECT_EQ(written("a.pgm", options).substr(0, 2), "P5");
  EXPECT_EQ(written("a.ppm", options).substr(0, 2), "P6");
  EXPECT_EQ(written("a.0007", options), "");  // a number isn't a format
  EXPECT_EQ(read_exr(folder_.path("a.0007.exr")).width, 20);
  EXPECT_EQ(other_files({scene_}).size(), 9u);  // nothing else is left
}

/// Files contain neither the time nor anything else that differs between runs.
TEST_F(OutputFormats, FilesHaveTheSameBytesAgain) {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  localtime_r(&now, &local);
  const std::string year = std::to_string(1900 + local.tm_year);
  for (const char* name : {"a.tif", "a.jpg", "a.tga", "a.bmp", "a.rla", "a.dpx", "a.sgi"}) {
    const std::string first = written(name);
    EXPECT_GT(first.size(), 1000u) << name;
    EXPECT_EQ(written(name, {"-t", "2"}), first) << name;
    EXPECT_EQ(first.find("1970"), std::string::npos) << name;
    EXPECT_EQ(first.substr(0, 740).find(year), std::string::npos) << name;
  }
  // These formats have a name or the time at these positions.
  EXPECT_EQ(written("a.rla").substr(528, 20), std::string(20, '\0'));
  EXPECT_EQ(written("a.dpx").substr(36, 100), std::string(100, '\0'));
  EXPECT_EQ(written("a.sgi").substr(24, 80), std::string(80, '\0'));
}

/// The values of PNG files are those of --png.
TEST_F(OutputFormats, ExposureHoldsForThem) {
  written("b.exr", {"--png", "--exposure", "-1"});
  EXPECT_EQ(written("c.png", {"--exposure", "-1"}), read_text(folder_.path("b.png")));
  EXPECT_NE(written("d.png"), read_text(folder_.path("b.png")));
}

TEST_F(OutputFormats, PartsAndVariancesNeedExr) {
  const std::string jpg = folder_.path("a.jpg");
  expect_one_error(kinome({scene_, "-o", jpg, "--part", "1/2"}), "", {"--part", ".exr", ".jpg"});
  expect_one_error(kinome({scene_, "-o", jpg, "--variance=4"}), "", {"--variance", ".exr", ".jpg"});
}

/// OpenImageIO would end the program, or write a file that can't be read.
TEST_F(OutputFormats, ImagesBeyondAFormatsSizesAreErrors) {
  const std::string jp2 = folder_.path("a.jp2");
  expect_one_error(kinome({scene_, "-o", jp2, "--crop", "0,0,40,20"}), "",
                   {"-o", "a.jp2", "at least 32", "40x20"});
  EXPECT_EQ(other_files({scene_}).size(), 0u);
  EXPECT_GT(written("b.jp2", {"--crop", "0,0,40,32"}).size(), 100u);
}

}  // namespace
}  // namespace kinome::test::output_test
