#pragma once

#include <string>
#include <vector>

#include "kinome/math.h"
#include "support/shape_helpers.h"
#include "support/render.h"

/// Test cases for shapes of every plugin: ordinary ones, and some that are numerically difficult.
namespace kinome::test {

struct ShapeCase {
  std::string name, xml;
  float size;  ///< extent of the region at which rays are aimed
  Vec3 centre{0.f};
  uint32_t primitives = 0;  ///< number of primitives; meshes only
};

/// Triangles of all kinds: ordinary, of zero area, of zero or nearly zero uv area, tiny, huge, and
/// with a zero normal.
inline constexpr const char* kTriangles = R"(
v 0 0 0
v 2 0 .5
v 0 1.5 .25
v 2 1 -1
v 1e-15 0 0
v 0 1e-15 2e-15
v 1e15 0 0
v 0 2e15 1e15
v 4 0 1
vt .1 .2
vt .8 .3
vt .2 .9
vt .5 .5
vt .50000006 .5
vt .5 .50000006
vn 0 0 1
vn .6 0 .8
vn 0 -.6 .8
vn 0 0 0
vn 0 0 -1
f 1/1/1 2/2/2 3/3/3
f 1/1/1 2/2/2 9/3/2
f 1/4/1 2/4/2 3/4/3
f 1/4/1 2/5/2 3/6/3
f 1/1/1 5/2/1 6/3/1
f 1/1/1 7/2/1 8/3/1
f 2/1/4 3/2/4 4/3/4
f 2/1/1 3/2/5 4/3/1
)";
inline constexpr const char* kPly = R"(ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property float u
property float v
element face 2
property list uchar int vertex_indices
end_header
0 0 0 0 0
2 0 .5 1 0
0 1.5 .25 .1 .9
2 1 -1 .8 1.2
3 0 1 2
3 1 3 2
)";
/// glTF file with the same four vertices and two triangles.
inline constexpr const char* kGltf =
    R"({"asset": {"version": "2.0"}, "scene": 0,
"scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
               "min": [0, 0, -1], "max": [2, 1.5, 0.5]},
              {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48},
                {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
"buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,)"
    "AAAAAAAAAAAAAAAAAAAAQAAAAAAAAAA/AAAAAAAAwD8AAIA+AAAAQAAAgD8AAIC/AAABAAIAAQADAAIA"
    R"("}]})";

inline const std::vector<ShapeCase>& shape_cases() {
  static const TemporaryFolder folder;
  static const std::vector<ShapeCase> all = [] {
    const std::string obj =
        "<string name='filename' value='" + folder.write("triangles.obj", kTriangles) + "'/>";
    const auto turned = [](const std::string& scale, const std::string& offset) {
      return "<transform name='to_world'><rotate x='.36' y='.48' z='.8' angle='50'/><scale " +
             scale + "/><translate " + offset + "/></transform>";
    };
    const auto shape = [](const std::string& type, const std::string& inside) {
      return "<shape type='" + type + "'>" + inside + "</shape>";
    };
    const std::string flip = "<boolean name='flip_normals' value='true'/>";
    const std::string flat = "<boolean name='face_normals' value='true'/>";
    const std::string moderate = turned("value='3'", "x='1' y='-2' z='.5'");
    const Vec3 middle(1, -2, .5f);
    return std::vector<ShapeCase>{
        {"sphere", shape("sphere", ""), 1},
        {"sphere turned", shape("sphere", moderate + flip), 3, middle},
        {"sphere mirrored", shape("sphere", turned("x='-1' y='1' z='1'", "x='1' y='-2' z='.5'")), 1,
         middle},
        {"sphere huge", shape("sphere", "<float name='radius' value='1e6'/>"), 1e6f},
        {"sphere tiny", shape("sphere", "<float name='radius' value='1e-5'/>"), 1e-5f},
        {"sphere far",
         shape("sphere", "<point name='center' value='1e5, 2e5, -3e4'/>"),
         1,
         {1e5f, 2e5f, -3e4f}},
        {"cylinder", shape("cylinder", ""), 1, {0, 0, .5f}},
        {"cylinder turned", shape("cylinder", moderate + flip), 3, middle},
        {"cylinder far",
         shape("cylinder", turned("value='.01'", "x='1e3' y='2e3' z='-3e3'")),
         .01f,
         {1e3f, 2e3f, -3e3f}},
        {"disk", shape("disk", ""), 1},
        {"disk ellipse", shape("disk", turned("x='3' y='1' z='2'", "x='1' y='-2' z='.5'")), 2,
         middle},
        {"disk far",
         shape("disk", turned("value='2'", "x='1e5' y='2e5' z='-3e4'") + flip),
         2,
         {1e5f, 2e5f, -3e4f}},
        {"rectangle", shape("rectangle", ""), 1, Vec3(0.f), 2},
        {"rectangle turned",
         shape("rectangle", turned("x='3' y='1' z='2'", "x='1'") + flip),
         2,
         {1, 0, 0},
         2},
        {"rectangle mirrored",
         shape("rectangle", turned("x='-3' y='1' z='2'", "x='1e3'")),
         2,
         {1e3f, 0, 0},
         2},
        {"cube", shape("cube", moderate), 3, middle, 12},
        {"obj", shape("obj", obj), 1, Vec3(0.f), 8},
        {"obj flipped", shape("obj", obj + flip + moderate), 3, Vec3(0.f), 8},
        {"obj flat", shape("obj", obj + flat), 1, Vec3(0.f), 8},
        {"obj small", shape("obj", obj + turned("value='1e-6'", "x='.5'")), 1e-6f, Vec3(0.f), 8},
        {"ply",
         shape("ply", "<string name='filename' value='" + folder.write("a.ply", kPly) + "'/>"), 1,
         Vec3(0.f), 2},
        {"gltf",
         shape("gltf", "<string name='filename' value='" + folder.write("a.gltf", kGltf) + "'/>"),
         1, Vec3(0.f), 2},
    };
  }();
  return all;
}

}  // namespace kinome::test
