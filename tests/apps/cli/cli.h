#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/render.h"

namespace kinome::test {

/// Fixture of the program's tests: a folder, a small scene, and the program.
class Cli : public ::testing::Test {
 protected:
  static ProcessResult kinome(std::vector<std::string> arguments, double timeout_seconds = 1200) {
    arguments.insert(arguments.begin(), KINOME_TEST_PROGRAM);
    return run_process(arguments, timeout_seconds);
  }

  /// A sphere on a floor under constant light; `$integrator`, `$width` and `$spp` have defaults.
  static std::string small_scene() {
    return R"(<scene version="3.0.0">
  <default name="integrator" value="direct"/>
  <default name="width" value="48"/>
  <default name="spp" value="4"/>
  <integrator type="$integrator"/>
  <sensor type="perspective" id="front">
    <transform name="to_world"><lookat origin="0 2 4" target="0 .5 0" up="0 1 0"/></transform>
    <sampler type="independent"><integer name="sample_count" value="$spp"/></sampler>
    <film type="hdrfilm">
      <integer name="width" value="$width"/> <integer name="height" value="$width"/>
      <rfilter type="box"/>
    </film>
  </sensor>
  <sensor type="perspective" id="above">
    <transform name="to_world"><lookat origin="0 5 0" target="0 0 0" up="0 0 1"/></transform>
    <sampler type="independent"/>
    <film type="hdrfilm">
      <integer name="width" value="20"/> <integer name="height" value="10"/>
      <rfilter type="box"/>
    </film>
  </sensor>
  <emitter type="constant"/>
  <shape type="sphere"><point name="center" value="0 1 0"/></shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="-90"/> <scale value="3"/></transform>
  </shape>
</scene>
)";
  }

  /// Returns all files below the folder except those that the test wrote itself: images, and files
  /// that the program left behind.
  std::vector<std::string> other_files(const std::vector<std::string>& own) const {
    std::vector<std::string> others;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.folder())) {
      if (entry.is_directory()) continue;
      const std::string path = entry.path().string();
      if (std::find(own.begin(), own.end(), path) == own.end()) others.push_back(path);
    }
    return others;
  }

  static std::string read_text(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }
  static size_t lines(const std::string& text) {
    return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
  }

  TemporaryFolder folder_;
};

/// Expects a user error: status 1, and one line that contains `place` and `parts`.
inline void expect_one_error(const ProcessResult& result, const std::string& place,
                             const std::vector<std::string>& parts) {
  EXPECT_EQ(result.status, 1) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  const std::string start = "kinome: " + (place.empty() ? "" : place + ": ");
  EXPECT_EQ(result.err.substr(0, start.size()), start) << result.err;
  for (const std::string& part : parts) {
    EXPECT_NE(result.err.find(part), std::string::npos) << "no '" << part << "' in " << result.err;
  }
}

}  // namespace kinome::test
