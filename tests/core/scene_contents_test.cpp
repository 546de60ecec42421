#include <gtest/gtest.h>

#include <algorithm>

#include "support/plugins/probe_registry.h"
#include "support/render.h"

/// Tests the contents of a scene, given and by default.
namespace kinome::test {
namespace {

std::unique_ptr<Scene> load(const std::string& children, RenderStats* stats = nullptr) {
  return load_scene_from_string("<scene version=\"3.0.0\">" + children + "</scene>", "scene.xml",
                                {}, probe_registry(), stats);
}

TEST(Scene, TakesItsChildrenInOrder) {
  const auto scene = load(
      "<shape type='sphere' id='a'/><sensor type='perspective' id='cam0'><float name='fov' "
      "value='30'/></sensor><shape type='sphere' id='b'/><emitter type='constant' id='sky'/>"
      "<sensor type='perspective' id='cam1'><float name='fov' value='30'/></sensor>"
      "<integrator type='direct' id='how'/>");
  ASSERT_EQ(scene->shapes().size(), 2u);
  EXPECT_EQ(scene->shapes()[0]->id(), "a");
  EXPECT_EQ(scene->shapes()[1]->id(), "b");
  ASSERT_EQ(scene->sensors().size(), 2u);
  EXPECT_EQ(scene->sensors()[1]->id(), "cam1");
  ASSERT_NE(scene->environment(), nullptr);
  EXPECT_EQ(scene->environment()->id(), "sky");
  EXPECT_EQ(scene->integrator().id(), "how");
  EXPECT_EQ(scene->file(), "scene.xml");
}

TEST(Scene, HasDefaultsForAllThatItLacks) {
  const auto scene = load("<shape type='sphere'/>");
  ASSERT_EQ(scene->sensors().size(), 1u);
  EXPECT_EQ(scene->sensors()[0]->film().width(), 768);
  EXPECT_EQ(scene->sensors()[0]->sampler().sample_count(), 4u);
  EXPECT_EQ(scene->shapes()[0]->bsdf().reflectance(SurfaceInteraction()).diffuse, Rgb(0.5f));
}

/// Mitsuba 3.9.1 puts its camera at the middle of the box, size / (2 tan 22.5°) before its front.
TEST(Scene, TheDefaultSensorSeesTheShapes) {
  const auto scene = load(
      "<shape type='sphere'><point name='center' value='5 6 7'/><float name='radius' value='2'/>"
      "</shape>");
  const Ray ray = scene->sensors()[0]->sample_ray(Vec2(384, 288), Vec2(0.5f));
  EXPECT_NEAR(ray.o.x, 5, 1e-4);
  EXPECT_NEAR(ray.o.y, 6, 1e-4);
  EXPECT_NEAR(ray.o.z, 5 - 4 / (2 * std::tan(22.5 * M_PI / 180)), 1e-4);
  EXPECT_NEAR(ray.d.z, 1, 1e-4);
}

/// Unsupported plugins of Mitsuba are omitted or replaced by Mitsuba's defaults.
TEST(Scene, LenientLeavesOutUnsupportedPlugins) {
  const std::string xml =
      "<scene version=\"3.0.0\">\n<integrator type='stokes'><integrator type='volpath'>"
      "<integer name='max_depth' value='3'/></integrator>"
      "</integrator>\n"
      "<medium type='homogeneous' id='fog'><phase type='hg'/></medium>\n"
      "<alias id='fog' as='mist'/>"
      "<shape type='sphere' id='a'><ref name='interior' id='mist'/><bsdf type='circular'/>"
      "</shape>\n"
      "<shape type='sdfgrid' id='b'><bsdf type='diffuse'/></shape>"
      "<sensor type='perspective'><float name='fov' value='30'/><medium type='heterogeneous'/>"
      "<film type='specfilm'><integer name='width' value='33'/><string name='component_format' "
      "value='float32'/><rfilter type='box'/></film></sensor></scene>";
  LoadOptions options;
  options.lenient = true;
  RenderStats stats;
  const auto scene =
      load_scene_from_string(xml, "scene.xml", options, probe_registry(), &stats);
  EXPECT_EQ(scene->integrator().plugin(), "integrator/volpath");
  ASSERT_EQ(scene->shapes().size(), 1u);
  EXPECT_EQ(scene->shapes()[0]->bsdf().plugin(), "bsdf/diffuse");
  EXPECT_EQ(scene->sensors()[0]->film().width(), 33);
  EXPECT_EQ(scene->sensors()[0]->film().filter().radius(), 0.5f);
  EXPECT_TRUE(scene->shapes()[0]->interior());
  EXPECT_TRUE(scene->sensors()[0]->medium());
  EXPECT_EQ(stats.left_out,
            (std::vector<std::string>{
                "scene.xml:2:1: integrator 'stokes', replaced by the integrator in it",
                "scene.xml:4:88: bsdf 'circular', replaced by 'diffuse'",
                "scene.xml:5:1: shape 'sdfgrid'",
                "scene.xml:5:147: film 'specfilm', replaced by 'hdrfilm'"}));
  // Errors are still reported.
  for (const char* wrong :
       {"<bsdf type='difuse'/>", "<shape type='sphere'><ref id='no'/></shape>"}) {
    EXPECT_THROW(load_scene_from_string("<scene version=\"3.0.0\">" + std::string(wrong) +
                                            "</scene>",
                                        "scene.xml", options, probe_registry()),
                 Error)
        << wrong;
  }
}

/// As in Mitsuba, an area emitter may be outside the element of its shape.
TEST(Scene, EmittersMayBeBesideTheirShapes) {
  const std::string lamp = "<emitter type='area' id='lamp'/>";
  const std::string shape = "<shape type='sphere'><ref id='lamp'/></shape>";
  for (const std::string& both : {lamp + shape, shape + lamp}) {
    const auto scene = scene_from(both);
    ASSERT_EQ(scene->emitters().size(), 1u);
    EXPECT_EQ(scene->emitters()[0]->shape(), scene->shapes()[0].get());
  }
  // Without a shape it emits no light. This is a warning because Mitsuba ignores it.
  EXPECT_TRUE(scene_from(lamp + "<shape type='sphere'/>")->emitters().empty());
  EXPECT_THROW(scene_from(lamp + shape + shape), Error) << "an area emitter belongs to one shape";
}

TEST(Scene, IgnoresParametersOfMitsubasImplementation) {
  EXPECT_NO_THROW(scene_from(
      "<integrator type='path'><integer name='block_size' value='32'/><integer "
      "name='samples_per_pass' value='16'/><float name='timeout' value='5'/></integrator>"
      "<emitter type='constant'><float name='sampling_weight' value='2'/></emitter>"));
  EXPECT_THROW(scene_from("<integrator type='path'><integer name='block_sizes' value='32'/>"
                          "</integrator>"),
               Error);
  EXPECT_THROW(scene_from("<emitter type='constant'><integer name='block_size' value='3'/>"
                          "</emitter>"),
               Error);
}

TEST(Scene, MayBeEmpty) {
  EXPECT_TRUE(load("")->shapes().empty());
}

TEST(Scene, SensorsKeepTheChildrenThatTheyHave) {
  const auto scene = load(
      "<sensor type='perspective'><float name='fov' value='30'/>"
      "<film type='hdrfilm'><integer name='width' value='32'/><integer name='height' value='16'/>"
      "<rfilter type='box'/></film><sampler type='independent'><integer name='sample_count' "
      "value='9'/></sampler></sensor>");
  EXPECT_EQ(scene->sensors()[0]->film().width(), 32);
  EXPECT_EQ(scene->sensors()[0]->sampler().sample_count(), 9u);
}

TEST(Scene, ReferencesShareTheirObject) {
  const auto scene = load(
      "<bsdf type='diffuse' id='m'/><shape type='sphere'><ref id='m'/></shape>"
      "<shape type='sphere'><ref id='m'/></shape>");
  EXPECT_EQ(scene->shapes()[0]->bsdf_pointer(), scene->shapes()[1]->bsdf_pointer());
  EXPECT_EQ(scene->shapes()[0]->bsdf().id(), "m");
}

TEST(Scene, ShapesThatAreReferredToAtTheRootCountOnce) {
  EXPECT_EQ(load("<shape type='sphere' id='s'/><ref id='s'/>")->shapes().size(), 1u);
}

TEST(Scene, UnusedObjectsAreChecked) {
  EXPECT_EQ(
      error_of([] { load("<bsdf type='diffuse'><rgb name='reflectance' value='2'/></bsdf>"); }),
      "scene.xml:1:45: 'reflectance' is outside [0,1]: 2 2 2");
}

std::string unused_error(const std::string& children) {
  return error_of([&] { load(children); });
}

TEST(Scene, UnusedObjectsAreNotMade) {
  RenderStats stats;
  load(
      "<texture type='bitmap' id='wood'><string name='filename' value='missing.exr'/></texture>"
      "<bsdf type='diffuse' id='floor'><ref name='reflectance' id='wood'/></bsdf>"
      "<texture type='checkerboard'/><bsdf type='diffuse' id='used'/>"
      "<shape type='sphere'><ref id='used'/></shape>",
      &stats);
  std::vector<std::string> skipped;
  for (const Skipped& s : stats.skipped) skipped.push_back(s.what + ": " + s.why);
  EXPECT_EQ(skipped, (std::vector<std::string>{"texture 'wood': only unused objects refer to it",
                                               "bsdf 'floor': nothing refers to it",
                                               "texture without id: nothing refers to it"}));
  EXPECT_EQ(std::count(stats.plugins.begin(), stats.plugins.end(), "texture/bitmap"), 0);
}

TEST(Scene, ErrorsInUnusedObjectsAreFound) {
  EXPECT_NE(unused_error("<texture type='bitmap' id='t'><string name='filename' value='a.exr'/>"
                         "<string name='wrap_mod' value='clamp'/></texture>")
                .find("has no parameter 'wrap_mod' (did you mean 'wrap_mode'?)"),
            std::string::npos);
  EXPECT_NE(unused_error("<texture type='bitmap'/>").find("needs parameter 'filename'"),
            std::string::npos);
  EXPECT_NE(unused_error("<texture type='bitmapp'/>").find("unknown texture plugin 'bitmapp'"),
            std::string::npos);
  EXPECT_NE(unused_error("<bsdf type='diffuse'><integer name='reflectance' value='x'/></bsdf>")
                .find("'x' is not an integer"),
            std::string::npos);
  EXPECT_NE(
      unused_error("<bsdf type='diffuse'><bsdf type='diffuse'/></bsdf>").find("takes no bsdf"),
      std::string::npos);
  EXPECT_NE(unused_error("<bsdf type='diffuse'><ref name='reflectance' id='no'/></bsdf>")
                .find("unknown id 'no'"),
            std::string::npos);
  EXPECT_NE(unused_error("<bsdf type='twosided' id='a'><bsdf type='twosided'><ref id='a'/></bsdf>"
                         "</bsdf>")
                .find("refers to an object that it is part of"),
            std::string::npos);
}

TEST(Stats, ReportTheCostOfLoading) {
  PluginRegistry registry({KINOME_UNIT_PLUGINS, KINOME_TEST_PLUGINS});
  RenderStats stats;
  load_scene_from_string(
      "<scene version='3.0.0'><shape type='sphere'/><shape type='sphere'/></scene>", "scene.xml",
      {}, registry, &stats);
  EXPECT_EQ(stats.plugins,
            (std::vector<std::string>{"shape/sphere", "bsdf/diffuse", "integrator/path",
                                      "sensor/perspective", "film/hdrfilm", "rfilter/gaussian",
                                      "sampler/independent"}));
  EXPECT_EQ(registry.loaded().size(), stats.plugins.size());
  EXPECT_GT(stats.load_seconds, stats.plugin_seconds);
  EXPECT_GT(stats.plugin_seconds, 0);
  EXPECT_GT(stats.build_seconds, 0);
}

}  // namespace
}  // namespace kinome::test
