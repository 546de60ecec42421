// Tests the contents of PLY and OBJ files, and the errors of damaged files.

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <map>
#include <memory>

#include "allocation_watch.h"
#include "kinome/log.h"
#include "plugins/shapes/mesh_files.h"
#include "support/shape_helpers.h"

namespace kinome::test::mesh_files_test {
namespace {

using namespace mesh_files;

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
TEST_F(MeshFiles, UnusedDataAreReportedOnce) {
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
TEST_F(MeshFiles, ObjCornersWithoutNormalsGetFaceNormals) {
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

}  // namespace
}  // namespace kinome::test::mesh_files_test
