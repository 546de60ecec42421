#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "kinome/image.h"
#include "kinome/scene.h"
#include "kinome/scene_editor.h"
#include "support/render.h"

/// A scene with many kinds of objects, for tests of edits.
namespace kinome::test::scene_edits {

/// Texts in the scene file; each case changes one of them.
struct Texts {
  std::string fov = "40";
  std::string samples = "4";
  std::string stddev = "0.5";
  std::string width = "24";
  std::string depth = "3";
  std::string red = "0.6, 0.2, 0.1";
  std::string alpha = "0.3";
  std::string color0 = "0.4";
  std::string radiance = "3, 2, 1";
  std::string sky = "0.2";
  std::string ball = "0, 0.5, 0";
  std::string group_red = "0.3, 0.4, 0.5";
  std::string mesh = "mesh.ply";
};

inline std::string scene_text(const Texts& t) {
  return R"(<scene version="3.0.0">
  <integrator type="path"> <integer name="max_depth" value=")" +
         t.depth + R"("/> </integrator>
  <sensor type="perspective">
    <float name="fov" value=")" +
         t.fov + R"("/>
    <transform name="to_world">
      <lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/> </transform>
    <sampler type="independent">
      <integer name="sample_count" value=")" +
         t.samples + R"("/> </sampler>
    <film type="hdrfilm">
      <integer name="width" value=")" +
         t.width + R"("/> <integer name="height" value="16"/>
      <rfilter type="gaussian"><float name="stddev" value=")" +
         t.stddev + R"("/></rfilter>
    </film>
  </sensor>
  <bsdf type="twosided" id="red">
    <bsdf type="diffuse"><rgb name="reflectance" value=")" +
         t.red + R"("/></bsdf>
  </bsdf>
  <shape type="sphere" id="ball">
    <point name="center" value=")" +
         t.ball + R"("/> <float name="radius" value="0.5"/>
    <ref id="red"/>
  </shape>
  <shape type="ply" id="mesh">
    <string name="filename" value=")" +
         t.mesh + R"("/>
    <bsdf type="roughconductor"><float name="alpha" value=")" +
         t.alpha + R"("/></bsdf>
  </shape>
  <shape type="disk" id="floor">
    <transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse">
      <texture type="checkerboard" name="reflectance">
        <float name="color0" value=")" +
         t.color0 + R"("/>
        <transform name="to_uv"><scale value="4"/></transform>
      </texture>
    </bsdf>
  </shape>
  <shape type="rectangle" id="lamp">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
    <emitter type="area"><rgb name="radiance" value=")" +
         t.radiance + R"("/></emitter>
  </shape>
  <shape type="shapegroup" id="group">
    <shape type="cube" id="box">
      <transform name="to_world"><scale value="0.2"/></transform>
      <bsdf type="diffuse"><rgb name="reflectance" value=")" +
         t.group_red + R"("/></bsdf>
    </shape>
  </shape>
  <shape type="instance" id="near">
    <ref id="group"/> <transform name="to_world"><translate x="1.2" y="0.3" z="1"/></transform>
  </shape>
  <emitter type="constant" id="sky">
    <rgb name="radiance" value=")" +
         t.sky + R"("/> </emitter>
</scene>)";
}

inline std::string mesh_text(float height) {
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
          "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
          "-2 0 -1\n2 0 -1\n2 2.5 -1.5\n-2 "
       << height << " -1\n3 0 1 2\n3 0 2 3\n";
  return text.str();
}

class SceneEdits : public testing::Test {
 protected:
  SceneEdits() {
    folder_.write("mesh.ply", mesh_text(2));
    folder_.write("other.ply", mesh_text(3));
  }
  std::unique_ptr<SceneEditor> open(const Texts& texts = {}) {
    const std::string path = folder_.write("scene.xml", scene_text(texts));
    return std::make_unique<SceneEditor>(path, LoadOptions{}, registry());
  }
  static void expect_same(const Scene& edited, const Scene& other) {
    const Image a = render_scene(edited), b = render_scene(other);
    ASSERT_EQ(a.width, b.width);
    EXPECT_EQ(a.data, b.data);
  }
  TemporaryFolder folder_;
};

using Names = std::vector<std::string>;

}  // namespace kinome::test::scene_edits
