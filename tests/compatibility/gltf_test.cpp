/// glTF files whose meshes depend on extensions, skins, morph targets and missing normals. Such
/// data are read, refused or reported, but never lost silently.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>

#include "kinome/error.h"
#include "kinome/shape.h"
#include "support/render.h"

namespace kinome::test::gltf_test {
namespace {

/// Builds a file: arrays become accessors in the order in which they are added. The first contains
/// the positions of a right triangle with legs of length 1.
class GltfFile {
 public:
  GltfFile() { add<float>("VEC3", 5126, {0, 0, 0, 1, 0, 0, 0, 1, 0}); }

  /// Returns the index of the accessor.
  template <class T>
  int add(const std::string& type, int component_type, const std::vector<T>& values,
          bool normalized = false) {
    const size_t width = type == "VEC2"   ? 2
                         : type == "VEC3" ? 3
                         : type == "VEC4" ? 4
                         : type == "MAT4" ? 16
                                          : 1;
    buffer_.resize((buffer_.size() + 3) / 4 * 4, '\0');
    const std::string comma = accessor_count_ > 0 ? "," : "";
    views_ += comma + R"({"buffer":0,"byteOffset":)" + std::to_string(buffer_.size()) +
              R"(,"byteLength":)" + std::to_string(values.size() * sizeof(T)) + "}";
    accessors_ += comma + R"({"bufferView":)" + std::to_string(accessor_count_) +
                  R"(,"componentType":)" + std::to_string(component_type) +
                  (normalized ? R"(,"normalized":true)" : "") + R"(,"count":)" +
                  std::to_string(values.size() / width) + R"(,"type":")" + type + "\"}";
    buffer_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    return accessor_count_++;
  }

  std::string primitives = R"({"attributes":{"POSITION":0}})";
  std::string nodes = R"({"mesh":0})";
  std::string more;  ///< members of the file or, after "meshes", of its only mesh
  std::string of_mesh;

  /// Returns the .gltf file whose buffer is the file `buffer_name`.
  std::string json(const std::string& buffer_name) const {
    return R"({"asset":{"version":"2.0"},)" + more + R"("buffers":[{"byteLength":)" +
           std::to_string(buffer_.size()) + R"(,"uri":")" + buffer_name + R"("}],"bufferViews":[)" +
           views_ + R"(],"accessors":[)" + accessors_ + R"(],"meshes":[{)" + of_mesh +
           R"("primitives":[)" + primitives + R"(]}],"nodes":[)" + nodes +
           R"(],"scenes":[{"nodes":[0]}],"scene":0})";
  }
  const std::string& buffer() const { return buffer_; }

 private:
  std::string buffer_, views_, accessors_;
  int accessor_count_ = 0;
};

class GltfMeshes : public testing::Test {
 protected:
  std::shared_ptr<Shape> load(const GltfFile& file, const std::string& more = "") {
    folder_.write("a.bin", file.buffer());
    testing::internal::CaptureStderr();
    std::shared_ptr<Shape> shape;
    error_.clear();
    try {
      shape = make<Shape>("<shape type='gltf'><string name='filename' value='" +
                          folder_.write("a.gltf", file.json("a.bin")) + "'/>" + more + "</shape>");
    } catch (const Error& error) {
      error_ = error.what();
    }
    warnings_ = testing::internal::GetCapturedStderr();
    return shape;
  }
  void expect_positions(const GltfFile& file, const std::vector<Vec3>& expected) {
    const auto shape = load(file);
    ASSERT_TRUE(shape) << error_;
    const TriangleMesh& mesh = *shape->mesh();
    ASSERT_EQ(mesh.positions.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) {
      EXPECT_LT(glm::length(mesh.positions[i] - expected[i]), 1e-5f) << i;
    }
    EXPECT_EQ(warnings_, "");
  }
  TemporaryFolder folder_;
  std::string error_, warnings_;
};

std::string instancing(int translation, int rotation, int scale) {
  return R"("extensions":{"EXT_mesh_gpu_instancing":{"attributes":{"TRANSLATION":)" +
         std::to_string(translation) + R"(,"ROTATION":)" + std::to_string(rotation) +
         R"(,"SCALE":)" + std::to_string(scale) + "}}}";
}

/// Rotations as floats, and as bytes and shorts, in which 1/sqrt(2) makes the length slightly
/// different from 1.
TEST_F(GltfMeshes, InstancesAreCopiesOfTheirNodesMesh) {
  for (const int type : {5126, 5122, 5120}) {
    GltfFile file;
    const int translation = file.add<float>("VEC3", 5126, {10, 0, 0, 0, 20, 0});
    int rotation = 0;
    if (type == 5126) {
      const float half = std::sqrt(0.5f);
      rotation = file.add<float>("VEC4", type, {0, 0, 0, 1, 0, 0, half, half});
    } else if (type == 5122) {
      rotation = file.add<int16_t>("VEC4", type, {0, 0, 0, 32767, 0, 0, 23170, 23170}, true);
    } else {
      rotation = file.add<int8_t>("VEC4", type, {0, 0, 0, 127, 0, 0, 90, 90}, true);
    }
    const int scale = file.add<float>("VEC3", 5126, {1, 1, 1, 2, 3, 1});
    file.nodes =
        R"({"mesh":0,"translation":[0,0,5],)" + instancing(translation, rotation, scale) + "}";
    file.more = R"("extensionsUsed":["EXT_mesh_gpu_instancing"],)"
                R"("extensionsRequired":["EXT_mesh_gpu_instancing"],)";
    expect_positions(file,
                     {{10, 0, 5}, {11, 0, 5}, {10, 1, 5}, {0, 20, 5}, {0, 22, 5}, {-3, 20, 5}});
  }
  GltfFile broken;
  for (const char* text : {"{}", R"({"attributes":7})", R"({"attributes":{"SCALE":"a"}})",
                           R"({"attributes":{"SCALE":99}})"}) {
    broken.nodes = std::string(R"({"mesh":0,"extensions":{"KHR_node_visibility":{"visible":2},)") +
                   R"("EXT_mesh_gpu_instancing":)" + text + "}}";
    EXPECT_FALSE(load(broken)) << text;
    EXPECT_NE(error_.find("node 0"), std::string::npos) << error_;
  }
  GltfFile file;
  const int two = file.add<float>("VEC3", 5126, {10, 0, 0, 0, 20, 0});
  file.nodes =
      R"({"mesh":0,)" + instancing(two, file.add<float>("VEC4", 5126, {0, 0, 0, 1}), two) + "}";
  EXPECT_FALSE(load(file));
  EXPECT_NE(error_.find("node 0 has instances' attributes of different lengths"), std::string::npos)
      << error_;
}

TEST_F(GltfMeshes, RequiredExtensionsThatAreUnknownAreRefused) {
  const auto load_with = [&](const std::string& extension) {
    GltfFile file;
    file.more = R"("extensionsRequired":[")" + extension + "\"],";
    return load(file);
  };
  for (const char* extension : {"KHR_mesh_quantization", "KHR_texture_transform",
                                "KHR_materials_unlit", "KHR_lights_punctual", "EXT_texture_webp"}) {
    EXPECT_TRUE(load_with(extension)) << error_;
  }
  for (const char* extension :
       {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "ACME_deformation"}) {
    EXPECT_FALSE(load_with(extension));
    EXPECT_NE(error_.find("a.gltf: the file requires the extension '" + std::string(extension)),
              std::string::npos)
        << error_;
  }
}

/// A buffer that only a decompressor can fill has no bytes of its own.
TEST_F(GltfMeshes, CompressedBuffersAreNamedAsSuch) {
  GltfFile file;
  std::string text = file.json("a.bin");
  const std::string uri = R"("uri":"a.bin")";
  text.replace(text.find(uri), uri.size(),
               R"("extensions":{"EXT_meshopt_compression":{"fallback":true}})");
  try {
    make<Shape>("<shape type='gltf'><string name='filename' value='" +
                folder_.write("b.gltf", text) + "'/></shape>");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("compressed meshes are unsupported"),
              std::string::npos)
        << error.what();
  }
}

/// Integers that aren't normalised are used as coordinates directly.
TEST_F(GltfMeshes, QuantisedPositions) {
  GltfFile file;
  const int positions = file.add<int16_t>("VEC3", 5122, {-100, 0, 0, 300, 0, 0, 0, 200, 50});
  file.primitives = R"({"attributes":{"POSITION":)" + std::to_string(positions) + "}}";
  file.nodes = R"({"mesh":0,"scale":[0.01,0.01,0.01]})";
  file.more = R"("extensionsRequired":["KHR_mesh_quantization"],)";
  expect_positions(file, {{-1, 0, 0}, {3, 0, 0}, {0, 2, 0.5f}});
}

TEST_F(GltfMeshes, MorphTargetsByTheWeightsOfTheMeshOrOfTheNode) {
  GltfFile file;
  const int a = file.add<float>("VEC3", 5126, {0, 0, 4, 0, 0, 0, 0, 0, 0});
  const int b = file.add<float>("VEC3", 5126, {0, 0, 0, 8, 0, 0, 0, 0, 0});
  file.primitives = R"({"attributes":{"POSITION":0},"targets":[{"POSITION":)" + std::to_string(a) +
                    R"(},{"POSITION":)" + std::to_string(b) + "}]}";
  expect_positions(file, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  file.of_mesh = R"("weights":[0.5,0.25],)";
  expect_positions(file, {{0, 0, 2}, {3, 0, 0}, {0, 1, 0}});
  file.nodes = R"({"mesh":0,"weights":[0,1]})";
  expect_positions(file, {{0, 0, 0}, {9, 0, 0}, {0, 1, 0}});
}

/// The transform of a skinned mesh's node has no effect. Those of its joints have, in the file's
/// pose.
TEST_F(GltfMeshes, SkinsInThePoseOfTheNodes) {
  GltfFile file;
  const int joints = file.add<uint8_t>("VEC4", 5121, {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0});
  const int weights = file.add<float>("VEC4", 5126, {.5f, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const int inverse =
      file.add<float>("MAT4", 5126, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                                     1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1});
  file.primitives = R"({"attributes":{"POSITION":0,"JOINTS_0":)" + std::to_string(joints) +
                    R"(,"WEIGHTS_0":)" + std::to_string(weights) + "}}";
  // Joint 1 is at (1, 0, 0) of joint 0 in the bind pose, and at (1, 0, 7) in the file's pose.
  file.nodes = R"({"children":[1,2]},{"mesh":0,"skin":0,"translation":[50,50,50]},)"
               R"({"translation":[0,0,3],"children":[3]},{"translation":[1,0,7]})";
  file.more =
      R"("skins":[{"joints":[2,3],"inverseBindMatrices":)" + std::to_string(inverse) + "}],";
  expect_positions(file, {{0, 0, 6.5f}, {1, 0, 10}, {0, 1, 3}});
  file.primitives.replace(file.primitives.find("\"JOINTS_0\""), 8, "\"OTHER_0");
  expect_positions(file, {{50, 50, 50}, {51, 50, 50}, {50, 51, 50}});
}

/// A roof of two triangles with shared vertices, beside a primitive with normals.
TEST_F(GltfMeshes, PrimitivesWithoutNormalsAreFlat) {
  GltfFile file;
  const int roof = file.add<float>("VEC3", 5126, {0, 0, 0, 0, 1, 0, 1, 0, 1, -1, 0, 1});
  const int corners = file.add<uint16_t>("SCALAR", 5123, {0, 2, 1, 0, 1, 3});
  const int normals = file.add<float>("VEC3", 5126, {0, 0, -1, 0, 0, -1, 0, 0, -1});
  const std::string flat = R"({"attributes":{"POSITION":)" + std::to_string(roof) +
                           R"(},"indices":)" + std::to_string(corners) + "}";
  file.primitives = flat;
  auto shape = load(file);
  EXPECT_TRUE(shape->mesh()->normals.empty());
  EXPECT_EQ(shape->mesh()->positions.size(), 4u);

  file.primitives += R"(,{"attributes":{"POSITION":0,"NORMAL":)" + std::to_string(normals) + "}}";
  shape = load(file);
  const TriangleMesh& mesh = *shape->mesh();
  ASSERT_EQ(mesh.triangles.size(), 3u);
  const float half = std::sqrt(0.5f);
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT(glm::length(mesh.normals[mesh.triangles[0][k]] - Vec3(-half, 0, half)), 1e-6f);
    EXPECT_LT(glm::length(mesh.normals[mesh.triangles[1][k]] - Vec3(half, 0, half)), 1e-6f);
    EXPECT_EQ(mesh.normals[mesh.triangles[2][k]], Vec3(0, 0, -1));
  }
}

TEST_F(GltfMeshes, HiddenNodesAreReported) {
  GltfFile file;
  file.nodes =
      R"({"mesh":0,"children":[1]},)"
      R"({"mesh":0,"extensions":{"KHR_node_visibility":{"visible":false}},"children":[2]},{"mesh":0})";
  expect_positions(file, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  file.primitives += R"(,{"attributes":{"POSITION":0},"mode":1,"material":0})";
  load(file);
  EXPECT_NE(warnings_.find("primitives of points or lines are skipped (1 of them)"),
            std::string::npos)
      << warnings_;
  file = {};
  file.primitives = R"({"attributes":{"POSITION":0},"material":0})";
  file.more = R"("materials":[{}],)";
  load(file);
  EXPECT_NE(warnings_.find("its materials are ignored: give the shape a bsdf"), std::string::npos)
      << warnings_;
  load(file, "<bsdf type='diffuse'/>");
  EXPECT_EQ(warnings_, "");
}

}  // namespace
}  // namespace kinome::test::gltf_test
