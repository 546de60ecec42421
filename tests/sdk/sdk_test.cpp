// Plugins outside the tree, built against the installed package and rendered by the installed
// program.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "kinome/image.h"
#include "kinome/plugin.h"
#include "support/render.h"

namespace kinome::test {
namespace {

namespace fs = std::filesystem;

std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

void expect_success(const ProcessResult& result) {
  ASSERT_EQ(result.status, 0) << result.out << result.err;
}

/// A parameter of `clustered`.
const char* const kDirectLight = R"(<integer name="max_depth" value="2"/>)";

/// A diffuse floor of reflectance .5, seen from straight above, under whatever `light` is.
std::string floor_scene(const std::string& integrator, const std::string& light,
                        const std::string& parameters = "") {
  return R"(<scene version="3.0.0">
    <integrator type=")" +
         integrator + "\">" + parameters + R"(</integrator>
    <sensor type="perspective">
      <float name="fov" value="20"/>
      <transform name="to_world"><lookat origin="0 3 0" target="0 0 0" up="0 0 1"/></transform>
      <sampler type="independent"><integer name="sample_count" value="64"/></sampler>
      <film type="hdrfilm">
        <integer name="width" value="16"/> <integer name="height" value="16"/>
        <string name="component_format" value="float32"/>
        <rfilter type="box"/>
      </film>
    </sensor>
    <shape type="rectangle">
      <transform name="to_world">
        <rotate x="1" angle="-90"/>
        <scale value="10"/>
      </transform>
      <bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf>
    </shape>)" +
         light + "</scene>";
}

/// The scene with another BSDF of the floor: `type`, of albedo .5 and k = 3.
std::string with_bsdf(std::string scene, const std::string& type) {
  const std::string old = R"(<bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf>)";
  return scene.replace(scene.find(old), old.size(),
                       "<bsdf type='" + type + "'><float name='k' value='3'/></bsdf>");
}

Rgb mean_of(const Image& image) {
  double sum[3] = {0, 0, 0};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) sum[c] += image.at(x, y, c);
    }
  }
  const double pixels = static_cast<double>(image.width) * image.height;
  return {static_cast<float>(sum[0] / pixels), static_cast<float>(sum[1] / pixels),
          static_cast<float>(sum[2] / pixels)};
}

/// Installs Kinome once into a folder of its own, and builds the project against it once.
class Sdk : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    prefix_ = folder_->path("prefix");
    build_ = folder_->path("build");
    // What a build for another instruction set left there would be loaded in place of its successor.
    fs::create_directories(left_behind().parent_path());
    std::ofstream(left_behind()) << "of an older version";
    expect_success(
        run_process({KINOME_TEST_CMAKE, "--install", KINOME_TEST_BUILD, "--prefix", prefix_}));
    expect_success(configure(prefix_, build_));
    expect_success(run_process({KINOME_TEST_CMAKE, "--build", build_, "-j", "2"}, 300));
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static ProcessResult configure(const std::string& prefix, const std::string& build) {
    std::string flags;
    if (std::string(KINOME_TEST_SANITIZER) == "asan") flags = "-fsanitize=address,undefined";
    if (std::string(KINOME_TEST_SANITIZER) == "tsan") flags = "-fsanitize=thread";
    return run_process({KINOME_TEST_CMAKE, "-S",
                        std::string(KINOME_TEST_SOURCE) + "/tests/sdk/project", "-B", build, "-G",
                        "Ninja", "-DCMAKE_PREFIX_PATH=" + prefix,
                        "-DCMAKE_CXX_COMPILER=" KINOME_TEST_CXX, "-DCMAKE_CXX_FLAGS=" + flags});
  }

  /// Of an instruction set that plugins usually are not built for.
  static constexpr const char* kRarePlugin = "/plugins/bsdf/x86-64-v2/diffuse.so";
  static fs::path left_behind() { return prefix_ + "/lib/kinome" + kRarePlugin; }

  static std::string program() { return prefix_ + "/bin/kinome"; }
  static std::string plugins() { return build_ + "/plugins"; }

  /// Renders with the installed program, finding the plugins by --plugin-path.
  static Image render_text(const std::string& xml, const std::vector<std::string>& options = {}) {
    const std::string scene = folder_->write("scene.xml", xml);
    const std::string image = folder_->path("image.exr");
    std::vector<std::string> command = {program(),       "-q",     scene, "-o", image,
                                        "--plugin-path", plugins()};
    command.insert(command.end(), options.begin(), options.end());
    const ProcessResult result = run_process(command);
    EXPECT_EQ(result.status, 0) << result.err;
    return result.status == 0 ? read_exr(image) : Image{};
  }

  static TemporaryFolder* folder_;
  static std::string prefix_;
  static std::string build_;
};
TemporaryFolder* Sdk::folder_ = nullptr;
std::string Sdk::prefix_;
std::string Sdk::build_;

TEST_F(Sdk, InstallationRemovesWhatIsNoLongerBuilt) {
  EXPECT_EQ(fs::exists(left_behind()), fs::exists(std::string(KINOME_TEST_BUILD) + kRarePlugin));
}

TEST_F(Sdk, InstalledTreeHoldsWhatItShould) {
  for (const char* name :
       {"bin/kinome", "bin/kinome-compare", "lib/kinome/python/compare/command.py",
        "lib/libkinome.so", "include/kinome/plugin.h", "lib/kinome/plugins/bsdf/diffuse.so",
        "lib/kinome/plugins/sampler/ldsampler.so", "lib/cmake/kinome/KinomeConfig.cmake",
        "lib/cmake/kinome/KinomeConfigVersion.cmake", "lib/cmake/kinome/KinomeTargets.cmake",
        "lib/cmake/kinome/KinomePlugin.cmake"}) {
    EXPECT_TRUE(fs::exists(fs::path(prefix_) / name)) << name;
  }
  // Nothing installed may lead back to where it was built.
  for (const auto& entry : fs::recursive_directory_iterator(prefix_)) {
    if (!entry.is_regular_file() || entry.path().string().find("/cmake/") == std::string::npos) {
      continue;
    }
    EXPECT_EQ(read_text(entry.path()).find(KINOME_TEST_BUILD), std::string::npos) << entry.path();
  }
}

/// The comparison needs nothing of the source tree, and knows the program's pictures.
TEST_F(Sdk, InstalledComparisonRuns) {
  const std::string scene =
      folder_->write("floor.xml", floor_scene("direct", R"(<emitter type="constant"/>)"));
  std::vector<std::string> pictures;
  for (const char* seed : {"1", "2"}) {
    pictures.push_back(folder_->path(std::string("seed") + seed + ".exr"));
    expect_success(
        run_process({program(), "-q", "--variance", "--seed", seed, "-o", pictures.back(), scene}));
  }
  const ProcessResult result =
      run_process({prefix_ + "/bin/kinome-compare", pictures[0], pictures[1]});
  EXPECT_EQ(result.status, 0) << result.out << result.err;
  EXPECT_NE(result.out.find("seed2.exr, 16 renders\n"), std::string::npos) << result.out;
}

/// Closed form: a floor of reflectance rho under L = h + (z - h) cos theta shows
/// rho / pi (pi h + 2 pi / 3 (z - h)) = rho (h + 2/3 (z - h)).
TEST_F(Sdk, SkyGradientLightsAFloorAsDerived) {
  const std::string sky = R"(<emitter type="sky_gradient"><rgb name="zenith" value=".1 .4 2"/>
      <rgb name="horizon" value="1 .4 .5"/></emitter>)";
  const double zenith[3] = {.1, .4, 2};
  const double horizon[3] = {1, .4, .5};
  // direct: 16384 samples of uniform directions and cosine lobes by MIS. Each sample's standard
  // deviation is below the value itself, so that the mean's is below 1/128 of it; 5 of them:
  // false alarms of 6e-7. clustered adds the points' own error, of the order of one cell.
  for (const char* integrator : {"direct", "clustered"}) {
    const std::string depth = std::string(integrator) == "direct" ? "" : kDirectLight;
    const Rgb mean = mean_of(render_text(floor_scene(integrator, sky, depth)));
    for (int c = 0; c < 3; ++c) {
      const double expected = .5 * (horizon[c] + 2. / 3 * (zenith[c] - horizon[c]));
      EXPECT_NEAR(mean[c], expected, expected * 5 / 128) << integrator << ", channel " << c;
    }
  }
}

/// The same by cells, which the plugin's emitter offers: all of product sampling's stages run, and
/// nothing is hidden, so that control terms leave hardly any noise.
TEST_F(Sdk, SkyGradientIsSampledByItsCells) {
  const std::string sky = R"(<emitter type="sky_gradient"><rgb name="zenith" value=".1 .4 2"/>
      <rgb name="horizon" value="1 .4 .5"/></emitter>)";
  const std::string scene =
      folder_->write("cells.xml", floor_scene("clustered", sky, kDirectLight));
  const std::string image = folder_->path("cells.exr");
  const ProcessResult result = run_process(
      {program(), "-q", scene, "-o", image, "--plugin-path", plugins(), "--stats=json"});
  expect_success(result);
  for (const char* stage : {"\"cells\"", "\"pilot\"", "\"plan\"", "\"main\""}) {
    EXPECT_NE(result.out.find(stage), std::string::npos) << stage << result.out;
  }
  const Rgb mean = mean_of(read_exr(image));
  const double zenith[3] = {.1, .4, 2}, horizon[3] = {1, .4, .5};
  for (int c = 0; c < 3; ++c) {
    const double expected = .5 * (horizon[c] + 2. / 3 * (zenith[c] - horizon[c]));
    EXPECT_NEAR(mean[c], expected, expected * 2e-3) << c;
  }

  // Light after a bounce takes what this emitter doesn't offer, which is no secret.
  const std::string bounce = folder_->write("bounce.xml", floor_scene("clustered", sky));
  const ProcessResult told =
      run_process({program(), bounce, "-o", image, "--plugin-path", plugins()});
  expect_success(told);
  EXPECT_NE(told.err.find("what importance 'product' needs for light after a bounce"),
            std::string::npos)
      << told.err;
}

TEST_F(Sdk, IntegratorShowsNormals) {
  const Image image = render_text(floor_scene("normals", ""));
  ASSERT_EQ(image.width, 16);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      // n = (0, 1, 0) after a rotation by 90 degrees in floats: within a few ulp of it.
      EXPECT_NEAR(image.at(x, y, 0), .5f, 1e-6f);
      EXPECT_NEAR(image.at(x, y, 1), 1.f, 1e-6f);
      EXPECT_NEAR(image.at(x, y, 2), .5f, 1e-6f);
    }
  }
}

TEST_F(Sdk, PluginsAreFoundByEnvironmentVariable) {
  const std::string scene = folder_->write("scene.xml", floor_scene("normals", ""));
  const std::string image = folder_->path("by_variable.exr");
  const ProcessResult without = run_process({program(), "-q", scene, "-o", image});
  EXPECT_EQ(without.status, 1);
  EXPECT_FALSE(fs::exists(image));
  EXPECT_NE(without.err.find("no integrator plugin 'normals'"), std::string::npos) << without.err;
  expect_success(run_process({"env", "KINOME_PLUGIN_PATH=/nonexistent:" + plugins(), program(),
                              "-q", scene, "-o", image}));
  EXPECT_TRUE(fs::exists(image));
}

TEST_F(Sdk, PluginsAreListed) {
  const ProcessResult one =
      run_process({program(), "plugins", "sky_gradient", "--plugin-path", plugins()});
  expect_success(one);
  EXPECT_NE(one.out.find("emitter/sky_gradient"), std::string::npos) << one.out;
  EXPECT_NE(one.out.find("Radiance straight up."), std::string::npos) << one.out;
  EXPECT_NE(one.out.find("0.2 0.4 1"), std::string::npos) << one.out;
}

/// The instruction sets that there are libraries for in `folder`, each of which holds `names`.
std::vector<std::string> sets_built(const fs::path& folder, const std::vector<std::string>& names) {
  std::vector<std::string> sets = {to_string(InstructionSet::kBaseline)};
  for (int i = 1; i < kInstructionSetCount; ++i) {
    const char* set = to_string(static_cast<InstructionSet>(i));
    if (!fs::exists(folder / set)) continue;
    for (const std::string& name : names) EXPECT_TRUE(fs::exists(folder / set / name)) << set;
    sets.emplace_back(set);
  }
  if (processor_instruction_set() > InstructionSet::kBaseline) {
    EXPECT_GT(sets.size(), 1u);
  }
  return sets;
}

/// A wide plugin is a library for each instruction set, under both of its names.
TEST_F(Sdk, WidePluginsAreBuiltForEachInstructionSet) {
  const auto sets = sets_built(fs::path(plugins()) / "texture", {"waves.so", "ripples.so"});
  std::string list;
  for (const std::string& set : sets) list += (list.empty() ? "  built for " : ", ") + set;
  std::vector<Image> images;
  for (const std::string& set : sets) {
    if (*instruction_set_named(set) > processor_instruction_set()) continue;
    for (const char* name : {"waves", "ripples"}) {
      const ProcessResult told = run_process({"env", "COLUMNS=200", program(), "plugins", name,
                                              "--plugin-path", plugins(), "--isa", set});
      expect_success(told);
      EXPECT_NE(told.out.find("Waves, built for " + set + "."), std::string::npos) << told.out;
      if (sets.size() > 1) {
        EXPECT_NE(told.out.find(list + "\n"), std::string::npos) << told.out;
      }
    }
    const std::string reflectance = R"(<rgb name="reflectance" value=".5"/>)";
    std::string xml = floor_scene("direct", "<emitter type='constant'/>");
    xml.replace(xml.find(reflectance), reflectance.size(),
                "<texture name='reflectance' type='waves'/>");
    const std::string scene = folder_->write("waves.xml", xml);
    const std::string image = folder_->path("waves.exr");
    expect_success(run_process(
        {program(), "-q", scene, "-o", image, "--plugin-path", plugins(), "--isa", set}));
    images.push_back(read_exr(image));
    const Rgb mean = mean_of(images.back()), first = mean_of(images.front());
    EXPECT_NEAR(mean.x, first.x, 1e-4f * first.x) << set;
  }
}

/// One reflector twice, point by point and by formulas for blocks.
TEST_F(Sdk, WideBsdfShowsWhatPointsDo) {
  const std::string source =
      read_text(std::string(KINOME_TEST_SOURCE) + "/tests/sdk/project/wide_minnaert.cpp");
  EXPECT_LE(std::count(source.begin(), source.end(), '\n'), 60);  // as the README says
  const fs::path folder = fs::path(plugins()) / "bsdf";
  EXPECT_FALSE(fs::exists(folder / to_string(InstructionSet::kX86V3) / "minnaert.so"));
  const std::string light = "<emitter type='constant'/>";
  const std::string bsdf_samples = R"(<integer name="emitter_samples" value="0"/>
      <integer name="bsdf_samples" value="1"/>)";
  // Under light of 1 from everywhere: the mean of albedo cos_i^(k - 1), k being 3.
  double expected = 0;
  for (int i = 0; i < 64 * 64; ++i) {
    const double side = std::tan(10 * M_PI / 180) / 32;
    const double u = side * (i % 64 - 31.5), v = side * (i / 64 - 31.5);
    expected += .5 / (1 + u * u + v * v) / (64 * 64);
  }
  for (const std::string& set : sets_built(folder, {"wide_minnaert.so"})) {
    if (*instruction_set_named(set) > processor_instruction_set()) continue;
    const ProcessResult told =
        run_process({"env", "COLUMNS=200", program(), "plugins", "wide_minnaert", "--plugin-path",
                     plugins(), "--isa", set});
    expect_success(told);
    EXPECT_NE(told.out.find("Minnaert's, for " + set + "\n"), std::string::npos) << told.out;
    for (const std::string& samples : {std::string(), bsdf_samples}) {
      const std::string scene = floor_scene("direct", light, samples);
      const Image points = render_text(with_bsdf(scene, "minnaert"), {"--isa", set});
      const Image wide = render_text(with_bsdf(scene, "wide_minnaert"), {"--isa", set});
      ASSERT_EQ(points.width, 16);
      ASSERT_EQ(wide.width, 16);
      for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
          // Formulas differ by some ulp (6e-8); near the horizon by more, of light that is less.
          EXPECT_NEAR(wide.at(x, y, 0), points.at(x, y, 0), 1e-6f * points.at(x, y, 0)) << set;
        }
      }
      // All samples of the lobe weigh the same; across a pixel, cos_i^2 has a standard deviation
      // below .2 %, the mean of 16384 one of 1.6e-5, of which 5 are allowed. With the light's
      // samples, it is below 1/128, see SkyGradientLightsAFloorAsDerived.
      const double tolerance = samples.empty() ? 5. / 128 : 8e-5;
      EXPECT_NEAR(mean_of(wide).x, expected, expected * tolerance) << set << samples;
    }
  }
}

TEST_F(Sdk, MistakesAreReportedAtTheirPlace) {
  const std::string scene =
      folder_->write("wrong.xml",
                     "<scene version=\"3.0.0\">\n  <emitter type=\"sky_gradient\">\n"
                     "    <float name=\"scale\" value=\"-1\"/>\n  </emitter>\n</scene>\n");
  const ProcessResult result =
      run_process({program(), scene, "-o", folder_->path("w.exr"), "--plugin-path", plugins()});
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(result.err.rfind("kinome: " + scene + ":3:", 0), 0u) << result.err;
  EXPECT_NE(result.err.find("must not be negative"), std::string::npos) << result.err;
}

TEST_F(Sdk, AnotherAbiIsRefused) {
  // The same library, with another interface version in its key.
  std::string library = read_text(plugins() + "/integrator/normals.so");
  const std::string version =
      "kinome-abi;interface=" + std::to_string(KINOME_INTERFACE_VERSION) + ";";
  size_t changed = 0;
  for (size_t at = library.find(version); at != std::string::npos; at = library.find(version, at)) {
    char& digit = library[at + version.size() - 2];
    digit = digit == '9' ? '8' : '9';
    ++changed;
  }
  ASSERT_GT(changed, 0u);
  folder_->write("abi/integrator/normals.so", library);
  const std::string scene = folder_->write("scene.xml", floor_scene("normals", ""));
  const std::string image = folder_->path("abi.exr");
  const ProcessResult result =
      run_process({program(), scene, "-o", image, "--plugin-path", folder_->path("abi")});
  EXPECT_EQ(result.status, 1);
  EXPECT_EQ(result.err.rfind("kinome: " + scene + ":2:", 0), 0u) << result.err;
  EXPECT_NE(result.err.find("another ABI"), std::string::npos) << result.err;
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_FALSE(fs::exists(image));
}

/// Moves the tree away for good: the last of the suite.
TEST_F(Sdk, MovedTreeWorks) {
  const std::string moved = folder_->path("elsewhere/deeper");
  fs::create_directories(fs::path(moved).parent_path());
  fs::rename(prefix_, moved);
  prefix_ = moved;
  const std::string scene = folder_->write("scene.xml", floor_scene("normals", ""));
  const std::string image = folder_->path("moved.exr");
  expect_success(run_process({program(), "-q", scene, "-o", image, "--plugin-path", plugins()}));
  EXPECT_TRUE(fs::exists(image));
  expect_success(run_process({program(), "plugins"}));
  expect_success(configure(moved, folder_->path("build2")));
  const std::string cache = read_text(folder_->path("build2/CMakeCache.txt"));
  EXPECT_NE(cache.find(moved + "/lib/cmake/kinome"), std::string::npos);
}

}  // namespace
}  // namespace kinome::test
