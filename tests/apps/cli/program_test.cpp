// Tests of the program's options, output files and messages.

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "apps/cli/program.h"
#include "cli.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "support/plugin_sets.h"

namespace kinome::test::program_test {
namespace {

using namespace program;

TEST_F(Program, ImageIsBesideTheScene) {
  render_quietly({});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{folder_.path("scene.exr")});
  const Image image = read_exr(folder_.path("scene.exr"));
  EXPECT_EQ(image.width, 48);
  EXPECT_EQ(image.height, 48);
  EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
}

/// Unsupported parts of Mitsuba scenes are errors, or are omitted and listed.
TEST_F(Program, LenientLeavesOutUnsupportedPlugins) {
  const std::string scene = folder_.write(
      "fog.xml",
      "<scene version=\"3.0.0\"><sensor type=\"perspective\"><float name=\"fov\" value=\"30\"/>"
      "<film type=\"hdrfilm\"><integer name=\"width\" value=\"4\"/><integer name=\"height\" "
      "value=\"4\"/></film></sensor>\n<shape type=\"sphere\"/>\n"
      "<shape id=\"the-other-one\" type=\"sdfgrid\"/></scene>");
  const std::string title = "shape 'sdfgrid'";
  const ProcessResult strict = kinome({scene, "-o", image_});
  EXPECT_EQ(strict.status, 1);
  EXPECT_EQ(strict.err, "kinome: " + scene + ":3:27: unsupported " + title +
                            " of Mitsuba 3 (--lenient renders without it)\n");
  const ProcessResult lenient = kinome({scene, "--lenient", "-o", image_});
  EXPECT_EQ(lenient.status, 0);
  EXPECT_NE(lenient.err.find("warning: " + scene + ":3:1: " + title + " is left out\n"),
            std::string::npos)
      << lenient.err;
  ImageMetadata metadata;
  read_exr(image_, {}, &metadata);
  EXPECT_EQ(metadata["kinome:left_out"], scene + ":3:1: " + title);
  EXPECT_EQ(kinome({scene, "--check", "--lenient"}).status, 0);
}

TEST_F(Program, ExtensionIsAppended) {
  render_quietly({"-o", folder_.path("picture.v2")});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{folder_.path("picture.v2.exr")});
}

TEST_F(Program, SameBitsAtAnyThreadCountAndOtherBitsForAnotherSeed) {
  for (const InstructionSet set : instruction_sets()) {
    const std::string isa = to_string(set);
    for (const char* integrator : {"direct", "path", "ptracer", "clustered"}) {
      SCOPED_TRACE(isa + ' ' + integrator);
      const auto with = [&](const char* threads, const char* seed = "0") {
        return picture({"--isa", isa, "-D", std::string("integrator=") + integrator, "-t", threads,
                        "--seed", seed});
      };
      const std::string one = with("1");
      EXPECT_EQ(with("2"), one);
      EXPECT_EQ(with("5"), one);
      EXPECT_NE(with("1", "1"), one);
    }
  }
}

TEST_F(Program, MetadataDescribesTheRender) {
  picture({"--seed", "7", "-D", "spp=3"});
  ImageMetadata metadata;
  read_exr(image_, {}, &metadata);
  EXPECT_EQ(metadata["kinome:seed"], "7");
  EXPECT_EQ(metadata["kinome:samples"], "3");
  EXPECT_EQ(metadata["kinome:integrator"], "direct");
  EXPECT_EQ(metadata["kinome:scene"], scene_);
  EXPECT_EQ(metadata["kinome:complete"], "true");
  EXPECT_EQ("kinome " + metadata["kinome:version"] + "\n", kinome({"--version"}).out);
  for (const char* plugin : {"integrator/direct", "sensor/perspective", "shape/sphere"}) {
    EXPECT_NE((" " + metadata["kinome:plugins"] + " ").find(std::string(" ") + plugin + " "),
              std::string::npos)
        << metadata["kinome:plugins"];
  }
  const std::string hash = metadata["kinome:scene_hash"];
  EXPECT_EQ(hash.size(), 16u) << hash;
  picture({"-D", "spp=2"});
  read_exr(image_, {}, &metadata);
  EXPECT_NE(metadata["kinome:scene_hash"], hash) << "the hash must depend on -D";
}

TEST_F(Program, SensorByIndexAndById) {
  const std::string front = picture({});
  EXPECT_EQ(picture({"-s", "0"}), front);
  EXPECT_EQ(picture({"-s", "front"}), front);
  const std::string above = picture({"-s", "1"});
  EXPECT_EQ(picture({"--sensor", "above"}), above);
  EXPECT_EQ(read_exr(image_).width, 20);
  EXPECT_EQ(read_exr(image_).height, 10);
}

TEST_F(Program, SearchPathsAreSplitAtSemicolons) {
  folder_.write("include/part.xml",
                "<scene version=\"3.0.0\"><emitter type=\"constant\"/></scene>");
  std::filesystem::create_directories(folder_.path("empty"));
  std::string xml = small_scene();
  const std::string emitter = "<emitter type=\"constant\"/>";
  xml.replace(xml.find(emitter), emitter.size(), "<include filename=\"part.xml\"/>");
  folder_.write("scene.xml", xml);
  EXPECT_EQ(kinome({"-q", scene_}).status, 1);
  render_quietly({"-a", folder_.path("empty") + ";" + folder_.path("include")});
  render_quietly({"-a", folder_.path("empty"), "-a", folder_.path("include")});
}

TEST_F(Program, MissingFoldersAreWarnings) {
  const std::string none = folder_.path("none"), other = folder_.path("other");
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {"env", "KINOME_PLUGIN_PATH=" + other, KINOME_TEST_PROGRAM});
    return run_process(arguments);
  };
  const ProcessResult result =
      run({scene_, "-o", image_, "--plugin-path", none, "--plugin-path", none, "--plugin-path",
           folder_.folder(), "-a", scene_ + ";" + folder_.folder()});
  EXPECT_EQ(result.status, 0) << result.err;
  const std::string expected = "kinome: warning: --plugin-path '" + none +
                               "': no such folder\n"
                               "kinome: warning: KINOME_PLUGIN_PATH '" +
                               other +
                               "': no such folder\n"
                               "kinome: warning: --append '" +
                               scene_ + "': not a folder\n";
  EXPECT_EQ(result.err.substr(0, expected.size()), expected) << result.err;
  EXPECT_EQ(result.err.find("warning", expected.size()), std::string::npos) << result.err;
  EXPECT_EQ(run({"-q", scene_, "-o", image_, "-a", none}).err, "");
  const ProcessResult plugins = run({"plugins", "--plugin-path", none});
  EXPECT_EQ(plugins.status, 0);
  EXPECT_EQ(lines(plugins.err), 2u) << plugins.err;
}

TEST_F(Program, PngIsBesideTheImage) {
  picture({"--png"});
  const std::string plain = read_text(folder_.path("a.png"));
  EXPECT_EQ(plain.substr(0, 8), "\x89PNG\r\n\x1a\n");
  picture({"--png", "--exposure", "-1.5"});
  EXPECT_NE(read_text(folder_.path("a.png")), plain);
}

TEST_F(Program, WarnsOfEmittersWithoutArea) {
  folder_.write("line.ply",
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                "end_header\n0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n");
  const auto warning_of = [&](const std::string& shape) {
    std::string xml = small_scene();
    xml.insert(xml.find("</scene>"), shape + "<emitter type=\"area\"/></shape>");
    const ProcessResult result = kinome({folder_.write("lamp.xml", xml)});
    EXPECT_EQ(result.status, 0) << result.err;
    const size_t at = result.err.find("lamp.xml:27:1: this emitter ");
    return at == std::string::npos ? "" : result.err.substr(at + 28, 9);
  };
  const auto sphere = [](const std::string& radius) {
    return "<shape type=\"sphere\"><point name=\"center\" value=\"0 4 0\"/>"
           "<float name=\"radius\" value=\"" +
           radius + "\"/>";
  };
  EXPECT_EQ(warning_of("<shape type=\"ply\"><string name=\"filename\" value=\"line.ply\"/>"),
            "has no ar");
  EXPECT_EQ(warning_of("<shape type=\"rectangle\"><transform name=\"to_world\">"
                       "<scale value=\"1e-12\"/><translate y=\"4\"/></transform>"),
            "has no ar");
  EXPECT_EQ(warning_of(sphere("1e-12")), "is so sma");
  EXPECT_EQ(warning_of(sphere("1e-5")), "");
  // Thousands of them aren't reported one by one, but the message states that there are more.
  const auto warnings_of = [&](int lamps) {
    std::string xml = small_scene();
    for (int i = 0; i < lamps; ++i) {
      xml.insert(xml.find("</scene>"), sphere("1e-12") + "<emitter type=\"area\"/></shape>\n");
    }
    const std::string err = kinome({folder_.write("lamps.xml", xml)}).err;
    int count = 0;
    for (size_t at = 0; (at = err.find("this emitter", at)) != std::string::npos; ++at) ++count;
    return std::pair(count, err.find("no further ones") != std::string::npos);
  };
  EXPECT_EQ(warnings_of(5), std::pair(5, false));
  EXPECT_EQ(warnings_of(8), std::pair(6, true));
}

TEST_F(Program, WarnsOfChannelsThatAPfmCannotHold) {
  std::string xml = small_scene();
  const std::string integrator = "<integrator type=\"$integrator\"/>";
  xml.replace(xml.find(integrator), integrator.size(),
              "<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth\"/></integrator>");
  const auto run = [&] { return kinome({folder_.write("aov.xml", xml)}); };
  EXPECT_EQ(run().err.find("warning"), std::string::npos);
  xml.insert(xml.find("<rfilter"), "<string name=\"file_format\" value=\"pfm\"/>");
  EXPECT_NE(run().err.find("store only colour"), std::string::npos) << run().err;
}

/// The emitter that an integrator adds itself is reported only with debug messages.
TEST_F(Program, LightPointsOfABounceComeWithoutANotice) {
  std::string xml = small_scene();
  xml.replace(xml.find("\"$integrator\"/>"), 16,
              "\"clustered\"><integer name=\"max_depth\" value=\"3\"/></integrator>");
  xml.erase(xml.find("<default"), xml.find("/>") + 2 - xml.find("<default"));
  const std::string scene = folder_.write("bounce.xml", xml);
  const auto log_with = [&](const char* verbosity) {
    const ProcessResult result = kinome({scene, verbosity, "-D", "width=8", "-D", "spp=1"});
    EXPECT_EQ(result.status, 0) << result.err;
    return result.err;
  };
  EXPECT_EQ(log_with("-v").find("vpl"), std::string::npos) << log_with("-v");
  EXPECT_NE(log_with("-vv").find("adds a 'vpl' emitter"), std::string::npos) << log_with("-vv");
}

TEST_F(Program, VariantIsAcceptedWithANote) {
  const ProcessResult result = kinome({"-m", "scalar_rgb", scene_});
  EXPECT_EQ(result.status, 0);
  EXPECT_NE(result.err.find("scalar_rgb"), std::string::npos) << result.err;
  render_quietly({"-m", "scalar_rgb"});
}

}  // namespace
}  // namespace kinome::test::program_test
