// Tests the contents of glTF files in all supported encodings, and the errors of damaged files.

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <memory>

#include "allocation_watch.h"
#include "kinome/log.h"
#include "support/shape_helpers.h"

namespace kinome::test::gltf_test {
namespace {

std::string base64(const std::string& bytes) {
  const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    const size_t count = std::min<size_t>(3, bytes.size() - i);
    for (size_t k = 0; k < 3; ++k) {
      group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0);
    }
    for (size_t k = 0; k < 4; ++k) {
      text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

template <class T>
std::string bytes_of(std::initializer_list<T> values) {
  std::string bytes;
  for (const T& value : values) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes.append(raw, sizeof(T));
  }
  return bytes;
}

/// Parts of a file. By default, it is a right triangle with legs of length 1.
struct GltfParts {
  std::string buffer = bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
  std::string uri;  ///< replaces the embedded buffer
  std::string views = R"({"buffer":0,"byteOffset":0,"byteLength":36})";
  std::string accessors =
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]})";
  std::string primitives = R"({"attributes":{"POSITION":0}})";
  std::string nodes = R"({"mesh":0})";
  std::string scene_nodes = "0";
  std::string extra;

  std::string json(bool embed = true) const {
    std::string text = R"({"asset":{"version":"2.0"},)" + extra + R"("buffers":[{"byteLength":)" +
                       std::to_string(buffer.size());
    if (!uri.empty()) {
      text += R"(,"uri":")" + uri + '"';
    } else if (embed) {
      text += R"(,"uri":"data:application/octet-stream;base64,)" + base64(buffer) + '"';
    }
    text += R"(}],"bufferViews":[)" + views + R"(],"accessors":[)" + accessors + "],";
    text += R"("meshes":[{"primitives":[)" + primitives + R"(]}],"nodes":[)" + nodes + "],";
    return text + R"("scenes":[{"nodes":[)" + scene_nodes + R"(]}],"scene":0})";
  }

  std::string binary() const {
    std::string text = json(false);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string data = buffer;
    data.resize((data.size() + 3) / 4 * 4, '\0');
    const auto size = [](size_t n) { return bytes_of<uint32_t>({static_cast<uint32_t>(n)}); };
    return "glTF" + size(2) + size(28 + text.size() + data.size()) + size(text.size()) + "JSON" +
           text + size(data.size()) + std::string("BIN\0", 4) + data;
  }
};

class Gltf : public testing::Test {
 protected:
  std::shared_ptr<Shape> load(const std::string& name, const std::string& contents,
                              const std::string& attributes = "") {
    const std::string type = name.substr(name.rfind('.') + 1);
    const std::string file = folder_.write(name, contents);
    return make<Shape>("<shape type='" + type + "'><string name='filename' value='" + file + "'/>" +
                       attributes + "</shape>");
  }
  std::shared_ptr<Shape> load(const GltfParts& parts) {
    return load(std::to_string(++count_) + ".gltf", parts.json());
  }
  void expect_error(const std::string& contents, const std::string& message) {
    const std::string name = std::to_string(++count_) + ".gltf";
    reset_largest_allocation();
    const std::string text = error_of([&] { load(name, contents); });
    EXPECT_TRUE(text.starts_with(folder_.path(name) + ": ")) << text << "\nof " << contents;
    EXPECT_NE(text.find(message), std::string::npos) << text << "\nof " << contents;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_LT(largest_allocation(), size_t{4} << 20) << text;
  }
  void expect_error(const GltfParts& parts, const std::string& message) {
    expect_error(parts.json(), message);
  }
  TemporaryFolder folder_;
  int count_ = 0;
};

TEST_F(Gltf, TextAndBinary) {
  for (const auto& shape :
       {load("a.gltf", GltfParts().json()), load("a.glb", GltfParts().binary())}) {
    EXPECT_EQ(shape->mesh()->triangles, std::vector<glm::uvec3>{glm::uvec3(0, 1, 2)});
    EXPECT_EQ(shape->mesh()->positions[1], Vec3(1, 0, 0));
    EXPECT_TRUE(shape->mesh()->normals.empty());  // flat, as glTF 2.0, 3.7.2.1, demands
    EXPECT_TRUE(shape->mesh()->uvs.empty());
    EXPECT_FLOAT_EQ(shape->area(), 0.5f);
  }
}

TEST_F(Gltf, UnusedDataAreReportedOnce) {
  GltfParts parts;
  parts.primitives.insert(parts.primitives.find("\"POSITION\""), "\"COLOR_0\":0,\"TEXCOORD_1\":0,");
  testing::internal::CaptureStderr();
  set_log_level(LogLevel::kInfo);
  const std::string contents = parts.json();
  load("a.gltf", contents);
  load("a.gltf", contents);
  load("b.gltf", GltfParts().json());
  set_log_level(LogLevel::kWarn);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "kinome: " + folder_.path("a.gltf") +
                ": not used: attribute COLOR_0, attribute TEXCOORD_1\n");
}

TEST_F(Gltf, BufferBesideTheFile) {
  GltfParts parts;
  folder_.write("triangle data.bin", parts.buffer);
  parts.uri = "triangle%20data.bin";
  EXPECT_FLOAT_EQ(load(parts)->area(), 0.5f);
}

/// Vertices of 20 bytes: position as normalised 16-bit, padding, normal as normalised 8-bit, uv as
/// normalised 16-bit. Then indices of the given type.
TEST_F(Gltf, StridedQuantisedAttributesAndIndicesOfEachType) {
  std::string vertices;
  for (const int i : {0, 1, 2, 3}) {
    const int16_t x = i == 1 || i == 2 ? 32767 : -32767;
    const int16_t y = i >= 2 ? 32767 : -32768;
    vertices += bytes_of<int16_t>({x, y, 0, 0});
    vertices += bytes_of<int8_t>({0, 0, 127, 0});
    vertices += bytes_of<uint16_t>({static_cast<uint16_t>(i == 1 || i == 2 ? 65535 : 0), 13107});
    vertices += "pad!";
  }
  const std::map<int, std::string> indices = {{5121, bytes_of<uint8_t>({0, 1, 2, 2, 3, 0})},
                                              {5123, bytes_of<uint16_t>({0, 1, 2, 2, 3, 0})},
                                              {5125, bytes_of<uint32_t>({0, 1, 2, 2, 3, 0})}};
  for (const auto& [type, bytes] : indices) {
    GltfParts parts;
    parts.buffer = vertices + bytes;
    parts.views = R"({"buffer":0,"byteOffset":0,"byteLength":80,"byteStride":20},)"
                  R"({"buffer":0,"byteOffset":80,"byteLength":)" +
                  std::to_string(bytes.size()) + "}";
    parts.accessors =
        R"({"bufferView":0,"componentType":5122,"normalized":true,"count":4,"type":"VEC3"},)"
        R"({"bufferView":0,"byteOffset":8,"componentType":5120,"normalized":true,"count":4,)"
        R"("type":"VEC3"},)"
        R"({"bufferView":0,"byteOffset":12,"componentType":5123,"normalized":true,"count":4,)"
        R"("type":"VEC2"},)"
        R"({"bufferView":1,"componentType":)" +
        std::to_string(type) + R"(,"count":6,"type":"SCALAR"})";
    parts.primitives =
        R"({"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"indices":3,"mode":4})";
    const auto shape = load(parts);
    const TriangleMesh& mesh = *shape->mesh();
    EXPECT_EQ(mesh.positions[0], Vec3(-1, -1, 0));  // -32768 is clamped
    EXPECT_EQ(mesh.positions[2], Vec3(1, 1, 0));
    EXPECT_EQ(mesh.normals[3], Vec3(0, 0, 1));
    EXPECT_EQ(mesh.uvs[1], Vec2(1, 0.2f));
    EXPECT_EQ(mesh.triangles[1], glm::uvec3(2, 3, 0));
    EXPECT_FLOAT_EQ(shape->area(), 4);
  }
}

TEST_F(Gltf, SparseAccessors) {
  GltfParts parts;
  parts.buffer += bytes_of<uint16_t>({2, 0}) + bytes_of<float>({0, 3, 0});
  parts.views +=
      R"(,{"buffer":0,"byteOffset":36,"byteLength":2},{"buffer":0,"byteOffset":40,"byteLength":12})";
  parts.accessors =
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,)"
      R"("indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":2}}})";
  EXPECT_FLOAT_EQ(load(parts)->area(), 1.5f);
  // An accessor without data starts from zeros.
  parts.accessors =
      R"({"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,)"
      R"("indices":{"bufferView":1,"componentType":5123},"values":{"bufferView":2}}})";
  EXPECT_EQ(load(parts)->mesh()->positions[2], Vec3(0, 3, 0));
  EXPECT_EQ(load(parts)->mesh()->positions[1], Vec3(0));
}

TEST_F(Gltf, NodesTransformTheirMeshes) {
  GltfParts parts;
  // A child rotated by 90 degrees around z and doubled, in a translated parent; and a mirrored
  // instance, whose outside stays outside.
  parts.nodes = R"({"translation":[5,0,0],"children":[1]},)"
                R"({"mesh":0,"rotation":[0,0,0.70710678118,0.70710678118],"scale":[2,2,2]},)"
                R"({"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,9,1]})";
  parts.scene_nodes = "0,2";
  const auto shape = load(parts);
  const TriangleMesh& mesh = *shape->mesh();
  ASSERT_EQ(mesh.positions.size(), 6u);
  const std::vector<Vec3> expected = {{5, 0, 0}, {5, 2, 0},  {3, 0, 0},
                                      {0, 0, 9}, {-1, 0, 9}, {0, 1, 9}};
  for (size_t i = 0; i < 6; ++i) EXPECT_LT(glm::length(mesh.positions[i] - expected[i]), 1e-6f);
  EXPECT_FLOAT_EQ(shape->area(), 2.5f);
  for (const Vec3& n : mesh.normals) EXPECT_LT(glm::length(n - Vec3(0, 0, 1)), 1e-6f);
}

TEST_F(Gltf, StoredNormalsGoByTheInverseTranspose) {
  GltfParts parts;
  parts.buffer += bytes_of<float>({1, 1, 0, 1, 1, 0, 1, 1, 0});
  parts.views += R"(,{"buffer":0,"byteOffset":36,"byteLength":36})";
  parts.accessors += R"(,{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"})";
  parts.primitives = R"({"attributes":{"POSITION":0,"NORMAL":1}})";
  parts.nodes = R"({"mesh":0,"scale":[2,1,1]})";
  EXPECT_LT(glm::length(load(parts)->mesh()->normals[0] - glm::normalize(Vec3(0.5f, 1, 0))), 1e-6f);
}

TEST_F(Gltf, StripsFansAndDegeneratePrimitives) {
  GltfParts parts;
  parts.buffer = bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
  parts.views = R"({"buffer":0,"byteLength":60})";
  parts.accessors = R"({"bufferView":0,"componentType":5126,"count":5,"type":"VEC3"})";
  parts.primitives =
      R"({"attributes":{"POSITION":0},"mode":5},{"attributes":{"POSITION":0},"mode":1},)"
      R"({"attributes":{"POSITION":0},"mode":6})";
  const auto shape = load(parts);
  const TriangleMesh& mesh = *shape->mesh();
  const std::vector<glm::uvec3> expected = {{0, 1, 2}, {1, 3, 2}, {2, 3, 4},
                                            {5, 6, 7}, {5, 7, 8}, {5, 8, 9}};
  EXPECT_EQ(mesh.triangles, expected);
}

TEST_F(Gltf, BrokenFiles) {
  expect_error("", "too short");
  expect_error("{", "too short");
  expect_error("{\"asset\": ", "parse error");
  expect_error("glTF\2", "short");
  expect_error("{}", "too short");
  const std::string deep(20000, '[');
  expect_error(R"({"asset":{"version":"2.0"},"extras":)" + deep, "nested too deeply");
  expect_error(std::string("glTF\2\0\0\0\0\0\0\0\xff\xff\0\0JSON", 20) + deep, "nested too deeply");
  expect_error("v 0 0 0\n", "parse error");
  expect_error(R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[3]}]})", "node 3");
  GltfParts parts;
  parts.nodes = R"({"mesh":7})";
  expect_error(parts, "mesh 7, but there are 1");
  parts = {};
  parts.nodes = R"({"mesh":0,"children":[0]})";
  expect_error(parts, "two parents");
  parts = {};
  parts.nodes = R"({"mesh":0,"children":[9]})";
  expect_error(parts, "node 9");
  parts = {};
  parts.nodes = R"({"mesh":0,"scale":[1,2]})";
  expect_error(parts, "scale");
  parts = {};
  parts.primitives = R"({"attributes":{"POSITION":4}})";
  expect_error(parts, "accessor 4");
  parts.primitives = R"({"attributes":{"NORMAL":0}})";
  expect_error(parts, "no positions");
  parts.primitives = R"({"attributes":{"POSITION":0},"indices":5})";
  expect_error(parts, "out of bounds");
  parts.primitives =
      R"({"attributes":{"POSITION":0},"extensions":{"KHR_draco_mesh_compression":{}}})";
  parts.accessors = R"({"componentType":5126,"count":3,"type":"VEC3"})";
  expect_error(parts, "compressed");
  parts = {};
  parts.extra = R"("extensionsRequired":["EXT_meshopt_compression"],)";
  expect_error(parts, "compressed");
  parts = {};
  parts.uri = "missing.bin";
  expect_error(parts, "missing.bin");
}

TEST_F(Gltf, AccessorsThatReachBeyondTheirData) {
  const auto accessor = [](const std::string& text) {
    GltfParts parts;
    parts.accessors = text;
    return parts;
  };
  expect_error(accessor(R"({"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"})"),
               "beyond its data");
  expect_error(accessor(R"({"bufferView":0,"byteOffset":4,"componentType":5126,"count":3,)"
                        R"("type":"VEC3"})"),
               "beyond its data");
  expect_error(
      accessor(R"({"bufferView":0,"componentType":5126,"count":4000000000,"type":"VEC3"})"),
      "claims 4000000000");
  expect_error(accessor(R"({"componentType":5126,"count":4000000000,"type":"VEC3","sparse":{)"
                        R"("count":1,"indices":{"bufferView":0,"componentType":5123},)"
                        R"("values":{"bufferView":0}}})"),
               "claims 4000000000");
  expect_error(accessor(R"({"bufferView":3,"componentType":5126,"count":3,"type":"VEC3"})"),
               "buffer view 3");
  expect_error(accessor(R"({"componentType":5126,"count":3,"type":"VEC3"})"), "without data");
  expect_error(accessor(R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"})"),
               "wrong type");
  expect_error(accessor(R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{)"
                        R"("count":1,"indices":{"bufferView":0,"byteOffset":12,)"
                        R"("componentType":5125},"values":{"bufferView":0}}})"),
               "sparse index out of range");
  GltfParts parts;
  parts.views = R"({"buffer":0,"byteOffset":8,"byteLength":36})";
  expect_error(parts, "beyond its data");
  parts.views = R"({"buffer":2,"byteLength":36})";
  expect_error(parts, "buffer 2");
  parts = {};
  parts.buffer = bytes_of<float>({0, 0, 0, 1, NAN, 0, 0, 1, 0});
  expect_error(parts, "vertex 1 has a position that is not finite");
  parts = {};
  parts.buffer += bytes_of<uint16_t>({0, 1, 3});
  parts.views += R"(,{"buffer":0,"byteOffset":36,"byteLength":6})";
  parts.accessors += R"(,{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"})";
  parts.primitives = R"({"attributes":{"POSITION":0},"indices":1})";
  expect_error(parts, "refers to vertex 3, expected 0 to 2");
}

TEST_F(Gltf, SurvivesRandomDamage) {
  const std::vector<std::string> files = {GltfParts().json(), GltfParts().binary()};
  Random random(31);
  set_log_level(LogLevel::kQuiet);
  reset_largest_allocation();
  for (int i = 0; i < 1000; ++i) {
    std::string damaged = files[static_cast<size_t>(i % 2)];
    for (int k = 0; k < 2; ++k) {
      const auto place = static_cast<size_t>(random.unit() * static_cast<float>(damaged.size()));
      const float byte = k == 0 ? '0' + 10 * random.unit() : 256 * random.unit();
      damaged[place] = static_cast<char>(static_cast<int>(byte));
    }
    error_of([&] { load(std::to_string(i) + "damaged.gltf", damaged); });
  }
  EXPECT_LT(largest_allocation(), size_t{4} << 20);
  set_log_level(LogLevel::kWarn);
}

}  // namespace
}  // namespace kinome::test::gltf_test
