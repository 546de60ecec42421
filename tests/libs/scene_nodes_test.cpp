#include <gtest/gtest.h>

#include <algorithm>
#include <clocale>

#include "kinome/sensor.h"
#include "libs/scene_values.h"
#include "support/plugins/probe_registry.h"

/// Tests transforms, old names, substitutions and references of scene files.
namespace kinome::test::scene_nodes_test {
namespace {

using namespace scene_values;

Transform transform_of(const std::string& operations) {
  return probe("<transform name='transform'>" + operations + "</transform>")->transform;
}

TEST(Transforms, SingleOperations) {
  EXPECT_TRUE(transform_of("").is_identity());
  EXPECT_EQ(transform_of("<translate value='1 2 3'/>").point(Vec3(1)), Vec3(2, 3, 4));
  EXPECT_EQ(transform_of("<translate y='2'/>").point(Vec3(1)), Vec3(1, 3, 1));
  EXPECT_EQ(transform_of("<scale value='2'/>").point(Vec3(1, 2, 3)), Vec3(2, 4, 6));
  EXPECT_EQ(transform_of("<scale value='2 3 4'/>").point(Vec3(1)), Vec3(2, 3, 4));
  EXPECT_EQ(transform_of("<scale y='3'/>").point(Vec3(1)), Vec3(1, 3, 1));
  expect_near(transform_of("<rotate z='1' angle='90'/>").vector(Vec3(1, 0, 0)), Vec3(0, 1, 0));
  expect_near(transform_of("<rotate value='0 5 0' angle='90'/>").vector(Vec3(1, 0, 0)),
              Vec3(0, 0, -1));
  EXPECT_EQ(transform_of("<matrix value='1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1'/>").point(Vec3(1)),
            Vec3(6, 7, 8));
  EXPECT_EQ(transform_of("<matrix value='0 -1 0 1 0 0 0 0 1'/>").vector(Vec3(1, 0, 0)),
            Vec3(0, 1, 0));
}

/// Kinome normalises such axes, unlike Mitsuba. Hence the warning.
TEST(Transforms, AxesOfAnotherLengthAreWarnedOf) {
  const auto warning_of = [](const std::string& axis) {
    testing::internal::CaptureStderr();
    const Transform t = transform_of("\n<rotate " + axis + " angle='35'/>");
    EXPECT_FALSE(t.has_scale());
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(warning_of("x='1'"), "");
  EXPECT_EQ(warning_of("x='.5774' y='.5774' z='-.5774'"), "");
  for (const char* axis : {"x='1' y='1'", "z='.9'", "value='0 -2 0'"}) {
    const std::string warning = warning_of(axis);
    EXPECT_NE(warning.find("warning: probe.xml:2:1: "), std::string::npos) << warning;
    EXPECT_NE(warning.find("axis of this rotation has length"), std::string::npos) << warning;
    EXPECT_EQ(std::count(warning.begin(), warning.end(), '\n'), 1) << warning;
  }
}

TEST(Transforms, LaterOperationsAreAppliedLater) {
  expect_near(
      transform_of("<translate x='1'/><rotate z='1' angle='90'/><scale value='2'/>").point(Vec3(0)),
      Vec3(0, 2, 0));
  expect_near(transform_of("<scale value='2'/><rotate z='1' angle='90'/><translate x='1'/>")
                  .point(Vec3(1, 0, 0)),
              Vec3(1, 2, 0));
}

TEST(Transforms, LookatHasTheViewAlongZAndLeftAlongX) {
  const Transform t = transform_of("<lookat origin='0 0 -5' target='0 0 0' up='0 1 0'/>");
  expect_near(t.point(Vec3(0)), Vec3(0, 0, -5));
  expect_near(t.vector(Vec3(0, 0, 1)), Vec3(0, 0, 1));
  expect_near(t.vector(Vec3(0, 1, 0)), Vec3(0, 1, 0));
  expect_near(t.vector(Vec3(1, 0, 0)), Vec3(1, 0, 0));
  EXPECT_FALSE(t.flips_handedness());
}

TEST(Transforms, LookatAsMitsubaWithoutUp) {
  // to_world of Mitsuba 3.9.1 for the same line, to the digits that it prints.
  const Transform t = transform_of("<lookat origin='1,2,3' target='0,0,0'/>");
  expect_near(t.vector(Vec3(1, 0, 0)), Vec3(-0.0792865f, 0.841427f, -0.534522f));
  expect_near(t.vector(Vec3(0, 1, 0)), Vec3(0.960357f, -0.0792865f, -0.267261f));
  expect_near(t.vector(Vec3(0, 0, 1)), Vec3(-0.267261f, -0.534522f, -0.801784f));
}

TEST(Upgrade, CamelCaseNamesBeforeVersion2) {
  const auto p = probe(
      "<transform name='Transform'><translate x='1'/></transform>"
      "<texture type='checkerboard' name='texture'><rgb name='color0' value='.1'/></texture>",
      {}, "0.6.0");
  EXPECT_EQ(p->transform.point(Vec3(0)), Vec3(1, 0, 0));
}

/// Reads a renamed parameter from a BSDF of an old file.
TEST(Upgrade, DiffuseReflectanceOfDiffuse) {
  const auto load = [](const std::string& version) {
    return load_object_from_string("<bsdf version='" + version +
                                       "' type='diffuse'><rgb name='diffuseReflectance' "
                                       "value='.1 .2 .3'/></bsdf>",
                                   "old.xml", {}, probe_registry());
  };
  const auto bsdf = std::dynamic_pointer_cast<Bsdf>(load("0.5.0"));
  EXPECT_EQ(bsdf->reflectance(SurfaceInteraction()).diffuse, Rgb(.1f, .2f, .3f));
  EXPECT_EQ(error_of([&] { load("2.0.0"); }),
            "old.xml:1:38: bsdf 'diffuse' has no parameter 'diffuseReflectance' (it has "
            "reflectance)");
}

/// Mitsuba 3.9.1 gives [[3, 0, .75], [0, 5, 2.5]] for this texture: it translates, then scales.
TEST(Upgrade, OffsetsAndScalesBecomeToUv) {
  const std::string old =
      "<float name='uoffset' value='.25'/><float name='voffset' value='.5'/>"
      "<float name='uscale' value='3'/><float name='vscale' value='5'/>";
  const auto p = std::dynamic_pointer_cast<Probe>(
      load_object_from_string("<texture version='0.6.0' type='uv_probe'>" + old + "</texture>",
                              "old.xml", {}, probe_registry()));
  expect_near(p->transform.point(Vec3(0)), Vec3(.75f, 2.5f, 0));
  expect_near(p->transform.vector(Vec3(1, 1, 0)), Vec3(3, 5, 0));
}

/// Colours in the notations of Mitsuba 0.6, and their values.
TEST(Upgrade, OldColours) {
  const auto color = [](const std::string& xml) { return probe(xml, {}, "0.6.0")->color; };
  expect_near(color("<rgb name='color' value='#ff8000'/>"), Rgb(1, 128 / 255.f, 0));
  expect_near(color("<srgb name='color' value='#Ff8000'/>"), Rgb(1, .2158605f, 0));
  expect_near(color("<srgb name='color' value='1, .5, 0'/>"), Rgb(1, .2140411f, 0));
  expect_near(color("<spectrum name='color' value='.5, .4, .3'/>"), Rgb(.5f, .4f, .3f));
  expect_near(color("<spectrum name='color' intent='illuminant' value='#ff0000'/>"), Rgb(1, 0, 0));
  const Rgb light = color("<blackbody name='color' temperature='5000K' scale='2'/>");
  EXPECT_NEAR(light.x / (2 * 15282.1f), 1, 0.01);
  EXPECT_EQ(error_of([&] { color("<srgb name='color' value='#ff80'/>"); }),
            "probe.xml:1:58: '#ff80' is not a colour such as '#ff8000'");
  EXPECT_NE(error_of([&] { probe("<srgb name='color' value='#ff8000'/>"); }), "no error");
}

TEST(Upgrade, OldNamesOfTagsAndParameters) {
  const auto load = [](const std::string& xml) {
    return load_object_from_string(xml, "old.xml", {}, probe_registry());
  };
  const auto sensor = std::dynamic_pointer_cast<Sensor>(
      load("<camera version='0.4.0' type='perspective'><transform name='toWorld'>"
           "<lookAt origin='0,0,1' target='0,0,0' up='0,1,0'/></transform>"
           "<sampler type='hammersley'><integer name='sampleCount' value='16'/>"
           "<integer name='scramble' value='-1'/></sampler>"
           "<film type='ldrfilm'><integer name='width' value='12'/>"
           "<string name='fileFormat' value='png'/><boolean name='banner' value='false'/>"
           "<boolean name='highQualityEdges' value='true'/></film></camera>"));
  EXPECT_EQ(sensor->film().width(), 12);
  EXPECT_TRUE(sensor->film().sample_border());
  EXPECT_EQ(sensor->sampler().sample_count(), 16u);
  EXPECT_EQ(sensor->sample_ray(Vec2(6, 288), Vec2(.5f)).o, Vec3(0, 0, 1));
  const auto integrator =
      load("<integrator version='0.6.0' type='bdpt'><integer name='maxDepth' value='5'/>"
           "<boolean name='lightImage' value='true'/></integrator>");
  EXPECT_EQ(integrator->plugin(), "integrator/path");
  load("<integrator version='0.6.0' type='path'><boolean name='strictNormals' value='true'/>"
       "</integrator>");
  // 0.2 + 0.3 + 0.5 of three colours.
  const auto mixture = std::dynamic_pointer_cast<Bsdf>(
      load("<bsdf version='0.6.0' type='mixturebsdf'><string name='weights' value='.2, .3, .5'/>"
           "<bsdf type='diffuse'><rgb name='reflectance' value='1 0 0'/></bsdf>"
           "<bsdf type='diffuse'><rgb name='reflectance' value='0 1 0'/></bsdf>"
           "<bsdf type='lambertian'><rgb name='reflectance' value='0 0 1'/></bsdf></bsdf>"));
  expect_near(mixture->reflectance(SurfaceInteraction()).diffuse, Rgb(.2f, .3f, .5f));
  EXPECT_NE(error_of([&] {
              load("<bsdf version='0.6.0' type='mixturebsdf'>"
                   "<string name='weights' value='.2, .3'/><bsdf type='diffuse'/></bsdf>");
            }).find("as many weights as BSDFs"),
            std::string::npos);
}

TEST(Expansion, SubstitutesTheLongestName) {
  LoadOptions options;
  options.defines = {{"a", "1"}, {"ab", "2"}, {"abc", "3"}};
  EXPECT_EQ(probe("<string name='string' value='$ab-$abc$a$abd'/>", options)->string, "2-312d");
}

TEST(Expansion, DefinesBeatDefaultsAndTheFirstDefaultStays) {
  const std::string xml =
      "<default name='x' value='first'/><default name='x' value='second'/>"
      "<string name='string' value='$x'/>";
  EXPECT_EQ(probe(xml)->string, "first");
  LoadOptions options;
  options.defines["x"] = "defined";
  EXPECT_EQ(probe(xml, options)->string, "defined");
}

TEST(Expansion, DefaultsMayUseOthers) {
  EXPECT_EQ(probe("<default name='x' value='1'/><default name='y' value='$x$x'/>"
                  "<string name='string' value='$y'/>")
                ->string,
            "11");
}

TEST(Expansion, DefaultsWorkInAnyAttribute) {
  EXPECT_EQ(probe("<default name='n' value='string'/><default name='t' value='probe'/>"
                  "<texture type='$t' name='texture'/><string name='$n' value='x'/>")
                ->string,
            "x");
}

TEST(Expansion, DollarsInADefineAreText) {
  LoadOptions options;
  options.defines["x"] = "a$b";
  EXPECT_EQ(probe("<string name='string' value='$x'/>", options)->string, "a$b");
}

TEST(References, ShareOneObject) {
  const auto p = probe(
      "<texture type='probe' name='texture' id='shared'/><ref id='shared' name='unbounded'/>");
  EXPECT_EQ(p->texture, p->unbounded);
}

TEST(References, MayPointForwardAndThroughAliases) {
  const auto p = probe(
      "<ref id='later' name='texture'/><texture type='probe' name='unbounded' id='later'/>"
      "<alias id='later' as='other'/><alias id='other' as='third'/>"
      "<ref id='third' name='optional'/>");
  EXPECT_EQ(p->texture, p->unbounded);
  EXPECT_EQ(p->optional, p->unbounded);
}

TEST(References, UnnamedOnesAreNumbered) {
  const auto p = probe("<bsdf type='diffuse' id='a'/><ref id='a'/>");
  ASSERT_EQ(p->objects.size(), 2u);
  EXPECT_EQ(p->objects[0], p->objects[1]);
}

}  // namespace
}  // namespace kinome::test::scene_nodes_test
