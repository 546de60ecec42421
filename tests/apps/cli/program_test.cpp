// Tests of the program's options, output files and messages.

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "cli.h"
#include "kinome/image_files.h"
#include "kinome/image.h"
#include "support/plugin_sets.h"

namespace kinome::test::program_test {
namespace {

using nlohmann::json;

class Program : public Cli {
 protected:
  Program() : scene_(folder_.write("scene.xml", small_scene())), image_(folder_.path("a.exr")) {}

  /// Renders with -q, which must print nothing.
  void render_quietly(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"-q", scene_});
    const ProcessResult result = kinome(arguments);
    EXPECT_EQ(result.status, 0) << result.err;
    EXPECT_EQ(result.err, "");
    EXPECT_EQ(result.out, "");
  }
  /// Returns the bytes of the image with these options.
  std::string picture(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"-o", image_});
    render_quietly(arguments);
    return read_text(image_);
  }

  std::string scene_;
  std::string image_;
};

TEST_F(Program, PictureLiesBesideTheScene) {
  render_quietly({});
  EXPECT_EQ(other_files({scene_}), std::vector<std::string>{folder_.path("scene.exr")});
  const Image image = read_exr(folder_.path("scene.exr"));
  EXPECT_EQ(image.width, 48);
  EXPECT_EQ(image.height, 48);
  EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
}

/// Unsupported parts of Mitsuba scenes are errors, or are omitted and listed.
TEST_F(Program, LeavesOutWhatIsMissingIfAsked) {
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

TEST_F(Program, MetadataSaysHowThePictureWasMade) {
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

TEST_F(Program, PlacesThatAreNoFoldersAreWarnings) {
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

TEST_F(Program, PngLiesBesideThePicture) {
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

TEST_F(Program, StatsAsJson) {
  const ProcessResult result = kinome({"--stats=json", scene_, "-t", "2", "--seed", "3"});
  EXPECT_EQ(result.status, 0) << result.err;
  EXPECT_EQ(lines(result.out), 1u);
  const json stats = json::parse(result.out);
  const json& seconds = stats.at("seconds");
  for (const char* key :
       {"load", "plugins", "build", "first_tile", "render", "write", "total", "embree"}) {
    EXPECT_GE(seconds.at(key).get<double>(), 0) << key;
  }
  EXPECT_FALSE(seconds.at("stages").empty());
  const double parts = seconds.at("load").get<double>() + seconds.at("build").get<double>() +
                       seconds.at("render").get<double>() + seconds.at("write").get<double>();
  EXPECT_LE(parts, seconds.at("total").get<double>());
  EXPECT_GT(seconds.at("first_tile").get<double>(), seconds.at("load").get<double>());
  EXPECT_LT(seconds.at("first_tile").get<double>(), seconds.at("total").get<double>());
  EXPECT_GT(stats.at("embree_share").get<double>(), 0);
  EXPECT_LE(stats.at("embree_share").get<double>(), 1);

  EXPECT_EQ(stats.at("width"), 48);
  EXPECT_EQ(stats.at("height"), 48);
  EXPECT_EQ(stats.at("samples"), 4);
  EXPECT_EQ(stats.at("seed"), 3);
  EXPECT_EQ(stats.at("threads"), 2);
  EXPECT_EQ(stats.at("complete"), true);
  EXPECT_EQ(stats.at("scene"), scene_);
  EXPECT_EQ(stats.at("integrator"), "direct");
  EXPECT_EQ(stats.at("output"), folder_.path("scene.exr"));
  EXPECT_EQ(stats.at("rays").at("camera"), 48 * 48 * 4);
  for (const char* kind : {"shadow", "bsdf", "lobe"}) EXPECT_TRUE(stats.at("rays").contains(kind));
  for (const json& skipped : stats.at("skipped")) {
    EXPECT_FALSE(skipped.at("what").get<std::string>().empty());
    EXPECT_FALSE(skipped.at("why").get<std::string>().empty());
  }
  EXPECT_GT(stats.at("peak_memory_bytes").get<uint64_t>(), 1000000u);
  EXPECT_EQ(stats.at("non_finite_samples"), 0);

  const json& stages = stats.at("stage_threads");
  ASSERT_GE(stages.size(), 3u);
  EXPECT_EQ(stages.front().at("stage"), "load");
  EXPECT_EQ(stages.back().at("stage"), "write");
  double whole = 0;
  for (const json& stage : stages) {
    const double time = stage.at("seconds").get<double>();
    whole += time;
    EXPECT_LE(stage.at("partly_idle").get<double>(), time + 1e-6) << stage;
    ASSERT_EQ(stage.at("busy").size(), 2u);
    ASSERT_EQ(stage.at("committing").size(), 2u);
    for (const char* kind : {"busy", "committing"}) {
      for (const json& of_thread : stage.at(kind)) {
        EXPECT_GE(of_thread.get<double>(), 0) << stage;
        EXPECT_LE(of_thread.get<double>(), time + 1e-6) << stage;
      }
    }
  }
  EXPECT_NEAR(whole, seconds.at("total").get<double>(), 0.05);
}

/// --trace writes Chrome's trace format: a row for each thread, without overlapping events.
TEST_F(Program, TraceHasARowPerThread) {
  const std::string trace = folder_.path("trace.json");
  const ProcessResult result = kinome({"-q", scene_, "-t", "2", "--trace", trace});
  ASSERT_EQ(result.status, 0) << result.err;
  std::ifstream file(trace);
  const json events = json::parse(file).at("traceEvents");
  std::map<int, std::string> rows;
  std::map<int, std::vector<std::pair<double, double>>> times;
  std::set<std::string> names;
  for (const json& event : events) {
    const int thread = event.at("tid");
    if (event.at("ph") == "M") {
      EXPECT_EQ(event.at("name"), "thread_name");
      EXPECT_TRUE(rows.emplace(thread, event.at("args").at("name")).second) << thread;
      continue;
    }
    EXPECT_EQ(event.at("ph"), "X");
    EXPECT_GE(event.at("dur").get<double>(), 0);
    EXPECT_TRUE(event.at("cat") == "loop" || event.at("cat") == "serial") << event;
    EXPECT_TRUE(event.at("args").at("part").is_number()) << event;
    names.insert(event.at("name"));
    times[thread].emplace_back(event.at("ts"), event.at("dur"));
  }
  EXPECT_EQ(rows, (std::map<int, std::string>{{0, "thread 0"}, {1, "thread 1"}}));
  for (const char* name : {"load", "commit", "write"}) EXPECT_TRUE(names.count(name)) << name;
  for (auto& [thread, intervals] : times) {
    EXPECT_TRUE(rows.count(thread)) << thread;
    std::sort(intervals.begin(), intervals.end());
    for (size_t i = 1; i < intervals.size(); ++i) {
      EXPECT_GE(intervals[i].first, intervals[i - 1].first + intervals[i - 1].second - 1e-3);
    }
  }
}

TEST_F(Program, TraceFilesAreChecked) {
  expect_one_error(kinome({"-q", scene_, "--trace", folder_.path("no/trace.json")}), "",
                   {"does not exist"});
  const std::string image = folder_.path("a.exr");
  expect_one_error(kinome({"-q", scene_, "-o", image, "--trace", image}), "",
                   {"--trace " + image + ": must differ from the output file"});
  expect_one_error(kinome({"-q", scene_, "--checkpoint", image, "--trace", image}), "",
                   {"--trace " + image + ": must differ from the checkpoint"});
  expect_one_error(kinome({"-q", scene_, "-o", image, "--trace", scene_}), "",
                   {scene_, "was read"});
}

TEST_F(Program, StatsForPeopleGoToStderr) {
  const ProcessResult result = kinome({scene_, "--stats"});
  EXPECT_EQ(result.status, 0);
  EXPECT_EQ(result.out, "");
  for (const char* part :
       {"first tile", "Embree", "camera rays", "9216", "peak memory", "skipped"}) {
    EXPECT_NE(result.err.find(part), std::string::npos) << part << " in " << result.err;
  }
}

/// Stages are listed in the order in which they run, with a description, and parts add up to their
/// whole.
TEST_F(Program, StatsForPeopleAddUp) {
  const ProcessResult result =
      kinome({scene_, "--stats", "-t", "2", "-D", "integrator=clustered", "-D", "spp=160"});
  EXPECT_EQ(result.status, 0) << result.err;
  struct Row {
    size_t indent;
    std::string name;
    double share;
  };
  std::vector<Row> rows;
  std::istringstream text(result.err);
  for (std::string line; std::getline(text, line);) {
    // "  NAME    SECONDS s   SHARE %  PHRASE"
    const size_t indent = line.find_first_not_of(' '), unit = line.find(" s ");
    const size_t percent = line.find(" %", unit == std::string::npos ? 0 : unit);
    if (indent < 2 || unit == std::string::npos || percent == std::string::npos) continue;
    if (line.find("in Embree") != std::string::npos) continue;
    rows.push_back({indent, line.substr(indent, line.find("  ", indent) - indent),
                    std::stod(line.substr(unit + 3))});
  }
  ASSERT_FALSE(rows.empty()) << result.err;
  std::vector<std::string> stages;
  for (size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].indent == 2) stages.push_back(rows[i].name);
    double parts = 0;
    size_t count = 0;
    for (size_t k = i + 1; k < rows.size() && rows[k].indent > rows[i].indent; ++k) {
      if (rows[k].indent != rows[i].indent + 2) continue;
      parts += rows[k].share;
      ++count;
    }
    if (count == 0) continue;
    // Each is rounded to a tenth of a percent, and a negligible rest is omitted.
    EXPECT_NEAR(parts, rows[i].share, 0.05 * static_cast<double>(count + 1) + 0.1) << result.err;
  }
  const std::vector<std::string> order = {"load", "build", "render", "write"};
  ASSERT_GE(stages.size(), 5u) << result.err;
  EXPECT_TRUE(std::equal(order.begin(), order.end(), stages.begin())) << result.err;
  EXPECT_EQ(stages.back(), "total");
  const auto place = [&](const std::string& stage) {
    return result.err.find("\n    " + stage + " ");
  };
  EXPECT_LT(place("cells"), place("pilot")) << result.err;
  // A trial leaves this image to paths.
  EXPECT_LT(place("pilot"), place("trial")) << result.err;
  EXPECT_LT(place("trial"), place("primary")) << result.err;
  EXPECT_NE(result.err.find(" M/s "), std::string::npos) << result.err;
}

TEST_F(Program, InstructionSetsAreForced) {
  const std::string lowest = to_string(least_instruction_set());
  InstructionSet best_built = least_instruction_set();
  for (const InstructionSet set :
       PluginRegistry({KINOME_TEST_PLUGINS}).instruction_sets(Category::kBsdf, "diffuse")) {
    if (set <= processor_instruction_set()) best_built = std::max(best_built, set);
  }
  const std::string best = to_string(best_built);
  const auto isa_with = [&](const std::vector<std::string>& words, const std::string& variable) {
    std::vector<std::string> all = {
        "env", "KINOME_ISA=" + variable, KINOME_TEST_PROGRAM, "--stats=json", scene_, "-o", image_};
    all.insert(all.end(), words.begin(), words.end());
    const ProcessResult result = run_process(all);
    EXPECT_EQ(result.status, 0) << result.err;
    ImageMetadata metadata;
    read_exr(image_, {}, &metadata);
    const std::string isa = json::parse(result.out).at("isa");
    EXPECT_EQ(metadata["kinome:isa"], isa);
    return isa;
  };
  EXPECT_EQ(isa_with({}, ""), best);
  EXPECT_EQ(isa_with({}, lowest), lowest);
  EXPECT_EQ(isa_with({"--isa", lowest}, ""), lowest);
  if (best != lowest) {
    EXPECT_EQ(isa_with({"--isa", best}, lowest), best);
  }
  EXPECT_NE(kinome({scene_, "--stats"}).err.find("instruction set      " + best),
            std::string::npos);

  // If the processor supports a set but no plugin has it, the next lower one is used, with a
  // warning.
  if (best != lowest) {
    for (const auto& category : std::filesystem::directory_iterator(KINOME_TEST_PLUGINS)) {
      if (!category.is_directory()) continue;
      const auto to = std::filesystem::path(folder_.path("low")) / category.path().filename();
      std::filesystem::create_directories(to);
      for (const auto& file : std::filesystem::directory_iterator(category)) {
        if (file.path().extension() != ".so") continue;
        std::filesystem::copy_file(file, to / file.path().filename());
      }
    }
    const ProcessResult result =
        kinome({scene_, "-o", image_, "--isa", best, "--plugin-path", folder_.path("low")});
    EXPECT_NE(
        result.err.find("--isa " + best +
                        ": no plugin of this scene is built for it; using those for " + lowest),
        std::string::npos)
        << result.err;
  }

  const auto error_of = [&](const ProcessResult& result) {
    EXPECT_EQ(result.status, 1);
    EXPECT_EQ(lines(result.err), 1u) << result.err;
    return result.err.substr(0, result.err.find(" (available"));
  };
  EXPECT_EQ(error_of(kinome({scene_, "--isa", "avx2"})),
            "kinome: --isa: unknown instruction set 'avx2'");
  EXPECT_EQ(error_of(kinome({"plugins", "--isa", "avx2"})),
            "kinome: --isa: unknown instruction set 'avx2'");
  EXPECT_EQ(error_of(kinome({scene_, "--isa", ""})), "kinome: --isa: its value is empty\n");
  EXPECT_EQ(error_of(run_process({"env", "KINOME_ISA=sse", KINOME_TEST_PROGRAM, scene_})),
            "kinome: KINOME_ISA: unknown instruction set 'sse'");
}

TEST_F(Program, OnlyNamedPluginsAreLoaded) {
  const json stats = json::parse(kinome({"--stats=json", scene_}).out);
  const auto loaded = stats.at("plugins").get<std::set<std::string>>();
  EXPECT_EQ(loaded,
            (std::set<std::string>{"bsdf/diffuse", "emitter/constant", "film/hdrfilm",
                                   "integrator/direct", "rfilter/box", "sampler/independent",
                                   "sensor/perspective", "shape/rectangle", "shape/sphere"}));
  // The dynamic linker's trace proves which library is opened.
  const std::string trace = folder_.path("trace");
  const ProcessResult result = run_process(
      {"env", "LD_DEBUG=files", "LD_DEBUG_OUTPUT=" + trace, KINOME_TEST_PROGRAM, "-q", scene_});
  EXPECT_EQ(result.status, 0) << result.err;
  std::string opened;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.folder())) {
    if (entry.path().string().rfind(trace, 0) == 0) opened += read_text(entry.path());
  }
  EXPECT_NE(opened.find("/direct.so"), std::string::npos);
  EXPECT_NE(opened.find("libembree"), std::string::npos);
  for (const char* library : {"OpenImageIO", "tinygltf", "bitmap.so", "clustered.so"}) {
    EXPECT_EQ(opened.find(library), std::string::npos) << library << " was loaded";
  }
}

}  // namespace
}  // namespace kinome::test::program_test
