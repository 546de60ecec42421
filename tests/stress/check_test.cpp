// Tests that the checks of the stress program find errors.
#include "check.h"

#include <gtest/gtest.h>

#include "support/render.h"
#include "xml.h"

namespace kinome::test {
namespace {

/// A floor below a lamp.
std::string small_scene(const std::string& bsdf = "diffuse") {
  return "<scene version=\"3.0.0\">\n"
         "<sensor type=\"perspective\">\n"
         "<transform name=\"to_world\"><lookat origin=\"0 0 4\" target=\"0 0 0\" up=\"0 1 0\"/>"
         "</transform><float name=\"fov\" value=\"40\"/>"
         "<sampler type=\"independent\"><integer name=\"sample_count\" value=\"1\"/></sampler>"
         "<film type=\"hdrfilm\"><integer name=\"width\" value=\"6\"/>"
         "<integer name=\"height\" value=\"5\"/><rfilter type=\"box\"/></film></sensor>\n"
         "<shape type=\"rectangle\"><bsdf type=\"" +
         bsdf +
         "\"/></shape>\n"
         "<emitter type=\"point\"><point name=\"position\" value=\"0.5 0 2\"/>"
         "<rgb name=\"intensity\" value=\"1 2 3\"/></emitter>\n"
         "</scene>\n";
}

const Method kDirect{"direct", xml::integrator("direct"), ""};
Method path(const std::string& name, const std::string& properties) {
  return {name, xml::integrator("path", properties), "direct"};
}

CheckReport check(const std::string& scene, bool is_valid, const std::vector<Method>& methods,
                  const CheckTask& with = {}) {
  const TemporaryFolder folder;
  CheckTask task = with;
  task.is_valid = is_valid;
  task.methods = methods;
  return check_scene(scene, folder.folder(), task);
}

/// A task with fewer renders, which suffice for black images and for light so rare that thousands
/// of renders leave it open, too.
CheckTask fewer_renders() {
  CheckTask task;
  task.repeated = {32, 128};
  return task;
}

TEST(Check, PassesCorrectRenders) {
  const CheckReport report =
      check(small_scene(), true, {kDirect, path("path", xml::integer("max_depth", 2))});
  EXPECT_TRUE(report.findings.empty()) << report.findings[0].text;
  EXPECT_EQ(report.refused, "");
  EXPECT_EQ(report.comparisons, 1);
  EXPECT_EQ(report.open, 0);
}

TEST(Check, FindsAMethodThatIsBlack) {
  // Shows only emitted light, and hides even that.
  const Method black =
      path("black", xml::integer("max_depth", 1) + xml::boolean("hide_emitters", true));
  const CheckReport report = check(small_scene(), true, {kDirect, black});
  EXPECT_EQ(report.comparisons, 1);
  EXPECT_EQ(report.open, 0);
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].kind, "differs");
  EXPECT_EQ(report.findings[0].method, "black");
}

TEST(Check, FindsAMethodThatIsBlackWhereItIsTheStandard) {
  Method black{"black", path("", xml::integer("max_depth", 1)).integrator, ""};
  Method direct = kDirect;
  direct.against = "black";
  const CheckReport report =
      check(small_scene("roughplastic"), true, {direct, black}, fewer_renders());
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].kind, "differs");
}

TEST(Check, FindsLightTracingThatIsBlackUnlessTheSceneIsVast) {
  const Method black = path("ptracer", xml::integer("max_depth", 1));
  std::string scene = small_scene();
  const CheckReport report = check(scene, true, {kDirect, black}, fewer_renders());
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].kind, "differs");
  scene.insert(scene.find("<emitter"),
               "<shape type=\"sphere\"><point name=\"center\" value=\"1e8 0 0\"/></shape>");
  const CheckReport vast = check(scene, true, {kDirect, black}, fewer_renders());
  EXPECT_TRUE(vast.findings.empty()) << vast.findings[0].text;
  EXPECT_EQ(vast.open, 1);
  // The same holds if the other's image has no noise at all.
  const size_t lamp = scene.find("<emitter");
  scene.replace(lamp, std::string::npos,
                "<emitter type=\"directional\"><vector name=\"direction\" value=\"0 0 -1\"/>"
                "</emitter></scene>");
  const CheckReport even = check(scene, true, {kDirect, black}, fewer_renders());
  EXPECT_TRUE(even.findings.empty()) << even.findings[0].text;
  EXPECT_EQ(even.open, 1);
}

TEST(Check, LeavesOpenLightThatCameraRaysHardlyHit) {
  const std::string disk_under_sky =
      "<shape type=\"disk\"><transform name=\"to_world\"><scale value=\"SIZE\"/></transform>"
      "</shape><emitter type=\"constant\"/></scene>";
  for (const bool is_speck : {true, false}) {
    std::string scene = small_scene();
    scene.replace(scene.find("<shape"), std::string::npos, disk_under_sky);
    scene.replace(scene.find("SIZE"), 4, is_speck ? "1e-6" : "1");
    const Method light{"ptracer", xml::integrator("ptracer", xml::integer("max_depth", 2)),
                       "black"};
    const Method black{"black", path("", xml::integer("max_depth", 1)).integrator, ""};
    const CheckReport report = check(scene, true, {light, black}, fewer_renders());
    EXPECT_EQ(report.comparisons, 1);
    EXPECT_EQ(report.refused, "");
    EXPECT_EQ(report.findings.size(), is_speck ? 0u : 1u);
    EXPECT_EQ(report.open, is_speck ? 1 : 0);
  }
}

TEST(Check, FindsPathsThatLackABounce) {
  const auto method = [](const char* name, int max_depth) {
    const std::string standard = "path, one bounce";
    return Method{name, path("", xml::integer("max_depth", max_depth)).integrator,
                  name == standard ? "" : standard};
  };
  // Whichever of them is too dark, and whatever the others estimate.
  for (const int bright : {0, 1}) {
    const CheckReport report =
        check(small_scene(), true,
              {method("path, one bounce", 2 - bright), method("product, one bounce", 1 + bright),
               method("ptracer, one bounce", 1 + bright)},
              fewer_renders());
    EXPECT_EQ(report.comparisons, 2);
    EXPECT_EQ(report.findings.size(), 2u);
    EXPECT_EQ(report.open, 0);
  }
}

TEST(Check, LeavesOpenLightThatOnePathInAMillionHits) {
  // A beam lights only a speck, which in turn lights the floor.
  const std::string beam =
      "<shape type=\"disk\"><transform name=\"to_world\"><scale value=\"0.004\"/>"
      "<rotate x=\"1\" angle=\"180\"/><translate z=\"3\"/></transform></shape>"
      "<emitter type=\"spot\"><transform name=\"to_world\">"
      "<lookat origin=\"0 0 1\" target=\"0 0 3\" up=\"0 1 0\"/></transform>"
      "<float name=\"cutoff_angle\" value=\"0.1\"/></emitter></scene>";
  std::string scene = small_scene();
  scene.replace(scene.find("<emitter"), std::string::npos, beam);
  const Method black{"path, one bounce", path("", xml::integer("max_depth", 1)).integrator, ""};
  const Method product{
      "product, one bounce",
      xml::integrator("clustered", xml::text("importance", "product") +
                                       xml::number("rays_per_pixel", kRaysPerPixel) +
                                       xml::boolean("trial", false) + xml::integer("max_depth", 3)),
      black.name};
  const CheckReport report = check(scene, true, {black, product}, fewer_renders());
  EXPECT_TRUE(report.findings.empty()) << report.findings[0].text;
  EXPECT_EQ(report.excuses.size(), 1u);
  EXPECT_EQ(report.open, 1);
}

/// small_scene() with a lamp of `intensity`, and a sun that a wall hides from the floor.
std::string scene_with_sun(const std::string& intensity, bool is_hidden) {
  std::string scene = small_scene();
  const auto change = [&](const std::string& from, const std::string& to) {
    scene.replace(scene.find(from), from.size(), to);
  };
  change("name=\"width\" value=\"6\"", "name=\"width\" value=\"14\"");
  change("1 2 3", intensity);
  const std::string place = is_hidden ? "-2.5" : "25";
  change("</scene>",
         "<emitter type=\"directional\"><vector name=\"direction\" value=\"1 0 -0.2\"/>"
         "</emitter><shape type=\"rectangle\"><transform name=\"to_world\">"
         "<scale value=\"9\"/><rotate y=\"1\" angle=\"90\"/><translate x=\"" +
             place + "\"/></transform></shape></scene>");
  return scene;
}

const Method kProduct{
    "product",
    xml::integrator("clustered", xml::text("importance", "product") +
                                     xml::number("rays_per_pixel", kRaysPerPixel) +
                                     xml::integer("max_depth", 2)),
    kDirect.name};

TEST(Check, LeavesOpenLightThatHiddenLightOutshines) {
  // `product` finds hardly any of the lamp's light.
  const CheckReport report =
      check(scene_with_sun("1e-9 2e-9 3e-9", true), true, {kDirect, kProduct});
  EXPECT_TRUE(report.findings.empty()) << report.findings[0].text;
  EXPECT_EQ(report.comparisons, 1);
  EXPECT_EQ(report.open, 1);
  ASSERT_EQ(report.excuses.size(), 1u);
  EXPECT_NE(report.excuses[0].find("beside hidden light"), std::string::npos) << report.excuses[0];
  // A lamp that is bright enough is found, and the results agree.
  const CheckReport bright =
      check(scene_with_sun("1e-2 2e-2 3e-2", true), true, {kDirect, kProduct});
  EXPECT_TRUE(bright.findings.empty()) << bright.findings[0].text;
  EXPECT_TRUE(bright.excuses.empty()) << bright.excuses[0];
  EXPECT_EQ(bright.comparisons, 1);
}

TEST(Check, FindsAProductThatIsBlackBesideBrightLight) {
  Method black =
      path("product", xml::integer("max_depth", 1) + xml::boolean("hide_emitters", true));
  // Hidden light that is less dominant, and light that isn't hidden.
  for (const std::string& scene :
       {scene_with_sun("1e-2 2e-2 3e-2", true), scene_with_sun("1e-9 2e-9 3e-9", false)}) {
    const CheckReport report = check(scene, true, {kDirect, black});
    ASSERT_EQ(report.findings.size(), 1u);
    EXPECT_EQ(report.findings[0].kind, "differs");
    EXPECT_EQ(report.findings[0].method, "product");
    EXPECT_TRUE(report.excuses.empty()) << report.excuses[0];
  }
}

TEST(Check, ExcusesOverflowOfSinglePrecision) {
  // Light whose flux includes the area of the whole scene.
  std::string scene = small_scene();
  const size_t lamp = scene.find("<emitter");
  scene.replace(lamp, std::string::npos,
                "<shape type=\"sphere\"><point name=\"center\" value=\"2e11 0 0\"/>"
                "<float name=\"radius\" value=\"1e11\"/></shape>"
                "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"RADIANCE\"/></emitter>"
                "</scene>");
  const std::string word = "RADIANCE";
  for (const bool is_vast : {true, false}) {
    std::string some = scene;
    some.replace(some.find(word), word.size(), is_vast ? "1e19" : "1");
    Method clustered{"joint, one bounce",
                     xml::integrator("clustered", xml::text("importance", "joint") +
                                                      xml::integer("max_depth", 3)),
                     ""};
    const CheckReport report = check(some, true, {kDirect, clustered, kProduct});
    EXPECT_TRUE(report.findings.empty()) << report.findings[0].text;
    EXPECT_EQ(report.excuses.size(), is_vast ? 1u : 0u);
  }
}

TEST(Check, FindsValidScenesThatAreRefused) {
  const std::string scene = small_scene("nothing_like_it");
  const CheckReport report = check(scene, true, {kDirect});
  EXPECT_NE(report.refused, "");
  ASSERT_EQ(report.findings.size(), 1u);
  EXPECT_EQ(report.findings[0].kind, "refused");
  EXPECT_EQ(report.findings[0].method, "load");
  // The same error is legitimate for an invalid scene.
  const CheckReport other = check(scene, false, {kDirect});
  EXPECT_EQ(reason_of(other.refused), reason_of(report.refused));
  EXPECT_TRUE(other.findings.empty());
}

TEST(Check, FindsScenesThatOneMethodRefuses) {
  for (const bool is_valid : {false, true}) {
    const Method fussy = path("fussy", xml::text("max_depth", "deep"));
    const CheckReport report = check(small_scene(), is_valid, {fussy, kDirect});
    EXPECT_EQ(report.refused, "");
    ASSERT_EQ(report.findings.size(), 1u);
    EXPECT_EQ(report.findings[0].kind, "refused");
    EXPECT_EQ(report.findings[0].method, "fussy");
  }
}

TEST(Check, ReasonsHaveNoPosition) {
  EXPECT_EQ(reason_of("/tmp/a-1/scene.xml:12:3: 'x' is 3: odd"), "'x' is 3: odd");
  EXPECT_EQ(reason_of("out of order"), "out of order");
}

}  // namespace
}  // namespace kinome::test
