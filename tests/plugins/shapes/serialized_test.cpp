/// Tests files of Mitsuba 0.5 and 0.6, which are built here byte by byte.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <numeric>

#include "kinome/shape.h"
#include "support/render.h"

namespace kinome::test::serialized_test {
namespace {

class Bytes {
 public:
  template <class T>
  Bytes& put(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return *this;
  }
  Bytes& put_text(const std::string& text) {
    text_ += text;
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string compressed(const std::string& text) {
  uLongf size = compressBound(text.size());
  std::string out(size, '\0');
  EXPECT_EQ(compress(reinterpret_cast<Bytef*>(out.data()), &size,
                     reinterpret_cast<const Bytef*>(text.data()), text.size()),
            Z_OK);
  out.resize(size);
  return out;
}

struct MeshData {
  uint16_t version = 4;
  bool doubles = false;
  std::vector<Vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  std::vector<Vec3> normals;
  std::vector<Vec2> uvs;
  std::vector<Vec3> colours;
  std::vector<uint32_t> indices{0, 1, 2, 0, 1, 3};
  uint64_t claimed_vertices = 0;  ///< 0: the true number of vertices
  size_t cut = 0;                 ///< number of missing bytes at the end of the compressed block

  std::string block() const {
    Bytes b;
    b.put<uint32_t>((normals.empty() ? 0u : 1u) | (uvs.empty() ? 0u : 2u) |
                    (colours.empty() ? 0u : 8u) | (doubles ? 0x2000u : 0x1000u));
    if (version == 4) b.put_text("a mesh").put('\0');
    b.put<uint64_t>(claimed_vertices ? claimed_vertices : positions.size());
    b.put<uint64_t>(indices.size() / 3);
    const auto number = [&](float v) {
      if (doubles) {
        b.put(static_cast<double>(v));
      } else {
        b.put(v);
      }
    };
    const auto all = [&](const auto& vectors, int size) {
      for (const auto& v : vectors) {
        for (int k = 0; k < size; ++k) number(v[k]);
      }
    };
    all(positions, 3), all(normals, 3), all(uvs, 2), all(colours, 3);
    for (const uint32_t i : indices) b.put(i);
    std::string packed = compressed(b.text());
    packed.resize(packed.size() - cut);
    return Bytes().put<uint16_t>(0x041c).put(version).text() + packed;
  }
};

std::string file_of(const std::vector<MeshData>& meshes) {
  std::string text;
  Bytes list;
  for (const MeshData& mesh : meshes) {
    if (mesh.version == 4) {
      list.put<uint64_t>(text.size());
    } else {
      list.put(static_cast<uint32_t>(text.size()));
    }
    text += mesh.block();
  }
  return text + list.put(static_cast<uint32_t>(meshes.size())).text();
}

class Serialized : public testing::Test {
 protected:
  std::shared_ptr<Shape> load(const std::string& bytes, int index = 0,
                              const std::string& more = "") const {
    return make<Shape>("<shape type='serialized'><string name='filename' value='" +
                       folder_.write("mesh.serialized", bytes) +
                       "'/><integer name='shape_index' value='" + std::to_string(index) + "'/>" +
                       more + "</shape>");
  }
  std::string fault(const std::string& bytes, int index = 0) const {
    try {
      load(bytes, index);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

 private:
  TemporaryFolder folder_;
};

/// Half of 1 x 2 and half of 1 x 3.
constexpr float kArea = 1 + 1.5f;

TEST_F(Serialized, ReadsBothVersionsAndPrecisions) {
  for (const uint16_t version : {3, 4}) {
    for (const bool doubles : {false, true}) {
      MeshData mesh;
      mesh.version = version;
      mesh.doubles = doubles;
      mesh.normals.assign(4, Vec3(0, 0, 1));
      mesh.uvs = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
      mesh.colours.assign(4, Vec3(0.5f));
      const auto shape = load(file_of({mesh}));
      EXPECT_FLOAT_EQ(shape->area(), kArea);
      EXPECT_EQ(shape->bounds().hi, Vec3(1, 2, 3));
    }
  }
}

TEST_F(Serialized, ReadsTheRequestedMesh) {
  MeshData small, large;
  for (Vec3& p : large.positions) p *= 10.f;
  for (const uint16_t version : {3, 4}) {
    small.version = large.version = version;
    const std::string bytes = file_of({small, large, small});
    EXPECT_FLOAT_EQ(load(bytes, 0)->area(), kArea);
    EXPECT_FLOAT_EQ(load(bytes, 1)->area(), 100 * kArea);
    EXPECT_FLOAT_EQ(load(bytes, 2)->area(), kArea);
    for (const int index : {3, -1}) {
      EXPECT_NE(fault(bytes, index).find("must be between 0 and 2, because the file has 3 meshes"),
                std::string::npos);
    }
  }
}

/// The data are larger than one zlib window.
TEST_F(Serialized, ReadsManyVertices) {
  MeshData mesh;
  mesh.positions.clear();
  mesh.indices.clear();
  for (uint32_t i = 0; i < 100000; ++i) {
    const auto x = static_cast<float>(i);
    for (const Vec3& p : {Vec3(x, 0, 0), Vec3(x + 1, 0, 0), Vec3(x, 1, 0)}) {
      mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
      mesh.positions.push_back(p);
    }
  }
  for (const bool doubles : {false, true}) {
    mesh.doubles = doubles;
    EXPECT_NEAR(load(file_of({mesh}))->area(), 50000, 5);
  }
}

TEST_F(Serialized, ReportsErrors) {
  const MeshData good;
  const std::string bytes = file_of({good});
  const auto with = [&](auto change) {
    MeshData mesh;
    change(mesh);
    return file_of({mesh});
  };
  const auto says = [&](const std::string& broken, const char* what) {
    const std::string message = fault(broken);
    EXPECT_NE(message.find(what), std::string::npos) << what << ": " << message;
    EXPECT_NE(message.find("mesh.serialized"), std::string::npos) << message;
  };
  says("", "is not a file of serialized meshes");
  says("ply\nformat", "is not a file of serialized meshes");
  says(Bytes().put<uint16_t>(0x041c).put<uint16_t>(9).text() + bytes.substr(4), "has version 9");
  says(bytes.substr(0, 4), "ends too early");
  says(with([](MeshData& m) { m.cut = 12; }), "ends too early");
  says(with([](MeshData& m) { m.indices[4] = 4; }), "triangle 1 refers to vertex 4");
  says(with([](MeshData& m) { m.positions[2].y = kInfinity; }), "vertex 2 has a position");
  says(with([](MeshData& m) { m.claimed_vertices = 1000000; }), "more than the file can contain");
  says(with([](MeshData& m) { m.claimed_vertices = ~uint64_t{0}; }), "fewer than 2^32");
  std::string broken = bytes;
  for (size_t i = 8; i < 40; ++i) broken[i] = static_cast<char>(i * 37);
  says(broken, "");
}

/// As in Mitsuba 3.9.1, the first mesh needs no list of meshes, and vertices without triangles may
/// have any values.
TEST_F(Serialized, ReadsTheFilesThatMitsubaReads) {
  const std::string bytes = file_of({MeshData{}});
  EXPECT_FLOAT_EQ(load(bytes.substr(0, bytes.size() - 12))->area(), kArea);
  EXPECT_NE(fault(bytes.substr(0, bytes.size() - 12), 1).find("without a list"),
            std::string::npos);
  MeshData mesh;
  mesh.positions.emplace_back(kInfinity, 0.f, NAN);
  EXPECT_FLOAT_EQ(load(file_of({mesh}))->area(), kArea);
  mesh.indices.clear();
  EXPECT_EQ(load(file_of({mesh}))->area(), 0);
}

}  // namespace
}  // namespace kinome::test::serialized_test
