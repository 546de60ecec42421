#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include <glm/gtc/matrix_transform.hpp>

#include "kinome/scene_editor.h"
#include "libs/scene_edits.h"
#include "support/render.h"

/// Tests how edited scenes are saved and described.
namespace kinome::test::scene_editor_saving_test {
namespace {

using namespace scene_edits;

/// Transforms of moved cameras and emitters are saved as readable steps.
TEST_F(SceneEdits, OfTransformsAreSavedAsTheOperationsOfTheFile) {
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

TEST_F(SceneEdits, ThatXmlCantExpressAreNotSaved) {
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

TEST_F(SceneEdits, AreSavedWithMeshesBesideTheOriginals) {
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
}  // namespace kinome::test::scene_editor_saving_test
