// --time, --error and --variance on the command line.
#include <nlohmann/json.hpp>
#include <sstream>

#include "cli.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::test::budget_test {
namespace {

using nlohmann::json;

class Budget : public Cli {
 protected:
  Budget() : scene_(folder_.write("scene.xml", small_scene())), image_(folder_.path("a.exr")) {}

  /// Renders the small scene, which must succeed, and returns its statistics.
  json render(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {scene_, "-o", image_, "--stats=json"});
    const ProcessResult result = kinome(arguments);
    EXPECT_EQ(result.status, 0) << result.err;
    log_ = result.err;
    return json::parse(result.out);
  }
  std::string pixels(std::vector<std::string> arguments) {
    render(std::move(arguments));
    const Image image = read_exr(image_);
    return {reinterpret_cast<const char*>(image.data.data()), image.data.size() * sizeof(float)};
  }

  std::string scene_, image_, log_;
};

TEST_F(Budget, BadNumbersAreOneErrorEach) {
  for (const char* option : {"--time", "--error"}) {
    for (const char* bad : {"0", "-1", "nan", "inf"}) {
      expect_one_error(kinome({scene_, option, bad}), option, {"greater than 0", bad});
    }
    expect_one_error(kinome({scene_, option, "soon"}), "", {option, "soon"});
    expect_one_error(kinome({scene_, "--inspect", "1,1", option, "1"}), option, {"--inspect"});
  }
  for (const char* bad : {"0", "3", "1025", "-4", "4.5", "many"}) {
    expect_one_error(kinome({scene_, std::string("--variance=") + bad}), "--variance",
                     {"between 4 and 1024", bad});
  }
  expect_one_error(kinome({scene_, "--inspect", "1,1", "--variance"}), "--variance", {"--inspect"});
  expect_one_error(kinome({scene_, "-D", "spp=0"}), "", {"sample_count"});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{});
}

TEST_F(Budget, TooLittleTimeStillGivesAnImage) {
  for (const char* integrator : {"direct", "clustered", "path", "ptracer"}) {
    const json stats = render({"--time", "0.001", "-D", std::string("integrator=") + integrator});
    EXPECT_EQ(stats.at("samples"), 1) << integrator;
    EXPECT_EQ(stats.at("complete"), true);
    const Image image = read_exr(image_);
    double sum = 0;
    for (const float v : image.data) sum += v;
    EXPECT_GT(sum, 0) << integrator;
  }
}

/// The limits are loose, because a busy machine exceeds the time.
TEST_F(Budget, TimeIsAboutKept) {
  const json stats = render({"--time", "1.5", "--png"});
  EXPECT_GT(stats.at("seconds").at("total").get<double>(), 0.9);
  EXPECT_LT(stats.at("seconds").at("total").get<double>(), 10);
  EXPECT_GT(stats.at("samples").get<int>(), 4);
  EXPECT_EQ(other_files({scene_}).size(), 2u) << "only the two images are expected";
}

TEST_F(Budget, ErrorIsReachedWithTheSameBits) {
  for (const char* integrator : {"direct", "clustered", "path"}) {
    const std::string define = std::string("integrator=") + integrator;
    const json stats = render({"--error", "2e-3", "-D", define, "-D", "width=24", "-t", "1"});
    EXPECT_LE(stats.at("relmse").get<double>(), 2e-3) << integrator;
    EXPECT_GE(stats.at("samples").get<int>(), 9) << integrator << ": one of each lane";
    ImageMetadata metadata;
    read_exr(image_, {}, &metadata);
    EXPECT_NEAR(std::stod(metadata["kinome:relmse"]), stats.at("relmse").get<double>(), 1e-5);
    EXPECT_EQ(metadata["kinome:samples"], std::to_string(stats.at("samples").get<int>()));
    const auto bits = [&](const char* threads) {
      return pixels({"--error", "2e-3", "-D", define, "-D", "width=24", "-t", threads});
    };
    const std::string one = bits("1");
    EXPECT_EQ(bits("2"), one) << integrator;
    EXPECT_EQ(bits("5"), one) << integrator;
  }
}

TEST_F(Budget, PrintsTheMethodAndTheReason) {
  const std::string reason = "path (the render is short, and path needs no preparation)";
  const ProcessResult result = kinome(
      {scene_, "-D", "integrator=clustered", "--error", "0.5", "-o", "/dev/null", "--stats=json"});
  EXPECT_NE(result.err.find("method: " + reason + "\n"), std::string::npos) << result.err;
  EXPECT_EQ(nlohmann::json::parse(result.out).at("method"), reason);
  // There is no choice, or no budget.
  EXPECT_EQ(kinome({scene_, "--error", "0.5", "-o", "/dev/null"}).err.find("method"),
            std::string::npos);
  EXPECT_EQ(kinome({scene_, "-D", "integrator=clustered", "-o", "/dev/null"}).err.find("method"),
            std::string::npos);
}

/// Direct light of the sky: nothing can be learned from the rays of one or two samples per pixel.
TEST_F(Budget, OneOrTwoSamplesOfDirectLightArePaths) {
  const std::string nested = "<integrator type=\"$integrator\"/>";
  std::string direct = small_scene();
  direct.replace(
      direct.find(nested), nested.size(),
      "<integrator type=\"clustered\"><integer name=\"max_depth\" value=\"2\"/></integrator>");
  const std::string scene = folder_.write("direct.xml", direct);
  const auto method = [&](const std::string& samples) {
    const ProcessResult result =
        kinome({scene, "-D", "spp=" + samples, "-o", "/dev/null", "--stats=json"});
    return nlohmann::json::parse(result.out).at("method").get<std::string>();
  };
  const std::string path = "path (there are too few rays per pixel to learn from)";
  EXPECT_EQ(method("1"), path);
  EXPECT_EQ(method("2"), path);
  EXPECT_EQ(method("3"), "product sampling (its cells contain all light of this scene)");
}

TEST_F(Budget, UnreachableErrorStopsAtTheLimit) {
  const json stats = render({"--error", "1e-30", "-D", "width=4"});
  EXPECT_EQ(stats.at("samples"), 16384);
  EXPECT_GT(stats.at("relmse").get<double>(), 1e-30);
  EXPECT_NE(log_.find("--error 1e-30 was not reached"), std::string::npos) << log_;
  EXPECT_NE(log_.find("16384 samples"), std::string::npos) << log_;
  render({"--error", "1e-30", "--time", "0.4", "-D", "width=24"});
  EXPECT_NE(log_.find("time was up"), std::string::npos) << log_;
}

/// Each pass of such a render would cause the same warnings.
TEST_F(Budget, WarnsOfEachThingOnce) {
  std::string dark = small_scene();
  const std::string emitter = "  <emitter type=\"constant\"/>\n";
  dark.erase(dark.find(emitter), emitter.size());
  const std::string scene = folder_.write("dark.xml", dark);
  for (const std::string integrator : {"direct", "path", "clustered", "ptracer"}) {
    const ProcessResult result = kinome(
        {scene, "-o", folder_.path("dark"), "--error", "0.01", "-D", "integrator=" + integrator});
    EXPECT_EQ(result.status, 0) << result.err;
    const size_t first = result.err.find("the scene has no emitter");
    EXPECT_NE(first, std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("the scene has no emitter", first + 1), std::string::npos)
        << result.err;
  }
}

TEST_F(Budget, VariancesAreChannels) {
  for (const char* integrator : {"direct", "clustered", "ptracer"}) {
    render({"--variance", "-D", "spp=64", "-D", std::string("integrator=") + integrator});
    ImageMetadata header;
    const Image image = read_exr(image_, {}, &header);
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "tile_variance.B",
                                                        "tile_variance.G", "tile_variance.R",
                                                        "variance.B", "variance.G", "variance.R"}));
    EXPECT_EQ(header.at("kinome:renders"), "16");
    std::istringstream numbers(header.at("kinome:variance_of_mean"));
    for (int c = 0; c < 3; ++c) {
      double variance = -1;
      EXPECT_TRUE(numbers >> variance) << header.at("kinome:variance_of_mean");
      EXPECT_GE(variance, 0);
    }
    double sum = 0;
    for (int i = 0; i < 48 * 48; ++i) {
      const float v = image.at(i % 48, i / 48, 6);
      EXPECT_GE(v, 0);
      EXPECT_LT(v, 10);
      sum += v;
    }
    EXPECT_GT(sum, 0) << integrator;
  }
  const std::string pfm =
      folder_.write("pfm.xml", std::string(small_scene())
                                   .replace(small_scene().find("<rfilter"), 0,
                                            "<string name=\"file_format\" value=\"pfm\"/>"));
  expect_one_error(kinome({pfm, "--variance"}), "--variance", {".pfm"});
}

}  // namespace
}  // namespace kinome::test::budget_test
