#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "kinome/image_files.h"
#include "kinome/image.h"
#include "support/render.h"

/// Plugins outside the source tree, built against the installed package, and images that the
/// installed program renders with them.
namespace kinome::test {

namespace fs = std::filesystem;

inline std::string read_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline void expect_success(const ProcessResult& result) {
  ASSERT_EQ(result.status, 0) << result.out << result.err;
}

/// Returns a diffuse floor of reflectance .5, seen from straight above, under the XML `light`.
inline std::string floor_scene(const std::string& integrator, const std::string& light,
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

inline Rgb mean_of(const Image& image) {
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

/// Installs Kinome once into its own folder, and builds the project against it once.
class Sdk : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    prefix_ = folder_->path("prefix");
    build_ = folder_->path("build");
    // A plugin left by an older build for another instruction set would be loaded instead of the
    // new one.
    fs::create_directories(left_behind().parent_path());
    std::ofstream(left_behind()) << "of an older version";
    expect_success(
        run_process({KINOME_TEST_CMAKE, "--install", KINOME_TEST_BUILD, "--prefix", prefix_}));
    expect_success(configure(prefix_, build_));
    expect_success(run_process({KINOME_TEST_CMAKE, "--build", build_, "-j", "2"}));
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  static ProcessResult configure(const std::string& prefix, const std::string& build,
                                 const std::string& source = std::string(KINOME_TEST_SOURCE) +
                                                             "/tests/sdk/project") {
    return run_process({KINOME_TEST_CMAKE, "-S", source, "-B", build, "-G", "Ninja", "-DCMAKE_PREFIX_PATH=" + prefix,
                        "-DCMAKE_CXX_COMPILER=" KINOME_TEST_CXX, "-DCMAKE_CXX_FLAGS=" + flags(),
                        // Independent of the sets that the installed program is built for.
                        "-DKINOME_ISAS=x86-64-v3;x86-64-v4"});
  }
  /// Returns the compiler flags for the package's sanitizers.
  static std::string flags() {
    const std::string sanitizer = KINOME_TEST_SANITIZER;
    if (sanitizer == "asan" || sanitizer == "fuzz") return "-fsanitize=address,undefined";
    return sanitizer == "tsan" ? "-fsanitize=thread" : "";
  }

  /// A file of an instruction set for which plugins are usually not built.
  static constexpr const char* kRarePlugin = "/plugins/bsdf/x86-64-v2/diffuse.so";
  static fs::path left_behind() { return prefix_ + "/lib/kinome" + kRarePlugin; }

  static std::string program() { return prefix_ + "/bin/kinome"; }
  static std::string plugins() { return build_ + "/plugins"; }

  /// Renders with the installed program, which finds the plugins by --plugin-path.
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

  inline static TemporaryFolder* folder_ = nullptr;
  inline static std::string prefix_;
  inline static std::string build_;
};

}  // namespace kinome::test
