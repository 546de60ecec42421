#pragma once

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "cli.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "support/plugin_sets.h"

/// Fixture for tests of the program with a small scene.
namespace kinome::test::program {

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

}  // namespace kinome::test::program
