// Tests the contents of PLY and OBJ files, and the errors of damaged files.

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <map>
#include <memory>

#include "allocation_watch.h"
#include "kinome/log.h"
#include "support/shape_helpers.h"

namespace kinome::test::mesh_files_test {
namespace {

/// Appends values in either byte order.
class Bytes {
 public:
  explicit Bytes(bool swap) : swap_(swap) {}
  template <class T>
  Bytes& add(T value) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (swap_) std::reverse(bytes, bytes + sizeof(T));
    text_.append(bytes, sizeof(T));
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  bool swap_;
  std::string text_;
};

class MeshFiles : public testing::Test {
 protected:
  std::shared_ptr<Shape> load(const std::string& name, const std::string& contents,
                              const std::string& attributes = "") {
    const std::string file = folder_.write(name, contents);
    return make<Shape>("<shape type='" + name.substr(name.rfind('.') + 1) +
                       "'><string name='filename' value='" + file + "'/>" + attributes +
                       "</shape>");
  }
  std::string error(const std::string& name, const std::string& contents) {
    return error_of([&] { load(name, contents); });
  }
  void expect_error(const std::string& name, const std::string& contents, const std::string& place,
                    const std::string& message) {
    reset_largest_allocation();
    const std::string text = error(name, contents);
    const std::string prefix = folder_.path(name) + place + ":";
    EXPECT_EQ(text.substr(0, prefix.size()), prefix) << text << "\nof:\n"
                                                     << contents.substr(0, 500);
    EXPECT_NE(text.find(message), std::string::npos) << text << "\nof:\n"
                                                     << contents.substr(0, 500);
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_LT(largest_allocation(), size_t{4} << 20) << text;
  }
  TemporaryFolder folder_;
};

/// Returns a square of two triangles at z = 2 with normals and uv. The file also has an unknown
/// property and unknown elements, as list and as scalar.
std::string binary_ply(bool swap) {
  std::string header = "ply\nformat binary_";
  header += (std::endian::native == std::endian::little) != swap ? "little" : "big";
  header +=
      "_endian 1.0\ncomment made by a test\nobj_info x y z\nelement camera 2\n"
      "property list ushort double lens\nproperty char mode\nelement vertex 4\n"
      "property double x\nproperty float y\nproperty uchar quality\nproperty short z\n"
      "property float nx\nproperty float ny\nproperty float nz\nproperty list uchar int extra\n"
      "property float s\nproperty float t\nelement face 1\nproperty ushort material\n"
      "property list uint ushort vertex_index\nelement edge 1\nproperty int a\nend_header\n";
  Bytes body(swap);
  for (int i = 0; i < 2; ++i) {
    body.add<uint16_t>(2).add(1.5).add(2.5).add<int8_t>(-7);
  }
  for (int i = 0; i < 4; ++i) {
    const float x = i == 1 || i == 2 ? 1.f : -1.f;
    const float y = i >= 2 ? 1.f : -1.f;
    body.add<double>(x).add(y).add<uint8_t>(200).add<int16_t>(2);
    body.add(0.f).add(0.f).add(-3.f);
    body.add<uint8_t>(1).add<int32_t>(99);
    body.add((x + 1) / 2).add((y + 1) / 4);
  }
  body.add<uint16_t>(5).add<uint32_t>(4);
  for (const uint16_t i : {0, 1, 2, 3}) body.add(i);
  body.add<int32_t>(1);
  return header + body.text();
}

TEST_F(MeshFiles, BinaryPlyOfBothByteOrders) {
  for (const bool swap : {false, true}) {
    const auto shape = load("square.ply", binary_ply(swap));
    const TriangleMesh& mesh = *shape->mesh();
    ASSERT_EQ(mesh.positions.size(), 4u);
    EXPECT_EQ(mesh.positions[2], Vec3(1, 1, 2));
    EXPECT_EQ(mesh.normals, std::vector<Vec3>(4, Vec3(0, 0, -1)));
    EXPECT_EQ(mesh.uvs[2], Vec2(1, 0.5f));
    ASSERT_EQ(mesh.triangles.size(), 2u);
    EXPECT_EQ(mesh.triangles[0], glm::uvec3(0, 1, 2));
    EXPECT_EQ(mesh.triangles[1], glm::uvec3(0, 2, 3));
    EXPECT_FLOAT_EQ(shape->area(), 4);
  }
}

TEST_F(MeshFiles, AsciiPlyWithBlankLinesAndCarriageReturns) {
  const auto shape = load("pentagon.ply",
                          "ply\r\nformat ascii 1.0\r\nelement vertex 5\r\nproperty float32 x\r\n"
                          "property float64 y\r\nproperty int8 z\r\nelement face 1\r\n"
                          "property list uint8 int32 vertex_indices\r\nend_header\r\n"
                          "0 0 0\r\n2 0 0\r\n\r\n3 +2e0 0\r\n1 3.5 0\r\n-1 2 0\r\n5 0 1 2 3 4\r\n");
  ASSERT_EQ(shape->mesh()->triangles.size(), 3u);
  EXPECT_EQ(shape->mesh()->triangles[2], glm::uvec3(0, 3, 4));
  EXPECT_FLOAT_EQ(shape->area(), 9);  // by the shoelace formula
  EXPECT_EQ(shape->mesh()->normals[0], Vec3(0, 0, 1));
  EXPECT_TRUE(shape->mesh()->uvs.empty());
}

/// Texture coordinates by each supported name. Mitsuba 3.9.1 reads the same values.
TEST_F(MeshFiles, PlyTextureCoordinatesByAllTheirNames) {
  const auto u_of = [&](const std::vector<std::string>& names) {
    std::string header =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\n";
    std::string values;
    for (size_t i = 0; i < names.size(); ++i) {
      header += "property float " + names[i] + "\n";
      values += " 0." + std::to_string(i + 1);
    }
    const auto shape =
        load("uv.ply", header +
                           "element face 1\nproperty list uchar int "
                           "vertex_indices\nend_header\n0 0 0" +
                           values + "\n1 0 0" + values + "\n0 1 0" + values + "\n3 0 1 2\n");
    return shape->sample_surface(Vec2(0.5f)).uv;
  };
  const auto expect_uv = [](const Vec2& uv, float u, float v) {
    EXPECT_NEAR(uv.x, u, 1e-6f);
    EXPECT_NEAR(uv.y, v, 1e-6f);
  };
  expect_uv(u_of({"u", "v"}), 0.1f, 0.2f);
  expect_uv(u_of({"s", "t"}), 0.1f, 0.2f);
  expect_uv(u_of({"texture_u", "texture_v"}), 0.1f, 0.2f);
  expect_uv(u_of({"s", "t", "texture_u", "texture_v"}), 0.3f, 0.4f);
  expect_uv(u_of({"texture_u", "texture_v", "s", "t", "u", "v"}), 0.5f, 0.6f);
}

/// Unused contents of a file are reported once with -v, and not at all without.
TEST_F(MeshFiles, WhatIsNotUsedIsToldOnce) {
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty float nx\nproperty float s\n"
      "property float t\nelement face 1\nproperty list uchar int vertex_indices\n"
      "property int material\nelement edge 0\nproperty int a\nend_header\n"
      "0 0 0 9 1 0 0\n1 0 0 9 1 0 0\n0 1 0 9 1 0 0\n3 0 1 2 7\n";
  const std::string obj =
      "mtllib a.mtl\nv 0 0 0 .5 .5 .5\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nusemtl a\nf 1//1 2//1 3//1\n"
      "usemtl b\nf 1 2 3\n";
  const auto log_of = [&](const std::string& name, const std::string& contents) {
    testing::internal::CaptureStderr();
    load(name, contents);
    load(name, contents);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(log_of("quiet.ply", ply), "");
  set_log_level(LogLevel::kInfo);
  EXPECT_EQ(log_of("a.ply", ply),
            "kinome: " + folder_.path("a.ply") +
                ": not used: vertex 'red', vertex 'nx', face 'material', element 'edge'\n");
  EXPECT_EQ(log_of("a.obj", obj), "kinome: " + folder_.path("a.obj") +
                                      ": not used: mtllib, vertex colours or weights, usemtl\n");
  EXPECT_EQ(log_of("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "");
  set_log_level(LogLevel::kWarn);
}

TEST_F(MeshFiles, ObjWithRelativeIndicesPolygonsAndSharedVertices) {
  const auto shape = load("house.obj",
                          "# a square with a roof\nmtllib x.mtl\no house\nv 0 0 0\nv 1 0 0 1.0\n"
                          "v 1 1 0 .5 .5 .5\nv 0 1 0\nvt .25\nvt .5 .75 0\nvn 0 0 2\nusemtl a\n"
                          "s off\nf 1/1/1 2/2/1 -2/1/-1 -1/2/-1\nv .5 2 0\n"
                          "f -2/1/1 \\\n  -3/1/1 5/1/1\n");
  const TriangleMesh& mesh = *shape->mesh();
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.positions.size(), 6u);  // a vertex is shared if all three indices are equal
  EXPECT_EQ(mesh.triangles[2].y, mesh.triangles[0].z);
  EXPECT_NE(mesh.triangles[2].x, mesh.triangles[1].z);  // same position, different uv
  EXPECT_EQ(mesh.positions[mesh.triangles[2].z], Vec3(0.5f, 2, 0));
  EXPECT_EQ(mesh.uvs[0], Vec2(0.25f, 1));     // 1 - 0
  EXPECT_EQ(mesh.uvs[1], Vec2(0.5f, 0.25f));  // 1 - 0.75
  EXPECT_EQ(mesh.normals[0], Vec3(0, 0, 1));
  EXPECT_FLOAT_EQ(shape->area(), 1.5f);
}

/// Comparing each corner at the centre with all previous ones would take minutes at this size.
TEST_F(MeshFiles, ObjFanWithManyVerticesAtOnePosition) {
  constexpr uint32_t kFaces = 200000, kRim = 8;
  std::string text = "v 0 0 0\n";
  for (uint32_t i = 0; i < kRim; ++i) {
    const double angle = 2 * M_PI * i / kRim;
    text += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
  }
  for (uint32_t i = 0; i < kFaces; ++i) text += "vt " + std::to_string(i) + " 1\n";
  // The second copy of the faces must not add vertices.
  for (uint32_t i = 0; i < 2 * kFaces; ++i) {
    text += "f 1/" + std::to_string(i % kFaces + 1) + " " + std::to_string(i % kRim + 2) + "/1 " +
            std::to_string((i + 1) % kRim + 2) + "/1\n";
  }
  const auto shape = load("fan.obj", text);
  const TriangleMesh& mesh = *shape->mesh();
  ASSERT_EQ(mesh.triangles.size(), 2 * kFaces);
  ASSERT_EQ(mesh.positions.size(), kFaces + kRim);
  for (uint32_t i = 0; i < kFaces; ++i) {
    const glm::uvec3& triangle = mesh.triangles[i];
    ASSERT_EQ(mesh.positions[triangle.x], Vec3(0.f)) << i;
    ASSERT_EQ(mesh.uvs[triangle.x], Vec2(static_cast<float>(i), 0)) << i;
    ASSERT_EQ(mesh.uvs[triangle.y], Vec2(0.f)) << i;
    ASSERT_EQ(mesh.triangles[i + kFaces], triangle) << i;
    // Vertices are in file order: the first faces contain those of the rim.
    if (i >= kRim) {
      ASSERT_EQ(triangle.x, i + kRim) << i;
    }
  }
}

/// Mitsuba keeps the given normals, and reads missing ones from uninitialised memory.
TEST_F(MeshFiles, ObjCornersWithoutNormalsGetThoseOfTheirFaces) {
  const auto shape = load("bent.obj",
                          "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvn 1 0 0\n"
                          "f 1//1 2//1 3//1\nf 2 4 3\n");
  const TriangleMesh& mesh = *shape->mesh();
  ASSERT_EQ(mesh.positions.size(), 6u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(mesh.normals[mesh.triangles[0][k]], Vec3(1, 0, 0));
    EXPECT_EQ(mesh.normals[mesh.triangles[1][k]], Vec3(0, 0, 1));
  }
}

TEST_F(MeshFiles, DegenerateTrianglesAreHarmless) {
  const auto shape = load("thin.obj",
                          "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nvt 0 0\nf 1/1 2/1 3/1\nf 1 1 2\n"
                          "f 1 2 4\n");
  EXPECT_FLOAT_EQ(shape->area(), 0.5f);
  Ray ray;
  ray.tmax = 1;
  for (uint32_t i = 0; i < 3; ++i) {
    Hit hit;
    hit.primitive = i;
    hit.u = 0.25f;
    hit.v = 0.5f;
    const SurfaceInteraction si = shape->interaction(ray, hit);
    EXPECT_NEAR(glm::length(si.n), 1, 1e-6f);
    EXPECT_NEAR(glm::length(si.frame.s), 1, 1e-6f);
    EXPECT_NEAR(glm::length(si.frame.n), 1, 1e-6f);
    EXPECT_TRUE(is_finite(si.dp_du) && is_finite(si.dp_dv) && is_finite(si.wi));
  }
}

/// The cross products of edges of 1e-22 have squares below the smallest float.
TEST_F(MeshFiles, TinyTrianglesKeepTheirNormals) {
  const auto shape =
      load("tiny.obj", "\xEF\xBB\xBFv 0 0 0\nv 1e-22 0 0\nv 0 1e-22 1e-22\nf 1 2 3\n");
  Hit hit;
  hit.primitive = 0;
  const SurfaceInteraction si = shape->interaction(Ray(), hit);
  EXPECT_LT(glm::length(si.n - Vec3(0, -std::sqrt(0.5f), std::sqrt(0.5f))), 1e-6f);
  EXPECT_LT(glm::length(si.frame.n - si.n), 1e-6f);
}

/// A folded sheet: the normals of the faces cancel along the fold.
TEST_F(MeshFiles, OppositeFacesLeaveNoVertexWithoutNormal) {
  const auto shape = load("fold.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n");
  for (const Vec3& n : shape->mesh()->normals) EXPECT_NEAR(glm::length(n), 1, 1e-6f);
}

const std::string kVertexHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\n";
const std::string kFaceHeader =
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string kPoints = "0 0 0\n1 0 0\n0 1 0\n";

TEST_F(MeshFiles, BrokenPlyHeaders) {
  expect_error("a.ply", "", ":1", "not a PLY file");
  expect_error("a.ply", "PNG\x89 garbage", ":1", "not a PLY file");
  expect_error("a.ply", std::string(100000, 'x'), ":1", "not a PLY file");
  expect_error("a.ply", "ply\nformat ascii 1.0\n", ":3", "no 'end_header'");
  expect_error("a.ply", "ply\nend_header\n", ":2", "no 'format'");
  expect_error("a.ply", "ply\nformat utf8 1.0\n", ":2", "unknown format 'utf8'");
  expect_error("a.ply", "ply\nformat ascii 2.0\n", ":2", "version");
  expect_error("a.ply", "ply\nformat ascii 1.0\nproperty float x\n", ":3", "before any element");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement vertex\n", ":3", "element NAME COUNT");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement vertex -3\n", ":3", "element NAME COUNT");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n", ":3",
               "element NAME COUNT");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement v 1\nproperty quad x\n", ":4",
               "unknown type 'quad'");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement v 1\nelement v 1\n", ":4", "two elements");
  expect_error("a.ply", "ply\nformat ascii 1.0\nflavour sweet\n", ":3", "unknown keyword");
}

TEST_F(MeshFiles, BrokenAsciiPly) {
  expect_error("a.ply", "ply\nformat ascii 1.0\n" + kFaceHeader + "3 0 1 2\n", ":6", "no vertices");
  expect_error("a.ply", kVertexHeader + kFaceHeader + kPoints, ":13", "but only 0 bytes");
  expect_error("a.ply", kVertexHeader + kFaceHeader + kPoints + "3 0 1\n", ":14", "ends too early");
  expect_error("a.ply", kVertexHeader + kFaceHeader + kPoints + "3 0 1 3\n", ":13",
               "refers to vertex 3, expected 0 to 2");
  expect_error("a.ply", kVertexHeader + kFaceHeader + kPoints + "3 0 1 -1\n", ":13",
               "refers to vertex -1");
  expect_error("a.ply", kVertexHeader + kFaceHeader + kPoints + "3 0 1 4e18\n", ":13",
               "refers to vertex");
  expect_error("a.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nelement face 1\nproperty list float int vertex_indices\n"
               "end_header\n" +
                   kPoints + "2.5 0 1 2\n",
               ":13", "length of 2.5");
  expect_error("a.ply", kVertexHeader + kFaceHeader + kPoints + "4000000000 0 1 2\n", ":13",
               "longer than the rest");
  expect_error("a.ply", kVertexHeader + kFaceHeader + kPoints + "-3 0 1 2\n", ":13",
               "length of -3");
  expect_error("a.ply", kVertexHeader + kFaceHeader + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", ":11",
               "not finite");
  expect_error("a.ply", kVertexHeader + kFaceHeader + "0 0 0\n1 inf 0\n0 1 0\n3 0 1 2\n", ":11",
               "not finite");
  expect_error("a.ply", kVertexHeader + kFaceHeader + "0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n", ":11",
               "got 'zero'");
  expect_error("a.ply", kVertexHeader + kFaceHeader + "0 0 0 5\n1 0 0\n0 1 0\n3 0 1 2\n", ":10",
               "unexpected '5'");
  expect_error("a.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n" + kFaceHeader +
                   "0\n1\n2\n3 0 1 2\n",
               ":8", "lack x, y or z");
}

TEST_F(MeshFiles, BrokenBinaryPly) {
  const std::string whole = binary_ply(false);
  const size_t body = whole.find("end_header\n") + 11;
  for (size_t size = body; size < whole.size() - 4; ++size) {  // the last 4 bytes are an edge
    const std::string text = error(std::to_string(size) + "cut.ply", whole.substr(0, size));
    EXPECT_TRUE(text.starts_with(folder_.path(std::to_string(size) + "cut.ply") + ": "))
        << size << ": " << text;
    EXPECT_NE(text.find("byte"), std::string::npos) << size << ": " << text;
  }
  std::string nan = whole;
  const float not_a_number = NAN;
  std::memcpy(&nan[body + 2 * 19 + 8], &not_a_number, 4);  // y of the first vertex
  expect_error("nan.ply", nan, "", "vertex 0 has a position that is not finite");
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
      "property float x\nproperty float y\nproperty float z\n";
  expect_error("huge.ply", header + kFaceHeader + "0123456789", "", "promises 4000000000");
  expect_error("empty.ply",
               "ply\nformat binary_little_endian 1.0\nelement nothing 18446744073709551615\n"
               "element vertex 18446744073709551615\nproperty float x\nproperty float y\n"
               "property float z\n" +
                   kFaceHeader,
               "", "promises 18446744073709551615");
}

TEST_F(MeshFiles, BrokenObj) {
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  expect_error("a.obj", "", ":1", "no vertices");
  expect_error("a.obj", points + "f 1 2 4\n", ":4", "vertex 4, but there are only 3");
  expect_error("a.obj", points + "f 1 2 0\n", ":4", "out of range");
  expect_error("a.obj", points + "f 1 2 -4\n", ":4", "out of range in '-4'");
  expect_error("a.obj", points + "f 1 2 99999999999999999999\n", ":4", "out of range");
  expect_error("a.obj", points + "f 1/1 2/1 3/1\n", ":4", "texture coordinate 1");
  expect_error("a.obj", points + "f 1//2 2//2 3//2\n", ":4", "normal 2");
  expect_error("a.obj", points + "f 1 2 x\n", ":4", "got 'x'");
  expect_error("a.obj", points + "f 1/1/1/1 2 3\n", ":4", "expected v/vt/vn");
  expect_error("a.obj", points + "f / 2 3\n", ":4", "got '/'");
  expect_error("a.obj", "v 0 0\nf 1 1 1\n", ":1", "the line ends");
  expect_error("a.obj", "v 0 0 nan\n", ":1", "not finite");
  expect_error("a.obj", "v 0 0 1e999\n", ":1", "out of range");
  expect_error("a.obj", "v 0 0 one\n", ":1", "got 'one'");
  expect_error("a.obj", "ply\nformat ascii 1.0\n", ":1", "unknown keyword 'ply'");
  expect_error("a.obj",
               std::string("\x7f"
                           "ELF\0\0\0",
                           7),
               ":1", "unknown keyword");
}

TEST_F(MeshFiles, FoldersAndMissingFiles) {
  EXPECT_NE(error_of([&] {
              make<Shape>("<shape type='ply'><string name='filename' value='" + folder_.folder() +
                          "'/></shape>");
            }),
            "");
  EXPECT_NE(error_of([&] {
              make<Shape>("<shape type='obj'><string name='filename' value='" +
                          folder_.path("none.obj") + "'/></shape>");
            }).find("none.obj"),
            std::string::npos);
}

/// Changes or truncates files at random. Each must load as a mesh or throw an Error.
TEST_F(MeshFiles, SurvivesRandomDamage) {
  const std::map<std::string, std::string> files = {
      {"a.ply", binary_ply(false)},
      {"b.ply", kVertexHeader + kFaceHeader + kPoints + "3 0 1 2\n"},
      {"c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/1/1 -1/1/1\n"}};
  Random random(21);
  set_log_level(LogLevel::kQuiet);
  reset_largest_allocation();
  for (const auto& [name, contents] : files) {
    for (int i = 0; i < 800; ++i) {
      std::string damaged = contents;
      const int changes = 1 + static_cast<int>(3 * random.unit());
      for (int k = 0; k < changes; ++k) {
        const auto place = static_cast<size_t>(random.unit() * static_cast<float>(damaged.size()));
        damaged[place] = static_cast<char>(256 * random.unit() - 128);
      }
      if (random.unit() < 0.2f) {
        damaged.resize(static_cast<size_t>(random.unit() * static_cast<float>(damaged.size())));
      }
      // Uses a new name each time, because file systems flush overwritten files.
      error(std::to_string(i) + name, damaged);
    }
  }
  EXPECT_LT(largest_allocation(), size_t{4} << 20);
  set_log_level(LogLevel::kWarn);
}

}  // namespace
}  // namespace kinome::test::mesh_files_test
