// Tests attributes of meshes, and the texture that shows them.

#include <gtest/gtest.h>

#include <memory>
#include <sstream>

#include "kinome/block_points.h"
#include "kinome/emitter.h"
#include "kinome/texture.h"
#include "support/shape_helpers.h"
#include "support/block_memory.h"
#include "support/plugin_sets.h"

namespace kinome::test::mesh_attribute_test {
namespace {

std::string texture(const std::string& name, const std::string& as = "reflectance",
                    const std::string& more = "") {
  return "<texture type='mesh_attribute' name='" + as + "'><string name='name' value='" + name +
         "'/>" + more + "</texture>";
}
std::string material(const std::string& name) {
  return "<bsdf type='diffuse'>" + texture(name) + "</bsdf>";
}

class Attributes : public testing::Test {
 protected:
  /// Returns a square of two triangles (or one quadrangle) whose vertices have `properties`.
  std::string ply(const std::vector<std::string>& properties,
                  const std::vector<std::string>& of_faces = {}, bool is_quadrangle = false) {
    std::ostringstream out;
    out << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
           "property float z\n";
    for (const auto& name : properties) out << "property float " << name << '\n';
    out << "element face " << (is_quadrangle ? 1 : 2)
        << "\nproperty list uchar int vertex_indices\n";
    for (const auto& name : of_faces) out << "property float " << name << '\n';
    out << "end_header\n";
    const char* const places[] = {"0 0 0", "2 0 0", "2 2 0", "0 2 0"};
    for (int v = 0; v < 4; ++v) {
      out << places[v];
      for (size_t k = 0; k < properties.size(); ++k) out << ' ' << value(v, k);
      out << '\n';
    }
    for (int f = 0; f < (is_quadrangle ? 1 : 2); ++f) {
      out << (is_quadrangle ? "4 0 1 2 3" : f == 0 ? "3 0 1 2" : "3 0 2 3");
      for (size_t k = 0; k < of_faces.size(); ++k) out << ' ' << value(f, k);
      out << '\n';
    }
    return folder_.write("a.ply", out.str());
  }
  /// Returns value k of vertex or face i.
  static float value(int i, size_t k) {
    return static_cast<float>(i + 1) * 0.1f + static_cast<float>(k) * 0.01f;
  }
  static std::string shape(const std::string& file, const std::string& inside) {
    return "<shape type='ply'><string name='filename' value='" + file + "'/>" + inside + "</shape>";
  }
  std::string error_with(const std::string& inside, const std::vector<std::string>& properties) {
    const std::string file = ply(properties);
    return error_of([&] { make<Shape>(shape(file, inside)); });
  }

  TemporaryFolder folder_;
};

SurfaceInteraction seen_at(const Scene& scene, float x, float y) {
  const RayHit hit = trace(scene, {x, y, 5}, {0, 0, -1});
  EXPECT_TRUE(hit.hit.valid());
  return scene.interaction(hit);
}

TEST_F(Attributes, AreInterpolatedOverTrianglesAndConstantOverFaces) {
  const std::string file = ply({"r", "g", "b", "heat_x"}, {"red", "green", "blue"});
  const auto scene =
      scene_from(shape(file, "<bsdf type='blendbsdf'>" + texture("vertex_heat", "weight") +
                                 material("vertex_color") + material("face_color") + "</bsdf>"));
  const auto vertex = make<Texture>(texture("vertex_color"));
  const auto face = make<Texture>(texture("face_color"));
  const auto heat = make<Texture>(texture("vertex_heat", "x", "<float name='scale' value='3'/>"));
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const float x = random.between(0.01f, 1.99f), y = random.between(0.01f, 1.99f);
    if (std::abs(x - y) < 1e-4f) continue;
    const SurfaceInteraction si = seen_at(*scene, x, y);
    // The triangle below the diagonal has the vertices 0, 1, 2, the other one 0, 2, 3.
    const bool is_lower = y < x;
    const float b2 = is_lower ? y / 2 : x / 2, b1 = is_lower ? x / 2 - b2 : y / 2 - b2;
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](int v) { return value(v, static_cast<size_t>(k)); };
      const float expected = (1 - b1 - b2) * at(0) + b1 * at(is_lower ? 1 : 3) + b2 * at(2);
      EXPECT_NEAR(vertex->eval_at(si)[k], expected, 2e-6f);
      EXPECT_FLOAT_EQ(face->eval_at(si)[k], at(is_lower ? 0 : 1));
    }
    const auto at = [&](int v) { return value(v, 3); };
    EXPECT_NEAR(heat->eval_1_at(si),
                3 * ((1 - b1 - b2) * at(0) + b1 * at(is_lower ? 1 : 3) + b2 * at(2)), 6e-6f);
    EXPECT_EQ(heat->eval_at(si), Rgb(heat->eval_1_at(si)));
  }
}

/// Names of Mitsuba 3.9.1; "" if Mitsuba ignores the properties.
TEST_F(Attributes, OfPlyFilesHaveMitsubasNames) {
  struct Case {
    std::vector<std::string> properties;
    const char* name;
    std::vector<size_t> numbers;  ///< indices of the properties
  };
  const Case cases[] = {
      {{"r", "g", "b"}, "vertex_color", {0, 1, 2}},
      {{"b", "r", "g"}, "vertex_color", {1, 2, 0}},
      {{"red", "green", "blue"}, "vertex_color", {0, 1, 2}},
      {{"r", "q_x", "g", "b"}, "vertex_color", {0, 2, 3}},
      {{"r", "q_x", "g", "b"}, "vertex_q", {1}},
      {{"r", "g"}, "vertex_color", {}},
      {{"color_r", "color_g", "color_b"}, "vertex_color_color", {0, 1, 2}},
      {{"foo_a_x", "foo_a_y", "foo_a_z"}, "vertex_foo_a", {0, 1, 2}},
      {{"foo_0", "foo_1", "foo_2"}, "vertex_foo", {0, 1, 2}},
      {{"foo_1", "foo_2", "foo_3"}, "vertex_foo", {0, 1, 2}},
      {{"foo_r"}, "vertex_foo_color", {0}},
      {{"foo_g", "foo_b", "foo_r"}, "vertex_foo_color", {2}},
      {{"foo_x", "foo_y", "bar_x"}, "vertex_foo", {}},
      {{"foo_x", "foo_y", "bar_x"}, "vertex_bar", {2}},
      {{"foo_x", "bar_x", "foo_y"}, "vertex_foo", {0}},
      {{"foo_r", "foo_g", "foo_b", "foo_a"}, "vertex_foo_color", {}},
      {{"foo_y", "foo_z", "foo_w"}, "vertex_foo", {}},
      {{"foo", "bar"}, "vertex_foo", {}},
      {{"foo_red"}, "vertex_foo", {}},
      {{"vertex_temp"}, "vertex_temp", {}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const std::string file = ply(c.properties);
    const std::string xml = shape(file, material(c.name));
    if (c.numbers.empty()) {
      EXPECT_NE(error_of([&] { make<Shape>(xml); }).find("which the shape doesn't have"),
                std::string::npos);
      continue;
    }
    const auto made = make<Shape>(xml);
    const auto attribute = made->attribute(c.name);
    ASSERT_TRUE(attribute);
    ASSERT_EQ(attribute->attribute->size, c.numbers.size());
    for (int v = 0; v < 4; ++v) {
      for (size_t k = 0; k < c.numbers.size(); ++k) {
        EXPECT_FLOAT_EQ(attribute->attribute->values[v * c.numbers.size() + k],
                        value(v, c.numbers[k]));
      }
    }
  }
}

TEST_F(Attributes, OfAFaceHoldForAllItsTriangles) {
  const auto quadrangle = make<Shape>(shape(ply({}, {"q_x"}, true), material("face_q")));
  EXPECT_EQ(quadrangle->attribute("face_q")->attribute->values, std::vector<float>(2, value(0, 0)));
}

TEST_F(Attributes, AreReadOnlyIfATextureUsesThem) {
  const auto plain = make<Shape>(shape(ply({"r", "g", "b"}), ""));
  EXPECT_TRUE(plain->mesh()->attributes.empty());
  EXPECT_FALSE(plain->attribute("vertex_color"));
}

/// Tests COLOR_0 of a triangle, as floats and as bytes with an opacity.
TEST_F(Attributes, OfGltfFilesAreColours) {
  const auto gltf = [&](const std::string& accessor, const std::string& bytes, size_t size) {
    return folder_.write(
        "a.gltf",
        R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0,
        "COLOR_0": 1}}]}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3,
        "type": "VEC3", "min": [0,0,0], "max": [0,0,0]}, {"bufferView": 1, "count": 3, )" +
            accessor + R"(}], "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": )" +
            std::to_string(size) + R"(}], "buffers": [{"byteLength": )" +
            std::to_string(36 + size) + R"(, "uri": "data:application/octet-stream;base64,)" +
            // (0, 0, 0), (1, 0, 0), (0, 1, 0)
            "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" + bytes + R"("}]})");
  };
  const auto values = [&](const std::string& file) {
    const auto shape = make<Shape>("<shape type='gltf'><string name='filename' value='" + file +
                                   "'/>" + material("vertex_color") + "</shape>");
    return shape->attribute("vertex_color")->attribute->values;
  };
  // 1 0 0, 0 1 0, 0 0 1
  EXPECT_EQ(values(gltf(R"("componentType": 5126, "type": "VEC3")",
                        "AACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/", 36)),
            (std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  // 255 0 51 255, 0 255 0 0, 51 51 51 9
  const std::vector<float> bytes = values(
      gltf(R"("componentType": 5121, "normalized": true, "type": "VEC4")", "/wAz/wD/AAAzMzMJ", 12));
  const std::vector<float> expected{1, 0, .2f, 0, 1, 0, .2f, .2f, .2f};
  ASSERT_EQ(bytes.size(), expected.size());
  for (size_t i = 0; i < bytes.size(); ++i) EXPECT_FLOAT_EQ(bytes[i], expected[i]);
  EXPECT_NE(error_of([&] {
              values(gltf(R"("componentType": 5121, "type": "VEC2")", "AAAAAAAA", 6));
            }).find("wrong type"),
            std::string::npos);
}

TEST_F(Attributes, ThatAreMissingOrOfAnotherSizeAreErrors) {
  const auto expect = [](const std::string& message, const std::string& what) {
    EXPECT_NE(message.find(what), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_EQ(message.find("test.xml:1:"), 0u) << message;
  };
  expect(error_with(material("vertex_foo"), {"r", "g", "b"}),
         "reads the attribute 'vertex_foo', which the shape doesn't have");
  expect(error_with(material("vertex_color"), {"r", "g", "b", "a"}),
         "'vertex_color', which has 4 numbers, expected 1 or 3");
  expect(error_with(material("color"), {}), "must begin with 'vertex_' or 'face_', got 'color'");
  expect(error_with("<emitter type='area'>" + texture("vertex_foo", "radiance") + "</emitter>", {}),
         "which the shape doesn't have");
  expect(error_of(
             [&] { make<Shape>("<shape type='sphere'>" + material("vertex_color") + "</shape>"); }),
         "which the shape doesn't have");
  expect(error_of([&] {
           make<Emitter>("<emitter type='projector'>" + texture("vertex_color", "irradiance") +
                         "</emitter>");
         }),
         "isn't part of a mesh");
  // The number of channels is checked only when the texture is evaluated as a scalar.
  const auto scene = scene_from(shape(ply({"r", "g", "b"}), material("vertex_color")));
  const auto number = make<Texture>(texture("vertex_color"));
  const SurfaceInteraction si = seen_at(*scene, 0.5f, 0.7f);
  expect(error_of([&] { number->eval_1_at(si); }), "must be a single number here");
}

TEST_F(Attributes, OfALampAreItsRadiance) {
  const auto scene = scene_from(
      shape(ply({"r", "g", "b"}),
            "<emitter type='area'>" + texture("vertex_color", "radiance") + "</emitter>"));
  const Emitter& lamp = *scene->emitters().at(0);
  BlockMemory memory(16);
  const Columns3 p = memory.three();
  const Columns2 u = memory.two();
  DirectBlock direct{memory.three(), memory.one(), memory.one(), memory.three(), memory.one()};
  Random random(2);
  for (size_t i = 0; i < 16; ++i) {
    p.set(i, {random.between(-1, 3), random.between(-1, 3), 2});
    u.set(i, {random.unit(), random.unit()});
  }
  lamp.sample_direct_block(p, u, 16, direct);
  for (size_t i = 0; i < 16; ++i) {
    const auto sample = lamp.sample_direct(p.at(i), u.at(i));
    ASSERT_TRUE(sample);
    const RayHit hit = trace(*scene, p.at(i), sample->d);
    ASSERT_TRUE(hit.hit.valid());
    const SurfaceInteraction si = scene->interaction(hit);
    EXPECT_LT(largest_difference(lamp.eval_surface(si), sample->radiance), 1e-5f);
    EXPECT_LT(largest_difference(direct.radiance.at(i), sample->radiance), 1e-5f);
  }
}

class AttributeBlocks : public testing::TestWithParam<InstructionSet> {};

/// Tests two shapes alternating, runs of one shape, and a partial last vector.
TEST_P(AttributeBlocks, MatchSinglePoints) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.ply", R"(ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property float r
property float g
property float b
property float q_x
element face 2
property list uchar int vertex_indices
property float f_x
property float f_y
property float f_z
end_header
0 0 0 .1 .2 .3 .4
2 0 .5 .5 .3 .2 .1
0 1.5 .25 .9 .8 .7 .6
2 1 -1 0 1 0 1
3 0 1 2 .1 .4 .7
3 1 3 2 .2 .5 .8
)");
  std::string bsdf = "<bsdf type='blendbsdf'>" + texture("vertex_q", "weight") +
                     material("vertex_color") + material("face_f") + "</bsdf>";
  const auto shape = [&](const std::string& to_world) {
    return make_for<Shape>(GetParam(), "<shape type='ply'><string name='filename' value='" + file +
                                           "'/>" + bsdf + "<transform name='to_world'>" + to_world +
                                           "</transform></shape>");
  };
  const auto a = shape("<scale value='2'/>");
  const auto b = shape("<translate x='300'/><rotate z='1' angle='9'/>");
  Random random(3);
  for (const size_t count : kRanges) {
    BlockMemory memory(count);
    SurfaceBlock points;
    points.count = count;
    for (Columns3* c : {&points.p, &points.n, &points.s, &points.t, &points.sn, &points.wi}) {
      *c = memory.three();
    }
    points.uv = memory.two();
    points.p_error = memory.one();
    points.primitive = memory.indices(), points.ray = memory.indices();
    std::vector<const Shape*> shapes(padded(count) + 1, a.get());
    points.shape = shapes.data();
    std::vector<SurfaceInteraction> all;
    for (size_t i = 0; i < count; ++i) {
      shapes[i] = i < 16 || i % 2 == 0 ? a.get() : b.get();
      Vec2 u;
      u.x = random.unit();
      u.y = random.unit();
      all.push_back(shapes[i]->sample_surface(u));
      all.back().shape = shapes[i];
      points.p.set(i, all.back().p);
      points.primitive[i] = all.back().primitive;
    }
    const Columns3 colors = memory.three();
    float* const numbers = memory.one();
    for (const char* name : {"vertex_color", "face_f", "vertex_q"}) {
      const auto attribute = make_for<Texture>(GetParam(), texture(name));
      attribute->eval_block_at(points, colors);
      if (std::string(name) == "vertex_q") attribute->eval_1_block_at(points, numbers);
      for (size_t i = 0; i < count; ++i) {
        EXPECT_LT(largest_difference(colors.at(i), attribute->eval_at(all[i])), 2e-4f);
        if (std::string(name) != "vertex_q") continue;
        EXPECT_NEAR(numbers[i], attribute->eval_1_at(all[i]), 2e-4f);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, AttributeBlocks, testing::ValuesIn(instruction_sets()),
                         [](const auto& test) { return name_of(test.param); });

}  // namespace
}  // namespace kinome::test::mesh_attribute_test
