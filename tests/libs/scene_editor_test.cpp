// Tests that an edited scene renders the same image as a scene file with these edits. Only objects
// that depend on the edit may be recreated.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "kinome/scene_editor.h"
#include "libs/scene_edits.h"
#include "support/render.h"

namespace kinome::test::scene_editor_test {
namespace {

using namespace scene_edits;

struct Case {
  const char* path;
  EditedValue value;
  std::string Texts::*text;
  const char* written;
  Names made;
  size_t refitted;
  bool has_new_structure;
};

TEST_F(SceneEdits, GiveTheImageOfTheEditedFileAndRebuildOnlyDependents) {
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

TEST_F(SceneEdits, FindObjectsByTheirPathsAndBack) {
  const auto editor = open();
  for (const float radius : {0.5f, 0.2f}) {
    editor->set("ball.radius", radius);
    editor->update();
    for (const SceneObject& one : editor->objects()) {
      const auto found = editor->object_at(one.path);
      ASSERT_TRUE(found) << one.path;
      EXPECT_EQ(found->object, one.object) << one.path;
      EXPECT_EQ(found->plugin, one.plugin) << one.path;
      EXPECT_EQ(editor->path_of(*one.object), one.path);
    }
    Names paths;
    for (const auto& shape : editor->scene()->shapes()) paths.push_back(editor->path_of(*shape));
    EXPECT_EQ(paths, (Names{"ball", "mesh", "floor", "lamp", "near"}));
  }
  EXPECT_FALSE(editor->object_at("bal"));
  EXPECT_FALSE(editor->object_at("red.bsdf_0")) << "another name than the listed path";
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

TEST_F(SceneEdits, ApplyOnlyToListedParameters) {
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

}  // namespace
}  // namespace kinome::test::scene_editor_test
