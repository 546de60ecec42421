#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "kinome/emitter.h"
#include "kinome/image.h"
#include "kinome/image_files.h"
#include "kinome/shape.h"
#include "kinome/warp.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"
#include "support/shape_helpers.h"

/// Emitters for tests of block functions.
namespace kinome::test::emitter_block {

constexpr float kRounding = 8 * 0x1p-24f;

struct Case {
  std::string name, xml;
  float largest = 1;  ///< largest radiance or intensity
  /// Change of the radiance if the direction is rounded, in kRounding of the largest radiance.
  float sharpness = 1;
};

inline Image black_image(int width, int height) {
  return {width, height, {"R", "G", "B"}, std::vector<float>(size_t{3} * width * height, 0.f)};
}

/// Returns noise over several magnitudes, with a black corner.
inline Image noise(int width, int height) {
  Image image = black_image(width, height);
  Random random(5);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float value = x + y < 4 ? 0 : std::exp(random.between(-6, 3));
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = value * random.between(.5f, 1);
    }
  }
  return image;
}
constexpr float kLargestNoise = 20.1f;

inline std::string file(const TemporaryFolder& folder, const std::string& name,
                        const Image& image) {
  write_pfm(folder.path(name), image);
  return "<string name='filename' value='" + folder.path(name) + "'/>";
}

inline const std::vector<Case>& lights() {
  static const TemporaryFolder folder;
  static const std::vector<Case> all = [] {
    const std::string map = file(folder, "map.pfm", noise(64, 40));
    const std::string tiny = file(folder, "tiny.pfm", noise(5, 3));
    const std::string black = file(folder, "black.pfm", black_image(8, 4));
    const std::string slide = file(folder, "slide.pfm", noise(7, 5));
    const std::string look =
        "<transform name='to_world'><lookat origin='.3, .2, -1' target='0, 0, 1' up='0, 1, 0'/>"
        "</transform>";
    const std::string turn =
        "<transform name='to_world'><rotate x='.36' y='.48' z='.8' angle='50'/></transform>";
    const auto emitter = [](const std::string& type, const std::string& inside) {
      return "<emitter type='" + type + "'>" + inside + "</emitter>";
    };
    const std::string texture = "<texture name='texture' type='bitmap'>" + slide + "</texture>";
    const std::string irradiance =
        "<texture name='irradiance' type='bitmap'>" + slide + "</texture>";
    return std::vector<Case>{
        {"constant", emitter("constant", "<rgb name='radiance' value='1 .5 .25'/>")},
        {"constant black", emitter("constant", "<rgb name='radiance' value='0 0 0'/>")},
        {"directional", emitter("directional", "<vector name='direction' value='1, -2, .5'/>")},
        {"directional black", emitter("directional", "<rgb name='irradiance' value='0 0 0'/>")},
        {"point", emitter("point", "<point name='position' value='.3, .2, -1'/>")},
        {"point black", emitter("point", "<rgb name='intensity' value='0 0 0'/>")},
        {"spot", emitter("spot", look), 1, 12},
        {"spot wide", emitter("spot", look + "<float name='cutoff_angle' value='150'/>"), 1, 2},
        {"spot of texture", emitter("spot", look + texture), kLargestNoise, 100},
        {"projector", emitter("projector", look), 8},
        {"projector of texture", emitter("projector", look + irradiance), 8 * kLargestNoise, 100},
        // The sharpness is the number of the map's columns, which span a full turn.
        {"envmap", emitter("envmap", map), kLargestNoise, 64},
        {"envmap turned", emitter("envmap", map + turn), kLargestNoise, 64},
        {"envmap compensated",
         emitter("envmap", map + "<boolean name='mis_compensation' value='true'/>"), kLargestNoise,
         64},
        {"envmap tiny", emitter("envmap", tiny), kLargestNoise, 64},
        {"envmap black", emitter("envmap", black)},
    };
  }();
  return all;
}

inline const std::vector<Case>& surfaces() {
  static const TemporaryFolder folder;
  static const std::vector<Case> all = [] {
    const std::string area = "<emitter type='area'><rgb name='radiance' value='3 2 1'/></emitter>";
    const std::string slide = file(folder, "slide.pfm", noise(7, 5));
    const std::string textured = "<emitter type='area'><texture name='radiance' type='bitmap'>" +
                                 slide + "</texture></emitter>";
    const std::string black = "<emitter type='area'><rgb name='radiance' value='0 0 0'/></emitter>";
    std::vector<Case> cases;
    for (const std::string type : {"rectangle", "cube", "sphere", "cylinder", "disk"}) {
      const std::string start = "<shape type='" + type + "'>";
      cases.push_back({type, start + area + "</shape>", 3});
      cases.push_back({type + " of texture", start + textured + "</shape>", kLargestNoise, 100});
      cases.push_back({type + " black", start + black + "</shape>", 0});
    }
    return cases;
  }();
  return all;
}

class EmitterBlocks : public testing::TestWithParam<InstructionSet> {
 protected:
  template <class Action>
  void for_lights(const Action& action) const {
    for (const Case& c : lights()) {
      SCOPED_TRACE(c.name);
      const auto emitter = make_for<Emitter>(GetParam(), c.xml);
      ASSERT_TRUE(emitter);
      action(c, *emitter);
    }
  }
  template <class Action>
  void for_surfaces(const Action& action) const {
    for (const Case& c : surfaces()) {
      SCOPED_TRACE(c.name);
      const auto shape = make_for<Shape>(GetParam(), c.xml);
      ASSERT_TRUE(shape && shape->emitter());
      action(c, *shape, *shape->emitter());
    }
  }
};

}  // namespace kinome::test::emitter_block
