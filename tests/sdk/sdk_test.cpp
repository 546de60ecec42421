// Tests of the installed package: its contents, how it finds external plugins, and which it
// refuses.

#include <algorithm>

#include "kinome/plugin.h"
#include "sdk.h"

namespace kinome::test::sdk_test {
namespace {

TEST_F(Sdk, InstallationRemovesObsoleteFiles) {
  EXPECT_EQ(fs::exists(left_behind()), fs::exists(std::string(KINOME_TEST_BUILD) + kRarePlugin));
}

TEST_F(Sdk, InstalledTreeIsComplete) {
  for (const char* name :
       {"bin/kinome", "bin/kinome-compare", "lib/kinome/python/compare/command.py",
        "lib/libkinome.so", "lib/libkinome_kit.so", "share/kinome/templates/CMakeLists.txt",
        "share/kinome/templates/shape/ring.cpp", "share/kinome/templates/shape/scene.xml", "include/kinome/plugin.h", "lib/kinome/plugins/bsdf/diffuse.so",
        "lib/kinome/plugins/sampler/ldsampler.so", "lib/cmake/kinome/KinomeConfig.cmake",
        "lib/cmake/kinome/KinomeConfigVersion.cmake", "lib/cmake/kinome/KinomeTargets.cmake",
        "lib/cmake/kinome/KinomePlugin.cmake", "lib/cmake/kinome/KinomeMachine.cmake",
        "include/kinome/sky.h", "include/kinome/image_files.h", "include/kinome/scene_editor.h",
        "include/kinome/parts.h", "include/kinome/scene_loader.h",
        "include/kinome/engine/transport/stages.h", "lib/libkinome_transport.a"}) {
    EXPECT_TRUE(fs::exists(fs::path(prefix_) / name)) << name;
  }
  // No installed file may refer to the build folder.
  for (const auto& entry : fs::recursive_directory_iterator(prefix_)) {
    if (!entry.is_regular_file() || entry.path().string().find("/cmake/") == std::string::npos) {
      continue;
    }
    EXPECT_EQ(read_text(entry.path()).find(KINOME_TEST_BUILD), std::string::npos) << entry.path();
  }
}

/// The comparison works without the source tree, and accepts the program's images.
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

TEST_F(Sdk, PluginsAreFoundByEnvironmentVariable) {
  const std::string scene = folder_->write("scene.xml", floor_scene("normals", ""));
  const std::string image = folder_->path("by_variable.exr");
  const ProcessResult without = run_process({program(), "-q", scene, "-o", image});
  EXPECT_EQ(without.status, 1);
  EXPECT_FALSE(fs::exists(image));
  EXPECT_NE(without.err.find("unknown integrator plugin 'normals'"), std::string::npos) << without.err;
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

/// A plugin from `kinome new` builds in any folder against the installed package and passes its
/// tests unchanged, with the printed commands. tests/check/new_test.py tests all categories.
TEST_F(Sdk, NewPluginPassesItsTestsUnchanged) {
  const std::string source = folder_->path("it's my sky");
  const ProcessResult made =
      run_process({program(), "new", "emitter", "my_sky", "--output", source});
  expect_success(made);
  EXPECT_NE(read_text(source + "/my_sky.cpp").find("class MySkyEmitter final"), std::string::npos);
  const std::string commands = made.out.substr(made.out.find('\n') + 1);
  const ProcessResult tests = run_process(
      {"env", "CXX=" KINOME_TEST_CXX, "CXXFLAGS=" + flags(), "CMAKE_GENERATOR=Ninja", "sh", "-e",
       folder_->write("commands.sh", commands)},
      300);
  expect_success(tests);
  EXPECT_NE(tests.out.find("100% tests passed, 0 tests failed out of 2"), std::string::npos)
      << commands << tests.out;
}

TEST_F(Sdk, ErrorsHaveTheirPositions) {
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

/// Moves the tree permanently, and is therefore the last test of the suite.
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
}  // namespace kinome::test::sdk_test
