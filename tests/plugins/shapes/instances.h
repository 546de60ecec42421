#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <numbers>
#include <sstream>

#include "kinome/block_points.h"
#include "kinome/texture.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"
#include "support/shape_helpers.h"

/// Instances of groups beside the same shapes moved, for tests.
namespace kinome::test::instances {

inline std::string moved(const std::string& operations) {
  return "<transform name='to_world'>" + operations + "</transform>";
}
inline std::string group_of(const std::string& shapes) {
  return "<shape type='shapegroup' id='group'>" + shapes + "</shape>";
}
inline std::string instance(const std::string& operations) {
  return "<shape type='instance'><ref id='group'/>" + moved(operations) + "</shape>";
}

constexpr const char* kObj = R"(
v -1 -1 0
v 1 -1 .3
v 1 1 -.2
v -1 1 .4
v 0 0 1
vt 0 0
vt 1 .1
vt .9 1
vt 0 .8
vt .5 .5
vn -.3 -.3 .9
vn .4 -.2 .9
vn .3 .3 .9
vn -.2 .4 .9
vn 0 0 1
f 1/1/1 2/2/2 5/5/5
f 2/2/2 3/3/3 5/5/5
f 3/3/3 4/4/4 5/5/5
f 4/4/4 1/1/1 5/5/5
)";

class Instances : public testing::Test {
 protected:
  /// Returns a shape of this type with the children `inside`.
  std::string shape(const std::string& type, const std::string& inside) const {
    const std::string file =
        type == "obj" ? "<string name='filename' value='" + obj_ + "'/>" : std::string();
    return "<shape type='" + type + "'>" + file + inside + "</shape>";
  }

 private:
  TemporaryFolder folder_;
  std::string obj_ = folder_.write("a.obj", kObj);
};

constexpr const char* kSimilar =
    "<scale value='1.7'/><rotate x='.36' y='.48' z='.8' angle='50'/><translate x='3' y='-2' "
    "z='.5'/>";
constexpr const char* kAffine = "<matrix value='1.5 .3 .2 3  0 .8 -.4 -2  .1 0 .6 .5  0 0 0 1'/>";
constexpr const char* kTurnedMirror =
    "<scale x='-1.7' y='1.7' z='1.7'/><rotate x='.36' y='.48' z='.8' angle='50'/>"
    "<translate x='3' y='-2' z='.5'/>";
constexpr const char* kMirrored =
    "<matrix value='-1.5 .3 .2 3  0 .8 -.4 -2  .1 0 .6 .5  0 0 0 1'/>";

}  // namespace kinome::test::instances
