/// Meshes as exporters write them: OBJ and PLY files that Mitsuba 3.9.1 reads, and some that it
/// refuses although they are unambiguous. Expected values are Mitsuba's unless a test states
/// otherwise.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "kinome/error.h"
#include "kinome/log.h"
#include "kinome/shape.h"
#include "support/render.h"

namespace kinome::test::mesh_files_test {
namespace {

constexpr const char* kObjPoints = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
constexpr const char* kObjUvs = "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n";
const std::string kPlyVertices =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\n";
const std::string kPlyFace = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kPlyPoints = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n";

class MeshFiles : public testing::Test {
 protected:
  std::string shape_xml(const std::string& name, const std::string& contents,
                        const std::string& more = "") {
    return "<shape type='" + name.substr(name.rfind('.') + 1) +
           "'><string name='filename' value='" + folder_.write(name, contents) + "'/>" + more +
           "</shape>";
  }
  std::shared_ptr<Shape> load(const std::string& name, const std::string& contents) {
    testing::internal::CaptureStderr();
    std::shared_ptr<Shape> shape;
    try {
      shape = make<Shape>(shape_xml(name, contents));
    } catch (const Error& error) {
      ADD_FAILURE() << error.what() << "\nof:\n" << contents;
    }
    warnings_ = testing::internal::GetCapturedStderr();
    return shape ? shape : make<Shape>("<shape type='rectangle'/>");
  }
  /// Expects triangles with these vertex positions.
  void expect_triangles(const std::string& name, const std::string& contents,
                        const std::vector<std::vector<Vec3>>& expected) {
    const auto shape = load(name, contents);
    const TriangleMesh& mesh = *shape->mesh();
    ASSERT_EQ(mesh.triangles.size(), expected.size()) << contents;
    for (size_t i = 0; i < expected.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(mesh.positions[mesh.triangles[i][k]], expected[i][static_cast<size_t>(k)])
            << contents;
      }
    }
  }
  void expect_first_triangle(const std::string& name, const std::string& contents) {
    expect_triangles(name, contents, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  }
  TemporaryFolder folder_;
  std::string warnings_;
};

TEST_F(MeshFiles, ObjFacesInTheWaysOfExporters) {
  const std::string points = kObjPoints, uvs = kObjUvs, normals = "vn 0 0 1\n";
  const std::string statements[] = {points + uvs + "f 1/ 2/ 3/\n",
                                    points + uvs + normals + "f 1/1/ 2/2/ 3/3/\n",
                                    points + "f 1// 2// 3//\n",
                                    points + "f 1 2 3 # remark\n",
                                    points + "f 1 2 3 #remark\n",
                                    points + "f 1 2 3#remark\n",
                                    points + "f 1 2 3",
                                    points + "f 1 2 \\\n 3\n",
                                    points + "f 1 2\\\n 3\n",
                                    points + "f +1 +2 +3\n",
                                    points + "f -4 -3 -2\n",
                                    points + "f\t1\t2\t3\t\n",
                                    "f 1 2 3\n" + points,
                                    "v 0 0 0 # first\nv 1 0 0 1 1 1\nv 0 1 0 1\nf 1 2 3\n",
                                    "v 0 0 1e-400\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"};
  for (const std::string& text : statements) {
    expect_first_triangle("a.obj", text);
    EXPECT_EQ(warnings_, "") << text;
  }
  for (const char* end : {"\r\n", "\r"}) {
    std::string text = points + uvs + "# remark\nf 1/1 2/2 3/3\n";
    for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += strlen(end)) {
      text.replace(at, 1, end);
    }
    expect_first_triangle("a.obj", text);
  }
}

TEST_F(MeshFiles, ObjStatementsThatAreSkippedAreReported) {
  const std::string points = kObjPoints;
  const auto warns = [&](const std::string& statements, const std::string& message) {
    expect_first_triangle("a.obj", points + statements + "f 1 2 3\n");
    EXPECT_EQ(warnings_, "kinome: warning: " + folder_.path("a.obj") + ":5:1: " + message + "\n");
  };
  warns("f 1 2\nf 3\nf\n", "faces of fewer than three vertices are skipped (3 of them)");
  warns("p 1 2 3\n", "points are skipped (1 of them)");
  warns("l 1 2 3\nl 1/1 2/1\n", "lines are skipped (2 of them)");
  warns("newmtl a\n", "unknown statements 'newmtl' are skipped (1 of them)");
  warns("curv2 1 2\n", "free-form curves are skipped (1 of them)");
  expect_first_triangle("a.obj", points + "f 1 2 3 abc\n");
  EXPECT_NE(warnings_.find("words after the corners of a face"), std::string::npos) << warnings_;
}

/// Normals that are zero, missing or not finite are replaced by those of the faces; Mitsuba refuses
/// them or makes them NaN. Texture coordinates that aren't finite become 0.
TEST_F(MeshFiles, NormalsAndTextureCoordinatesThatAreNoNumbers) {
  const std::string points = kObjPoints;
  for (const char* normal : {"0 0 0", "nan nan nan", "-nan(ind) 0 0", "1.#QNAN -1.#IND00 0"}) {
    const auto shape = load(
        "a.obj", points + "vn 0 0 -3\nvn " + normal + "\nf 1//1 2//1 3//1\nf 2//2 4//2 3//2\n");
    const TriangleMesh& mesh = *shape->mesh();
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(mesh.normals[mesh.triangles[0][k]], Vec3(0, 0, -1)) << normal;
      EXPECT_EQ(mesh.normals[mesh.triangles[1][k]], Vec3(0, 0, 1)) << normal;
    }
  }
  const auto shape = load("a.obj", points + "vt nan 1\nvt 0.5 0.25\nf 1/1 2/2 3/2\n");
  EXPECT_NE(warnings_.find("texture coordinates that are not finite"), std::string::npos);
  EXPECT_EQ(shape->mesh()->uvs[0], Vec2(0.f));
  EXPECT_EQ(shape->mesh()->uvs[1], Vec2(0.5f, 0.75f));
}

TEST_F(MeshFiles, PlyItemsOverSeveralLinesAndSeveralOnOne) {
  for (const char* body :
       {"0 0\n0\n1 0 0\n0\n1\n0 1 1 0\n3\n0 1\n2\n", "0 0 0 1 0 0 0 1 0 1 1 0 3 0 1 2",
        "\n0 0 0\r\n1 0 0\n\n0 1 0\n1 1 0\n3 0 1 2\n"}) {
    expect_first_triangle("a.ply", kPlyVertices + kPlyFace + body);
    EXPECT_EQ(warnings_, "");
  }
}

TEST_F(MeshFiles, PlyListsOfAllTypes) {
  for (const char* count : {"char", "uchar", "short", "ushort", "int", "uint8", "int64", "float"}) {
    for (const char* index :
         {"char", "uint16", "int", "uint", "int32", "uint64", "half", "double"}) {
      expect_first_triangle("a.ply", kPlyVertices + "element face 1\nproperty list " + count + " " +
                                         index + " vertex_index\nend_header\n" + kPlyPoints +
                                         "3 0 1 2\n");
    }
  }
}

TEST_F(MeshFiles, PlyHalfPrecisionInBinary) {
  const auto halves = [](std::initializer_list<int> bits) {
    std::string bytes;
    for (const int b : bits) bytes += {static_cast<char>(b & 255), static_cast<char>(b >> 8)};
    return bytes;
  };
  const auto shape = load("a.ply",
                          "ply\nformat binary_little_endian 1.0\nelement vertex 3\n"
                          "property half x\nproperty float16 y\nproperty half z\n"
                          "element face 1\nproperty list uchar uchar vertex_indices\nend_header\n" +
                              halves({0x3c00, 0xc100, 0x0001, 0x7bff, 0, 0x8000, 0, 0x3555, 0}) +
                              std::string("\3\0\1\2", 4));
  const TriangleMesh& mesh = *shape->mesh();
  EXPECT_EQ(mesh.positions[0], Vec3(1, -2.5f, 0x1p-24f));
  EXPECT_EQ(mesh.positions[1], Vec3(65504, 0, 0));
  EXPECT_NEAR(mesh.positions[2].y, 1 / 3.f, 1e-4f);
}

TEST_F(MeshFiles, PlyFacesOfFewerThanThreeVerticesAreSkipped) {
  std::string header = kPlyVertices + kPlyFace;
  header.replace(header.find("face 1"), 6, "face 4");
  expect_first_triangle("a.ply", header + kPlyPoints + "2 0 1\n0\n3 0 1 2\n1 3\n");
  EXPECT_EQ(warnings_, "kinome: warning: " + folder_.path("a.ply") +
                           ": faces of fewer than three vertices are skipped (3 of them)\n");
}

/// Hair often ends with a radius of 0.
TEST_F(MeshFiles, CurvesWithPointedTips) {
  for (const char* type : {"linearcurve", "bsplinecurve"}) {
    const auto scene = scene_from(
        std::string("<integrator type='path'/><emitter type='constant'/>"
                    "<sensor type='orthographic'><transform name='to_world'>"
                    "<translate z='-5'/></transform><film type='hdrfilm'><rfilter type='box'/>"
                    "<integer name='width' value='16'/><integer name='height' value='16'/>"
                    "</film></sensor><shape type='") +
        type + "'><string name='filename' value='" +
        folder_.write("hair.txt", "-1 0 0 0\n-.5 0 0 .2\n.5 .1 0 .2\n1 0 0 0\n") + "'/></shape>");
    double sum = 0;
    for (const float value : render_scene(*scene).data) {
      EXPECT_TRUE(std::isfinite(value));
      sum += value;
    }
    EXPECT_GT(sum, 0);
  }
  EXPECT_THROW(make<Shape>("<shape type='linearcurve'><string name='filename' value='" +
                           folder_.write("none.txt", "0 0 0 0\n1 0 0 0\n") + "'/></shape>"),
               Error);
}

/// MeshLab writes textured meshes like this; Mitsuba refuses them.
TEST_F(MeshFiles, PlyTextureCoordinatesOfCorners) {
  const std::string header =
      kPlyVertices +
      "property float nx\nproperty float ny\nproperty float nz\nelement face 3\n"
      "property list uchar int vertex_indices\nproperty list uchar float texcoord\n"
      "property int texnumber\nend_header\n";
  const auto shape = load("a.ply", header +
                                       "0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n1 1 0 0 0 2\n"
                                       "4 0 1 3 2 8 .1 .2 .3 .4 .5 .6 .7 .8 0\n"
                                       "2 0 1 4 9 9 9 9 0\n"
                                       "3 3 1 0 6 .9 .6 .3 .4 nan 0 0\n");
  const TriangleMesh& mesh = *shape->mesh();
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.positions.size(), 6u);  // two corners differ from earlier ones
  const std::vector<std::vector<Vec2>> expected = {{{.1f, .2f}, {.3f, .4f}, {.5f, .6f}},
                                                   {{.1f, .2f}, {.5f, .6f}, {.7f, .8f}},
                                                   {{.9f, .6f}, {.3f, .4f}, {0, 0}}};
  for (size_t i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t vertex = mesh.triangles[i][k];
      EXPECT_EQ(mesh.uvs[vertex], expected[i][static_cast<size_t>(k)]) << i << ", " << k;
      EXPECT_EQ(mesh.normals[vertex], Vec3(0, 0, 1));
    }
  }
  EXPECT_EQ(mesh.positions[mesh.triangles[2].x], Vec3(1, 1, 0));
}

/// Files of the Stanford repository and of VTK have strips; Mitsuba refuses them.
TEST_F(MeshFiles, PlyTriangleStrips) {
  expect_triangles("a.ply",
                   kPlyVertices +
                       "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" +
                       kPlyPoints + "8 0 1 2 3 -1 1 3 2\n",
                   {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                    {{0, 1, 0}, {1, 0, 0}, {1, 1, 0}},
                    {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}});
}

/// Point clouds, and files whose faces are all skipped, are invisible anywhere in a scene.
TEST_F(MeshFiles, MeshesWithoutFacesAreInvisible) {
  const std::string points = kObjPoints;
  const std::string empty_ply = shape_xml("a.ply", kPlyVertices + "end_header\n" + kPlyPoints);
  std::string no_face = kPlyFace;
  no_face.replace(no_face.find("face 1"), 6, "face 0");
  testing::internal::CaptureStderr();
  const auto scene = scene_from(
      "<integrator type='path'/><emitter type='constant'/>"
      "<sensor type='perspective'><transform name='to_world'><translate z='-5'/></transform>"
      "<film type='hdrfilm'><rfilter type='box'/><integer name='width' value='4'/>"
      "<integer name='height' value='4'/></film></sensor>" +
      empty_ply + shape_xml("b.ply", kPlyVertices + no_face + kPlyPoints) +
      shape_xml("c.obj", points + "l 1 2\n",
                "<emitter type='area'><rgb name='radiance' value='9'/></emitter>") +
      shape_xml("d.gltf", R"({"asset":{"version":"2.0"}})") + "<shape type='merge'>" + empty_ply +
      empty_ply + "</shape><shape type='shapegroup' id='empty'>" + empty_ply +
      "</shape><shape type='shapegroup' id='half'>" + empty_ply +
      "<shape type='rectangle'><bsdf type='diffuse'/></shape></shape>"
      "<shape type='instance'><ref id='empty'/></shape>"
      "<shape type='instance'><ref id='half'/><transform name='to_world'>"
      "<translate x='30'/></transform></shape>");
  const Image image = render_scene(*scene);
  const std::string messages = testing::internal::GetCapturedStderr();
  EXPECT_NE(messages.find("c.obj: the file has no faces: the shape is invisible"),
            std::string::npos)
      << messages;
  EXPECT_EQ(scene->shapes().size(), 1u);
  for (const float value : image.data) EXPECT_EQ(value, 1.f);
}

/// Mitsuba ignores a merge's material and everything that is empty.
TEST_F(MeshFiles, MergesAndGroupsWithUnusualContents) {
  const auto shapes_of = [](const std::string& xml) {
    testing::internal::CaptureStderr();
    const size_t count = scene_from(xml)->shapes().size();
    const std::string messages = testing::internal::GetCapturedStderr();
    EXPECT_NE(messages.find("warning"), std::string::npos) << xml;
    return count;
  };
  EXPECT_EQ(shapes_of("<shape type='merge'/>"), 0u);
  EXPECT_EQ(shapes_of("<shape type='merge'><shape type='shapegroup' id='g'>"
                      "<shape type='sphere'/></shape></shape>"),
            0u);
  EXPECT_EQ(shapes_of("<shape type='shapegroup' id='g'/><shape type='instance'><ref id='g'/>"
                      "</shape>"),
            0u);
  EXPECT_EQ(shapes_of("<shape type='merge'><bsdf type='diffuse'/><shape type='cube'/></shape>"),
            1u);
}

TEST_F(MeshFiles, AGroupOfMergesHasAllTheirShapes) {
  const auto scene = scene_from(
      "<shape type='shapegroup' id='g'><shape type='merge'><shape type='rectangle'/>"
      "<shape type='merge'><shape type='sphere'/><shape type='cube'/></shape></shape></shape>"
      "<shape type='instance'><ref id='g'/></shape>");
  EXPECT_EQ(scene->shapes().size(), 3u);
}

}  // namespace
}  // namespace kinome::test::mesh_files_test
