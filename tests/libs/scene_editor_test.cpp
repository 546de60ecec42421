// Tests that an edited scene renders the same image as a scene file with these edits. Only objects
// that depend on the edit may be recreated.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include <glm/gtc/matrix_transform.hpp>

#include "kinome/scene_editor.h"
#include "support/render.h"

namespace kinome::test::scene_editor_test {
namespace {

/// Texts in the scene file; each case changes one of them.
struct Texts {
  std::string fov = "40";
  std::string samples = "4";
  std::string stddev = "0.5";
  std::string width = "24";
  std::string depth = "3";
  std::string red = "0.6, 0.2, 0.1";
  std::string alpha = "0.3";
  std::string color0 = "0.4";
  std::string radiance = "3, 2, 1";
  std::string sky = "0.2";
  std::string ball = "0, 0.5, 0";
  std::string group_red = "0.3, 0.4, 0.5";
  std::string mesh = "mesh.ply";
};

std::string scene_text(const Texts& t) {
  return R"(<scene version="3.0.0">
  <integrator type="path"> <integer name="max_depth" value=")" +
         t.depth + R"("/> </integrator>
  <sensor type="perspective">
    <float name="fov" value=")" +
         t.fov + R"("/>
    <transform name="to_world">
      <lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/> </transform>
    <sampler type="independent">
      <integer name="sample_count" value=")" +
         t.samples + R"("/> </sampler>
    <film type="hdrfilm">
      <integer name="width" value=")" +
         t.width + R"("/> <integer name="height" value="16"/>
      <rfilter type="gaussian"><float name="stddev" value=")" +
         t.stddev + R"("/></rfilter>
    </film>
  </sensor>
  <bsdf type="twosided" id="red">
    <bsdf type="diffuse"><rgb name="reflectance" value=")" +
         t.red + R"("/></bsdf>
  </bsdf>
  <shape type="sphere" id="ball">
    <point name="center" value=")" +
         t.ball + R"("/> <float name="radius" value="0.5"/>
    <ref id="red"/>
  </shape>
  <shape type="ply" id="mesh">
    <string name="filename" value=")" +
         t.mesh + R"("/>
    <bsdf type="roughconductor"><float name="alpha" value=")" +
         t.alpha + R"("/></bsdf>
  </shape>
  <shape type="disk" id="floor">
    <transform name="to_world"><scale value="3"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse">
      <texture type="checkerboard" name="reflectance">
        <float name="color0" value=")" +
         t.color0 + R"("/>
        <transform name="to_uv"><scale value="4"/></transform>
      </texture>
    </bsdf>
  </shape>
  <shape type="rectangle" id="lamp">
    <transform name="to_world"><rotate x="1" angle="90"/><translate y="3"/></transform>
    <emitter type="area"><rgb name="radiance" value=")" +
         t.radiance + R"("/></emitter>
  </shape>
  <shape type="shapegroup" id="group">
    <shape type="cube" id="box">
      <transform name="to_world"><scale value="0.2"/></transform>
      <bsdf type="diffuse"><rgb name="reflectance" value=")" +
         t.group_red + R"("/></bsdf>
    </shape>
  </shape>
  <shape type="instance" id="near">
    <ref id="group"/> <transform name="to_world"><translate x="1.2" y="0.3" z="1"/></transform>
  </shape>
  <emitter type="constant" id="sky">
    <rgb name="radiance" value=")" +
         t.sky + R"("/> </emitter>
</scene>)";
}

std::string mesh_text(float height) {
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
          "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
          "-2 0 -1\n2 0 -1\n2 2.5 -1.5\n-2 "
       << height << " -1\n3 0 1 2\n3 0 2 3\n";
  return text.str();
}

class SceneEdits : public testing::Test {
 protected:
  SceneEdits() {
    folder_.write("mesh.ply", mesh_text(2));
    folder_.write("other.ply", mesh_text(3));
  }
  std::unique_ptr<SceneEditor> open(const Texts& texts = {}) {
    const std::string path = folder_.write("scene.xml", scene_text(texts));
    return std::make_unique<SceneEditor>(path, LoadOptions{}, registry());
  }
  static void expect_same(const Scene& edited, const Scene& other) {
    const Image a = render_scene(edited), b = render_scene(other);
    ASSERT_EQ(a.width, b.width);
    EXPECT_EQ(a.data, b.data);
  }
  TemporaryFolder folder_;
};

using Names = std::vector<std::string>;

struct Case {
  const char* path;
  EditedValue value;
  std::string Texts::*text;
  const char* written;
  Names made;
  size_t refitted;
  bool has_new_structure;
};

TEST_F(SceneEdits, GiveThePictureOfTheEditedFileAndMakeOnlyWhatDepends) {
  const auto rgb = [](float r, float g, float b) {
    return UniformColor{Rgb(r, g, b), false, false};
  };
  const Names sensor{"sensor/perspective"};
  const Case cases[] = {
      {"sensor.fov", 55.0, &Texts::fov, "55", sensor, 0, false},
      {"sensor.sampler.sample_count",
       int64_t(9),
       &Texts::samples,
       "9",
       {"sampler/independent", "sensor/perspective"},
       0,
       false},
      {"sensor.film.width",
       int64_t(20),
       &Texts::width,
       "20",
       {"film/hdrfilm", "sensor/perspective"},
       0,
       false},
      {"sensor.film.rfilter.stddev",
       1.0,
       &Texts::stddev,
       "1",
       {"rfilter/gaussian", "film/hdrfilm", "sensor/perspective"},
       0,
       false},
      {"integrator.max_depth", int64_t(2), &Texts::depth, "2", {"integrator/path"}, 0, false},
      {"red.bsdf.reflectance.value",
       rgb(0.1f, 0.5f, 0.3f),
       &Texts::red,
       "0.1, 0.5, 0.3",
       {"bsdf/diffuse", "bsdf/twosided"},
       1,
       false},
      {"ball.bsdf.brdf_0.reflectance",
       rgb(0.1f, 0.5f, 0.3f),
       &Texts::red,
       "0.1, 0.5, 0.3",
       {"bsdf/diffuse", "bsdf/twosided"},
       1,
       false},
      {"mesh.bsdf.alpha", 0.1, &Texts::alpha, "0.1", {"bsdf/roughconductor"}, 1, false},
      {"floor.bsdf.reflectance.color0.value",
       0.8,
       &Texts::color0,
       "0.8",
       {"texture/checkerboard", "bsdf/diffuse"},
       1,
       false},
      {"lamp.emitter.radiance.value",
       rgb(1, 4, 2),
       &Texts::radiance,
       "1, 4, 2",
       {"emitter/area"},
       1,
       false},
      {"sky.radiance", rgb(0.5f, 0.5f, 0.5f), &Texts::sky, "0.5", {"emitter/constant"}, 0, false},
      {"ball.center", Vec3(1, 0.5f, 0), &Texts::ball, "1, 0.5, 0", {"shape/sphere"}, 0, true},
      {"box.bsdf.reflectance.value",
       rgb(1, 0, 0),
       &Texts::group_red,
       "1, 0, 0",
       {"bsdf/diffuse", "shape/shapegroup", "shape/instance"},
       1,
       true},
      {"mesh.filename",
       std::string("other.ply"),
       &Texts::mesh,
       "other.ply",
       {"shape/ply"},
       0,
       true},
      {"mesh.vertex_positions",
       std::vector<float>{-2, 0, -1, 2, 0, -1, 2, 2.5f, -1.5f, -2, 3, -1},
       &Texts::mesh,
       "other.ply",
       {},
       1,
       true},
  };
  const Image before = render_scene(*open()->scene());
  for (const Case& one : cases) {
    SCOPED_TRACE(one.path);
    const auto editor = open();
    render_scene(*editor->scene());  // state of a previous render must have no effect
    editor->set(one.path, one.value);
    const SceneChanges changes = editor->update();
    EXPECT_EQ(changes.made, one.made);
    EXPECT_EQ(changes.refitted, one.refitted);
    EXPECT_EQ(changes.has_new_structure, one.has_new_structure);
    Texts texts;
    texts.*one.text = one.written;
    expect_same(*editor->scene(), *open(texts)->scene());
    EXPECT_NE(render_scene(*editor->scene()).data, before.data);
  }
}

/// An edit of a medium doesn't make its shape again, and numbers aren't restricted to [0,1].
TEST_F(SceneEdits, OfMediaKeepTheirShapes) {
  const std::string text =
      "<scene version='3.0.0'><integrator type='path'/><medium type='homogeneous' id='fog'><float "
      "name='sigma_t' value='2'/><phase type='isotropic'/></medium><sensor type='perspective'/>"
      "<shape type='sphere' id='ball'><ref name='interior' "
      "id='fog'/><medium type='homogeneous' name='exterior'/></shape></scene>";
  SceneEditor editor(text, folder_.path("x.xml"), {}, registry());
  const auto shape = editor.scene()->shapes()[0];
  const auto extinction = [&] {
    return editor.scene()->media()[0]->coefficients({}, Vec3(0, 0, 1)).extinction.x;
  };
  EXPECT_EQ(extinction(), 2);
  editor.set("fog.sigma_t.value", 7.0);
  const SceneChanges changes = editor.update();
  EXPECT_EQ(changes.made, (Names{"medium/homogeneous"}));
  EXPECT_EQ(changes.refitted, 1u);
  EXPECT_FALSE(changes.has_new_structure);
  EXPECT_EQ(editor.scene()->shapes()[0], shape);
  EXPECT_EQ(extinction(), 7);
  EXPECT_EQ(editor.scene()->media().size(), 2u);
  const auto edit = [&](const char* path, EditedValue value) {
    editor.set(path, std::move(value));
    editor.update();
  };
  EXPECT_THROW(edit("fog.sigma_t.value", UniformColor{Rgb(8.f)}), Error);
  EXPECT_THROW(edit("fog.albedo.value", 2.0), Error);
  EXPECT_EQ(extinction(), 7);
}

/// The interior of a shape is that of its BSDF after an edit, too, and only one of the two exists.
TEST_F(SceneEdits, OfSubsurfaceLightSetTheInterior) {
  const std::string text =
      "<scene version='3.0.0'><integrator type='path'/><sensor type='perspective'/><bsdf "
      "type='subsurface' id='wax'><float name='radius' value='0.5'/></bsdf><shape type='sphere'>"
      "<ref id='wax'/></shape></scene>";
  SceneEditor editor(text, folder_.path("x.xml"), {}, registry());
  const auto extinction = [&] {
    return editor.scene()->shapes()[0]->interior()->coefficients({}, Vec3(0, 0, 1)).extinction.x;
  };
  EXPECT_EQ(extinction(), 2);
  editor.set("wax.radius.value", 0.25);
  const SceneChanges changes = editor.update();
  EXPECT_EQ(changes.made, (Names{"bsdf/subsurface"}));
  EXPECT_EQ(changes.refitted, 1u);
  EXPECT_EQ(extinction(), 4);
  EXPECT_EQ(editor.scene()->media().size(), 1u);
  EXPECT_EQ(editor.scene()->media()[0], editor.scene()->shapes()[0]->interior());
}

TEST_F(SceneEdits, AddUp) {
  const auto editor = open();
  editor->set("sensor.fov", 55.0);
  editor->set("red.bsdf.reflectance", UniformColor{Rgb(0.1f, 0.5f, 0.3f), false, false});
  EXPECT_EQ(std::get<double>(*editor->get("sensor.fov")), 55);
  editor->update();
  EXPECT_TRUE(editor->update().made.empty());
  // The shape is recreated together with its emitter.
  Mat4 up(1.f);
  editor->set("lamp.to_world", Transform(up));
  EXPECT_EQ(editor->update().made, (Names{"emitter/area", "shape/rectangle"}));
  editor->set("lamp.emitter.radiance", 2.0);
  EXPECT_EQ(editor->update().made, (Names{"emitter/area"}));
  std::string text = scene_text({.fov = "55", .red = "0.1, 0.5, 0.3", .radiance = "2, 2, 2"});
  const std::string lifted = R"(<rotate x="1" angle="90"/><translate y="3"/>)";
  text.replace(text.find(lifted), lifted.size(), "");
  const auto other = SceneEditor(text, folder_.path("x.xml"), {}, registry()).scene();
  expect_same(*editor->scene(), *other);
}

TEST_F(SceneEdits, ThatCantBeLeaveTheSceneAsItWas) {
  const auto editor = open();
  const auto message = [&](const char* path, EditedValue value) -> std::string {
    try {
      editor->set(path, std::move(value));
      editor->update();
    } catch (const Error& error) {
      const std::string text = error.what();
      return text.substr(std::min(text.find("scene.xml"), text.size()));
    }
    return "";
  };
  EXPECT_EQ(message("sensor.fov", std::string("wide")),
            "scene.xml:4:5: 'fov' must be a float, got a string");
  EXPECT_EQ(message("red.bsdf.reflectance", 2.0),
            "scene.xml:15:26: 'reflectance' is outside [0,1]: 2");
  EXPECT_EQ(message("sensor.fovv", 2.0),
            "scene.xml: unknown parameter 'sensor.fovv' (did you mean 'sensor.fov'?)");
  EXPECT_EQ(message("ball.radius", -1.0).substr(0, 35), "scene.xml:18:46: 'radius' must be p");
  EXPECT_EQ(message("mesh.vertex_positions", std::vector<float>(5)),
            "scene.xml:21:3: 'vertex_positions' must have 3 numbers for each vertex, got 5");
  EXPECT_EQ(message("mesh.vertex_positions", std::vector<float>(6)),
            "scene.xml:21:3: triangle 0 refers to vertex 2, but there are only 2 (counted from 0)");
  EXPECT_EQ(message("mesh.faces", std::vector<float>(6)),
            "scene.xml:21:3: 'faces' must be an array of indices");
  // A valid mesh, and an error in another object, which is detected only when that is created.
  editor->set("mesh.vertex_positions", std::vector<float>(12, 1));
  editor->set("red.bsdf.reflectance", 0.5);
  EXPECT_NE(message("sensor.film.rfilter.stddev", -1.0), "");
  EXPECT_TRUE(editor->update().made.empty());
  expect_same(*editor->scene(), *open()->scene());
}

TEST_F(SceneEdits, AreNotedTogetherOrNotAtAll) {
  const auto editor = open();
  editor->set("sensor.fov", 50.0);
  EXPECT_THROW(editor->set({{"sensor.fov", 60.0}, {"ball.radius", 0.2}, {"ball.radiu", 0.3}}),
               Error);
  EXPECT_EQ(std::get<double>(*editor->get("sensor.fov")), 50);
  EXPECT_EQ(std::get<double>(*editor->get("ball.radius")), 0.5);
  editor->set({{"sensor.fov", 60.0}, {"ball.radius", 0.2}});
  editor->update();
  EXPECT_EQ(std::get<double>(*editor->get("sensor.fov")), 60);
  EXPECT_EQ(std::get<double>(*editor->get("ball.radius")), 0.2);
}

/// Transforms of moved cameras and emitters are saved as readable steps.
TEST_F(SceneEdits, OfPlacesAreSaidByTheStepsOfTheFile) {
  const auto editor = open();
  const auto moved = [&](const char* path, const Mat4& by) {
    const Mat4 before = std::get<Transform>(*editor->get(path)).matrix();
    editor->set(path, Placed{Transform(by * before)});
    editor->update();
    const Mat4 now = std::get<Transform>(*editor->get(path)).matrix();
    for (int i = 0; i < 16; ++i) {
      EXPECT_NEAR(now[i / 4][i % 4], (by * before)[i / 4][i % 4], 5e-5f) << path << ' ' << i;
    }
  };
  const Mat4 way = glm::translate(Mat4(1.f), Vec3(0.3f, -0.1f, 0.7f));
  const Mat4 turn = glm::rotate(Mat4(1.f), 0.4f, glm::normalize(Vec3(0.2f, 1, 0.1f)));
  moved("sensor.to_world", way * turn);
  moved("lamp.to_world", way);
  moved("floor.to_world", way);
  moved("box.to_world", turn);  // no step of the file can represent this rotation
  moved("ball.to_world", way);
  editor->save(folder_.path("new.xml"));
  expect_same(*editor->scene(), *SceneEditor(folder_.path("new.xml"), {}, registry()).scene());
  std::ifstream file(folder_.path("new.xml"));
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const auto has = [&](const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_TRUE(has(R"(<transform name="to_world"><lookat origin=")")) << text;
  EXPECT_TRUE(has(R"(<rotate x="1" angle="90"/><translate x="0.3" y="2.9" z="0.7"/>)")) << text;
  EXPECT_TRUE(has(R"(<rotate x="1" angle="-90"/><translate x="0.3")")) << text;
  EXPECT_TRUE(has(R"(<transform name="to_world"><translate x="0.3")")) << text;
  EXPECT_EQ(text.find("<matrix"), text.rfind("<matrix")) << text;
  // An object that is moved back gets its original text.
  for (const char* const path :
       {"sensor.to_world", "lamp.to_world", "floor.to_world", "box.to_world", "ball.to_world"}) {
    editor->set(path, AsWritten{});
  }
  editor->update();
  editor->save(folder_.path("back.xml"));
  std::ifstream back(folder_.path("back.xml"));
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(back), {}), scene_text({}));
}

TEST_F(SceneEdits, ThatAFileCantSayAreNotSaved) {
  const auto editor = open();
  folder_.write("a$b.ply", mesh_text(3));
  editor->set({{"mesh.filename", std::string("a$b.ply")}, {"sensor.fov", 50.0}});
  editor->update();
  try {
    editor->save(folder_.path("new.xml"));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what())
                  .find("can't write 'a$b.ply' to a scene file, where a $ begins a name"),
              std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.path("new.xml")));
  // File names that XML can represent are saved, in quotes of either kind.
  folder_.write("it's.ply", mesh_text(3));
  editor->set("mesh.filename", std::string("it's.ply"));
  editor->update();
  editor->save(folder_.path("new.xml"));
  expect_same(*editor->scene(), *SceneEditor(folder_.path("new.xml"), {}, registry()).scene());
}

TEST_F(SceneEdits, AreSavedWithMeshesBesideThoseThatAreRead) {
  folder_.write("scene-mesh.ply", mesh_text(2));
  const auto editor = open({.mesh = "scene-mesh.ply"});
  editor->set("mesh.vertex_positions",
              std::vector<float>{-2, 0, -1, 2, 0, -1, 2, 2.5f, -1.5f, -2, 3, -1});
  editor->update();
  editor->save(folder_.path("scene.xml"));
  expect_same(*editor->scene(), *SceneEditor(folder_.path("scene.xml"), {}, registry()).scene());
  EXPECT_TRUE(std::filesystem::exists(folder_.path("scene-mesh_1.ply")));
  std::ifstream own(folder_.path("scene-mesh.ply"));
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(own), {}), mesh_text(2));
}

TEST_F(SceneEdits, AreOfWhatIsListed) {
  const auto editor = open();
  Names paths;
  for (const SceneParameter& parameter : editor->parameters()) {
    paths.push_back(parameter.path);
    EXPECT_NO_THROW(editor->get(parameter.path)) << parameter.path;
  }
  for (const char* const path :
       {"integrator.max_depth", "sensor.to_world", "sensor.film.rfilter.stddev", "ball.radius",
        "red.bsdf.reflectance.value", "mesh.vertex_positions", "mesh.faces", "sky.radiance.value",
        "floor.bsdf.reflectance.to_uv", "lamp.emitter.radiance.value", "near.to_world"}) {
    EXPECT_EQ(std::count(paths.begin(), paths.end(), path), 1) << path;
  }
  EXPECT_EQ(std::get<std::vector<uint32_t>>(*editor->get("mesh.faces")),
            (std::vector<uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_THROW(editor->get("floor.bsdf.reflectance"), Error);
}

TEST_F(SceneEdits, OfTheIntegratorShareAllElse) {
  const auto editor = open();
  ObjectDescription depth{.tag = "integrator", .type = "path", .where = {"integrator"}};
  depth.values.push_back({"max_depth", int64_t(2), {"integrator.max_depth"}});
  const auto other = editor->scene_with(depth);
  EXPECT_TRUE(other->shares_structure_with(*editor->scene()));
  expect_same(*other, *open({.depth = "2"})->scene());
  expect_same(*editor->scene(), *open()->scene());
  depth.values[0].name = "max_dept";
  EXPECT_THROW(editor->scene_with(depth), Error);
}

/// Scenes built in memory can be edited like those from files.
TEST_F(SceneEdits, OfAScenesDescription) {
  const auto object = [](const char* tag, const char* type, const char* name = "") {
    return ObjectDescription{.tag = tag, .type = type, .name = name, .where = {tag}};
  };
  ObjectDescription scene = object("scene", "");
  ObjectDescription ball = object("shape", "sphere");
  ball.id = "ball";
  ObjectDescription texture = object("texture", "bitmap", "reflectance");
  texture.values.push_back(
      {"data", std::make_shared<const Image>(Image{2, 1, {"Y"}, {0.2f, 0.8f}}), {"ball.data"}});
  ObjectDescription diffuse = object("bsdf", "diffuse", "bsdf");
  diffuse.parts.push_back(texture);
  ball.parts.push_back(diffuse);
  ObjectDescription film = object("film", "hdrfilm");
  for (const char* const side : {"width", "height"}) {
    film.values.push_back({side, int64_t(24), {"film"}});
  }
  ObjectDescription sensor = object("sensor", "perspective");
  sensor.values.push_back({"to_world", Transform(glm::translate(Mat4(1.f), Vec3(0, 0, -4))), {}});
  sensor.parts = {film};
  scene.parts = {object("integrator", "direct"), sensor, object("emitter", "constant"), ball};
  SceneEditor editor(scene, {}, registry());
  const Image before = render_scene(*editor.scene());
  editor.set("ball.bsdf.reflectance.data",
             std::make_shared<const Image>(Image{1, 1, {"Y"}, {0.5f}}));
  EXPECT_EQ(editor.update().made, (Names{"texture/bitmap", "bsdf/diffuse"}));
  const auto grey = scene_from(
      "<integrator type='direct'/><sensor type='perspective'><transform name='to_world'><translate "
      "z='-4'/></transform><film type='hdrfilm'><integer name='width' value='24'/><integer "
      "name='height' value='24'/></film></sensor><emitter type='constant'/><shape "
      "type='sphere'><bsdf type='diffuse'>"
      "<float name='reflectance' value='.5'/></bsdf></shape>");
  expect_same(*editor.scene(), *grey);
  EXPECT_NE(render_scene(*editor.scene()).data, before.data);
}

}  // namespace
}  // namespace kinome::test::scene_editor_test
