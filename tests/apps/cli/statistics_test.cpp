#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "apps/cli/program.h"
#include "cli.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "support/plugin_sets.h"

/// Tests --stats, --trace and --isa.
namespace kinome::test::statistics_test {
namespace {

using namespace program;
using nlohmann::json;

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

TEST_F(Program, StatsAsTextGoToStderr) {
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
TEST_F(Program, StatsAsTextAddUp) {
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
  const std::string lowest = to_string(min_instruction_set());
  InstructionSet best_built = min_instruction_set();
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
}  // namespace kinome::test::statistics_test
