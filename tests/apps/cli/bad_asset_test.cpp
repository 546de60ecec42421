// Tests the program with meshes and images that are missing, damaged or absurd: one line names the
// file and the position in the scene that refers to it.

#include <sys/resource.h>

#include <array>
#include <cstring>
#include <fstream>
#include <iterator>

#include "cli.h"
#include "kinome/image_files.h"
#include "kinome/image.h"

namespace kinome::test::bad_asset_test {
namespace {

const char* const kPly = R"(ply
format ascii 1.0
element vertex 3
property float x
property float y
property float z
element face 1
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
)";

/// A glTF of one triangle; its buffer contains three positions and three 16-bit indices, in base64.
std::string gltf(const std::string& count, const std::string& last_index_base64 = "AAABAAIA") {
  // 36 bytes of positions are 48 characters: (0,0,0) (1,0,0) (0,1,0).
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [{"mesh": 0}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
  "accessors": [
    {"bufferView": 0, "componentType": 5126, "count": )" +
         count +
         R"(, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
    {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
  "bufferViews": [
    {"buffer": 0, "byteOffset": 0, "byteLength": 36},
    {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
  "buffers": [{"byteLength": 42, "uri": "data:application/octet-stream;base64,)"
         "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" +
         last_index_base64 + "\"}]}";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no '" + from + "'");
  return text.replace(at, from.size(), to);
}

struct BadMesh {
  const char* name;
  const char* file;
  std::string contents;
  std::vector<std::string> parts;
};

void PrintTo(const BadMesh& mesh, std::ostream* out) {
  *out << mesh.name;
}

/// Returns the end of an error about a file that the scene names by `text`.
std::string referenced_by(const std::string& scene, const std::string& text) {
  std::ifstream stream(scene);
  const std::string xml{std::istreambuf_iterator<char>(stream), {}};
  const size_t at = xml.find(text);
  if (at == std::string::npos) throw std::logic_error("no '" + text + "'");
  const auto line = 1 + std::count(xml.begin(), xml.begin() + static_cast<long>(at), '\n');
  const size_t column = at - xml.rfind('\n', at);
  return " (referenced by " + scene + ":" + std::to_string(line) + ":" + std::to_string(column) +
         ")\n";
}

class BadMeshTest : public Cli, public ::testing::WithParamInterface<BadMesh> {};

TEST_P(BadMeshTest, IsOneErrorThatNamesTheFile) {
  const BadMesh& mesh = GetParam();
  const std::string extension = std::filesystem::path(mesh.file).extension().string().substr(1);
  const std::string scene =
      folder_.write("scene.xml", replaced(small_scene(), "</scene>",
                                          "  <shape type=\"" + extension +
                                              "\"><string name=\"filename\" value=\"" + mesh.file +
                                              "\"/></shape>\n</scene>"));
  const std::string path = folder_.write(mesh.file, mesh.contents);
  // Absurd counts must be rejected: the address space suffices for the program, but not for
  // gigabytes.
#ifdef KINOME_HAS_SANITIZER
  const std::string limit = "exec \"$@\"";  // sanitizers reserve terabytes of it
#else
  const std::string limit = "ulimit -v 1500000; exec \"$@\"";
#endif
  const ProcessResult result =
      run_process({"sh", "-c", limit, "sh", KINOME_TEST_PROGRAM, scene, "-t", "1"});
  EXPECT_EQ(result.status, 1) << result.err;
  EXPECT_EQ(lines(result.err), 1u) << result.err;
  EXPECT_EQ(result.err.rfind("kinome: " + path + ":", 0), 0u) << result.err;
  EXPECT_TRUE(result.err.ends_with(
      referenced_by(scene, "<string name=\"filename\" value=\"" + std::string(mesh.file))))
      << result.err;
  for (const std::string& part : mesh.parts) {
    EXPECT_NE(result.err.find(part), std::string::npos) << part << " in " << result.err;
  }
  EXPECT_EQ(other_files({scene, path}), std::vector<std::string>{});
}

const BadMesh kMeshes[] = {
    {"ply_that_is_none", "a.ply", "solid cube\n", {":1", "PLY"}},
    {"ply_empty_file", "a.ply", "", {"PLY"}},
    {"ply_cut_short", "a.ply", replaced(kPly, "0 1 0\n3 0 1 2\n", ""), {"ends too early"}},
    {"ply_index_out_of_range", "a.ply", replaced(kPly, "3 0 1 2", "3 0 1 3"), {"vertex 3"}},
    {"ply_negative_index", "a.ply", replaced(kPly, "3 0 1 2", "3 0 1 -1"), {"-1"}},
    {"ply_absurd_vertices",
     "a.ply",
     replaced(kPly, "vertex 3", "vertex 4000000000"),
     {"4000000000"}},
    {"ply_absurd_faces", "a.ply", replaced(kPly, "face 1", "face 999999999999"), {"999999999999"}},
    {"ply_negative_count", "a.ply", replaced(kPly, "vertex 3", "vertex -3"), {":3", "-3"}},
    {"ply_number_that_is_none", "a.ply", replaced(kPly, "1 0 0", "1 zero 0"), {":11", "'zero'"}},
    {"ply_infinite_vertex", "a.ply", replaced(kPly, "1 0 0", "1 inf 0"), {"finite"}},
    {"obj_that_is_none", "a.obj", "hello\n", {":1", "'hello'"}},
    {"obj_index_out_of_range", "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", {":4", "4", "3"}},
    {"obj_index_zero", "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", {":4"}},
    {"obj_no_vertices", "a.obj", "# nothing\n", {"no vertices"}},
    {"obj_number_that_is_none", "a.obj", "v 0 0 0\nv 1 x 0\nv 0 1 0\nf 1 2 3\n", {":2", "'x'"}},
    {"gltf_that_is_none", "a.gltf", "hello", {"glTF"}},
    {"gltf_index_out_of_range", "a.gltf", gltf("3", "AAABAAMA"), {"vertex 3"}},
    {"gltf_absurd_count", "a.gltf", gltf("4000000000"), {"4000000000"}},
    {"gltf_of_an_unknown_extension",
     "a.gltf",
     replaced(gltf("3"), "\"scene\": 0", "\"scene\": 0, \"extensionsRequired\": [\"ACME_mesh\"]"),
     {"requires the extension 'ACME_mesh'"}},
    {"gltf_of_another_version", "a.gltf", R"({"asset": {"version": "1.0"}})", {"'1.0'", "2.0"}},
    {"gltf_stride_below_its_element",
     "a.gltf",
     replaced(gltf("3"), "\"byteLength\": 36}", "\"byteLength\": 36, \"byteStride\": 4}"),
     {"stride of 4"}},
    {"glb_cut_short", "a.glb", std::string("glTF\2\0\0\0\377\377\0\0", 12), {"glTF"}},
};

INSTANTIATE_TEST_SUITE_P(All, BadMeshTest, ::testing::ValuesIn(kMeshes),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST_F(Cli, GltfOfTheseTestsIsSoundOtherwise) {
  folder_.write("a.gltf", gltf("3"));
  folder_.write("a.ply", kPly);
  const std::string scene = folder_.write(
      "scene.xml",
      replaced(small_scene(), "</scene>",
               "<shape type=\"gltf\"><string name=\"filename\" value=\"a.gltf\"/></shape>"
               "<shape type=\"ply\"><string name=\"filename\" value=\"a.ply\"/></shape></scene>"));
  const ProcessResult result = kinome({"-q", scene});
  EXPECT_EQ(result.status, 0) << result.err;
}

class BadImage : public Cli {
 protected:
  /// The small scene under an environment map, which is in line 18.
  std::string scene_with_envmap(const std::string& file) {
    return folder_.write(
        "scene.xml", replaced(small_scene(), "<emitter type=\"constant\"/>",
                              "<emitter type=\"envmap\"><string name=\"filename\" value=\"" + file +
                                  "\"/></emitter>"));
  }
  std::string scene_with_bitmap(const std::string& file) {
    return folder_.write(
        "scene.xml",
        replaced(small_scene(), "</scene>",
                 "<shape type=\"cube\"><bsdf type=\"diffuse\"><texture name=\"reflectance\" "
                 "type=\"bitmap\"><string name=\"filename\" value=\"" +
                     file + "\"/></texture></bsdf></shape></scene>"));
  }
  /// An 8x4 map that is grey except for one texel.
  std::string write_map(const std::string& name, float texel) {
    Image map;
    map.width = 8;
    map.height = 4;
    map.channels = {"R", "G", "B"};
    map.data.assign(8 * 4 * 3, .5f);
    map.at(5, 2, 1) = texel;
    const std::string path = folder_.path(name);
    if (name.find(".pfm") != std::string::npos) {
      write_pfm(path, map);
    } else {
      write_exr(path, map, ExrSampleType::kFloat, {});
    }
    return path;
  }
  /// `own`: the scene and, if there is one, the image, whose name the error then begins with.
  void expect_error(const std::string& scene, const std::vector<std::string>& own,
                    const std::vector<std::string>& parts) {
    const ProcessResult result = kinome({scene});
    EXPECT_EQ(result.status, 1) << result.err;
    EXPECT_EQ(lines(result.err), 1u) << result.err;
    EXPECT_EQ(result.err.rfind("kinome: " + own.back() + ":", 0), 0u) << result.err;
    if (own.size() > 1) {
      EXPECT_TRUE(result.err.ends_with(referenced_by(scene, "<string name=\"filename\"")))
          << result.err;
    }
    for (const std::string& part : parts) {
      EXPECT_NE(result.err.find(part), std::string::npos) << part << " in " << result.err;
    }
    EXPECT_EQ(other_files(own), std::vector<std::string>{});
  }
};

TEST_F(BadImage, Missing) {
  for (const std::string& scene : {scene_with_envmap("nothing.exr")}) {
    expect_error(scene, {scene}, {"nothing.exr"});
  }
  const std::string scene = scene_with_bitmap("nothing.png");
  expect_error(scene, {scene}, {"nothing.png"});
}

TEST_F(BadImage, NoImageAtAll) {
  for (const char* name : {"map.exr", "map.pfm", "map.hdr", "map.png"}) {
    const std::string path = folder_.write(name, "This is text, whatever it is called.");
    const std::string scene = scene_with_envmap(name);
    expect_error(scene, {scene, path}, {name});
    std::filesystem::remove(path);
  }
  for (const char* name : {"map.exr", "map.png", "map.jpg"}) {
    const std::string path = folder_.write(name, "This is text, whatever it is called.");
    const std::string scene = scene_with_bitmap(name);
    expect_error(scene, {scene, path}, {name});
    std::filesystem::remove(path);
  }
}

TEST_F(BadImage, Truncated) {
  for (const char* name : {"map.exr", "map.pfm"}) {
    const std::string path = write_map(name, .5f);
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - 40);
    for (const std::string& scene : {scene_with_envmap(name)}) {
      expect_error(scene, {scene, path}, {name});
    }
    std::filesystem::remove(path);
  }
  Image picture;
  picture.width = picture.height = 64;
  picture.channels = {"R", "G", "B"};
  for (int i = 0; i < 64 * 64 * 3; ++i) picture.data.push_back(static_cast<float>(i % 251) / 251);
  const std::string path = folder_.path("map.png");
  write_png(path, picture, 0);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 2);
  std::string scene = scene_with_bitmap("map.png");
  expect_error(scene, {scene, path}, {"map.png"});
  scene = scene_with_envmap("map.png");
  expect_error(scene, {scene, path}, {"map.png"});
}

TEST_F(BadImage, NonFiniteTexelIsReplacedWithAWarning) {
  const std::pair<float, std::string> values[] = {
      {std::numeric_limits<float>::quiet_NaN(), ": 1 texel with NaN, which becomes 0"},
      {std::numeric_limits<float>::infinity(), ": 1 texel with infinity, which becomes 65504"}};
  for (const auto& [value, warning] : values) {
    const std::string path = write_map("map.exr", value);
    for (const std::string& scene : {scene_with_envmap("map.exr"), scene_with_bitmap("map.exr")}) {
      const ProcessResult result = kinome({scene});
      EXPECT_EQ(result.status, 0) << result.err;
      EXPECT_NE(result.err.find(path + warning), std::string::npos) << result.err;
    }
  }
}

TEST_F(BadImage, NegativeTexelIsKeptWithOneWarning) {
  write_map("map.exr", -.25f);
  const std::string scene = scene_with_envmap("map.exr");
  const ProcessResult result = kinome({scene});
  EXPECT_EQ(result.status, 0) << result.err;
  const size_t warning = result.err.find("warning");
  ASSERT_NE(warning, std::string::npos) << result.err;
  EXPECT_NE(result.err.find("negative"), std::string::npos) << result.err;
  EXPECT_EQ(result.err.find("warning", warning + 1), std::string::npos) << result.err;
}

}  // namespace
}  // namespace kinome::test::bad_asset_test
