#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <map>
#include <memory>

#include "allocation_watch.h"
#include "kinome/log.h"
#include "plugins/shapes/mesh_files.h"
#include "support/shape_helpers.h"

/// Tests damaged mesh files.
namespace kinome::test::broken_meshes_test {
namespace {

using namespace mesh_files;

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
}  // namespace kinome::test::broken_meshes_test
