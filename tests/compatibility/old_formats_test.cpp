/// Files of Mitsuba 0.4 to 0.6: parameters, units, axes and defaults of these versions.
#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "compatibility/old_formats.h"
#include "kinome/bsdf.h"
#include "kinome/emitter.h"
#include "kinome/log_listener.h"
#include "kinome/sensor.h"
#include "kinome/texture.h"
#include "support/render.h"

namespace kinome::test::old_formats_test {
namespace {

using namespace old_formats;

TEST(OldFormats, UnusedParametersWarn) {
  const std::string warning = warnings_of(
      "<bsdf type='roughplastic'><float name='alpah' value='0.1'/></bsdf>");
  EXPECT_NE(warning.find("bsdf 'roughplastic' has no parameter 'alpah', which is ignored (did you "
                         "mean 'alpha'?)"),
            std::string::npos)
      << warning;
  const std::string film = "<film type='hdrfilm'><float name='gamma' value='2.2'/></film>";
  EXPECT_NE(warnings_of(film).find("'gamma'"), std::string::npos);
  EXPECT_THROW(object_of<Object>(film, "3.0.0"), Error);
  // The same holds for the scene itself.
  EXPECT_NO_THROW(old_scene("<integer name='some' value='1'/><shape type='sphere'/>"));
}

TEST(OldFormats, TheLastOfTwoValuesCounts) {
  const auto texture = old<Texture>(
      "<texture type='checkerboard'><float name='color0' value='0'/>"
      "<float name='color1' value='.3'/><float name='color1' value='.5'/></texture>");
  expect_near(texture->mean(), Rgb(.25f));
}

/// +y is up; the sun is in the south-west of Tokyo at 3 PM: east is +x, north -z.
TEST(OldFormats, TheSunHasTheDirectionOfMitsuba06) {
  const auto sun = old<Emitter>("<emitter type='sun'/>");
  const auto sample = sun->sample_direct(Vec3(0), Vec2(.5f));
  ASSERT_TRUE(sample);
  EXPECT_LT(sample->d.x, -.6f);
  EXPECT_GT(sample->d.y, .5f);
  EXPECT_GT(sample->d.z, 0);
  EXPECT_LT(sample->d.z, .4f);
  const auto given =
      old<Emitter>("<emitter type='sun'><vector name='sunDirection' x='.3' y='.8' z='.5'/></emitter>");
  const Vec3 d = given->sample_direct(Vec3(0), Vec2(.5f))->d;
  EXPECT_GT(glm::dot(d, glm::normalize(Vec3(.3f, .8f, .5f))), .9999f);
}

/// The same sky as Mitsuba 3's, except for the axes and the ground's albedo.
TEST(OldFormats, TheSkyIsTurned) {
  const auto turned = old<Emitter>("<emitter type='sky'/>");
  const auto sky = object_of<Emitter>(
      "<emitter type='sunsky'><float name='albedo' value='.15'/><float name='sun_scale' value='0'/>"
      "</emitter>",
      "3.0.0");
  for (const Vec3& v : {Vec3(.1f, .2f, .9f), Vec3(-.7f, .2f, .4f), Vec3(.3f, -.8f, .2f)}) {
    const Vec3 d = glm::normalize(v);
    const Rgb value = sky->eval_environment(d);
    EXPECT_GT(value.x, 0);
    expect_near(turned->eval_environment(Vec3(-d.y, d.z, d.x)), value, 1e-5f);
  }
  EXPECT_EQ(turned->eval_environment(Vec3(0, -1, 0)), Rgb(0.f));
}

TEST(OldFormats, ScalesOfTheSun) {
  const auto irradiance = [](const std::string& parameters) {
    const auto sun = old<Emitter>("<emitter type='sun'>" + parameters + "</emitter>");
    const auto sample = sun->sample_direct(Vec3(0), Vec2(.5f));
    return sample->radiance / sample->pdf;
  };
  const Rgb one = irradiance("");
  EXPECT_GT(one.y, 0);
  const auto expect_times = [&](float factor, const std::string& parameters) {
    const Rgb value = irradiance(parameters);
    expect_near(value / (factor * one), Rgb(1.f), 1e-3f);
  };
  expect_times(1, "<float name='sunRadiusScale' value='15'/>");
  expect_times(1, "<float name='sunRadiusScale' value='0'/>");
  expect_times(.1f, "<float name='scale' value='.1'/>");
  const auto both = old<Emitter>("<emitter type='sunsky'/>");
  const auto tenth = old<Emitter>(
      "<emitter type='sunsky'><float name='scale' value='.1'/><integer name='resolution' "
      "value='512'/></emitter>");
  expect_near(tenth->eval_environment(Vec3(0, 1, 0)), .1f * both->eval_environment(Vec3(0, 1, 0)));
}

/// A single number is grey, also as light; Mitsuba 3 reads it as a spectrum.
TEST(OldFormats, ConstantSpectraAreGrey) {
  const auto lamp = old<Emitter>(
      "<emitter type='constant'><spectrum name='radiance' value='2'/></emitter>");
  expect_near(lamp->eval_environment(Vec3(0, 0, 1)), Rgb(2.f));
}

TEST(OldFormats, ReflectancesAboveOneAreScaled) {
  const auto bsdf = old<Bsdf>(
      "<bsdf type='diffuse'><rgb name='reflectance' value='2 1 0'/></bsdf>");
  expect_near(bsdf->reflectance(seen_from(Vec3(0, 0, 1))).diffuse, Rgb(.99f, .495f, 0));
}

TEST(OldFormats, UndefinedFieldsWarn) {
  const auto field = [](const std::string& undefined) {
    return warnings_of("<integrator type='field'><string name='field' value='distance'/>" +
                       undefined + "</integrator>");
  };
  EXPECT_NE(field("<float name='undefined' value='-1'/>").find("'undefined'"), std::string::npos);
  EXPECT_EQ(field("<float name='undefined' value='0'/>"), "");
}

/// Names in capital letters only, which aren't camel case.
TEST(OldFormats, CapitalLetters) {
  const auto at_centre = [](const std::string& version, const std::string& parameters) {
    return object_of<ReconstructionFilter>("<rfilter type='mitchell'>" + parameters + "</rfilter>",
                                           version)
        ->eval(0.f);
  };
  const std::string parameters = "<float name='B' value='.9'/><float name='C' value='.1'/>";
  EXPECT_FLOAT_EQ(at_centre("0.6.0", parameters), at_centre("3.0.0", parameters));
  EXPECT_NE(at_centre("0.6.0", parameters), at_centre("0.6.0", ""));
}

/// Elements that only old files have.
TEST(OldFormats, OtherElements) {
  const auto scene = old_scene(
      "<shape type='sphere'><subsurface type='dipole'/><animation name='toWorld'>"
      "<transform time='0'><translate x='3'/></transform>"
      "<transform time='1'><translate x='5'/></transform></animation></shape>");
  EXPECT_FLOAT_EQ(scene->bounds().lo.x, 2);
}

TEST(OldFormats, LenientlyUnknownPluginsAreLeftOut) {
  const std::string xml =
      "<integrator type='sorcery'><integer name='maxDepth' value='3'/></integrator>"
      "<bsdf type='irawan' id='cloth'/><shape type='sphere'><ref id='cloth'/></shape>"
      "<shape type='heightfield'/><medium type='smoke' id='fog'/>";
  EXPECT_THROW(old_scene(xml), Error);
  LoadOptions options;
  options.lenient = true;
  const auto scene = old_scene(xml, options);
  EXPECT_EQ(scene->shapes().size(), 1u);
  EXPECT_EQ(scene->integrator().plugin(), "integrator/path");
}

/// Objects that need an omitted object are reduced, or omitted, too.
TEST(OldFormats, LenientlyParentsAreReduced) {
  LoadOptions options;
  options.lenient = true;
  const auto bsdf_of = [&](const std::string& bsdf, const std::string& before = "") {
    const auto scene =
        old_scene(before + "<shape type='sphere'>" + bsdf + "</shape>", options);
    return std::pair(scene->shapes().at(0)->bsdf().plugin(),
                     scene->shapes().at(0)->bsdf().reflectance(seen_from(Vec3(0, 0, 1))).diffuse);
  };
  const std::string grey = "<bsdf type='diffuse'><float name='reflectance' value='.2'/></bsdf>";
  const std::string white = "<bsdf type='diffuse'><float name='reflectance' value='.8'/></bsdf>";
  const auto expect_bsdf = [&](const auto& bsdf, const std::string& plugin, float reflectance) {
    EXPECT_EQ(bsdf.first, plugin);
    expect_near(bsdf.second, Rgb(reflectance));
  };
  expect_bsdf(bsdf_of("<bsdf type='bumpmap'><texture type='sorcery'/>" + grey + "</bsdf>"),
              "bsdf/diffuse", .2f);
  expect_bsdf(bsdf_of("<bsdf type='bumpmap'><texture type='scale'><texture type='sorcery'/>"
                      "</texture>" + grey + "</bsdf>"),
              "bsdf/diffuse", .2f);
  expect_bsdf(bsdf_of("<bsdf type='normalmap'><texture name='normalmap' type='sorcery'/>" + grey +
                      "</bsdf>"),
              "bsdf/diffuse", .2f);
  expect_bsdf(bsdf_of("<bsdf type='blendbsdf'><texture name='weight' type='sorcery'/>" + grey +
                      white + "</bsdf>"),
              "bsdf/blendbsdf", .5f);
  expect_bsdf(bsdf_of("<bsdf type='diffuse'><texture type='scale' name='reflectance'>"
                      "<texture type='sorcery'/></texture></bsdf>"),
              "bsdf/diffuse", .5f);
  // With references, whose names remain valid.
  const std::string texture = "<texture type='sorcery' id='t'/>";
  const std::string named = "<bsdf type='diffuse' id='d'><float name='reflectance' value='.2'/>"
                            "</bsdf>";
  expect_bsdf(bsdf_of("<ref id='b'/>", texture + named +
                                           "<bsdf type='bumpmap' id='b'><ref id='t'/><ref id='d'/>"
                                           "</bsdf>"),
              "bsdf/diffuse", .2f);
  expect_bsdf(bsdf_of("<ref id='b'/>",
                      texture + "<bsdf type='bumpmap' id='b'><ref id='t'/>" + grey + "</bsdf>"),
              "bsdf/diffuse", .2f);
  // Cycles remain errors.
  EXPECT_THROW(bsdf_of("<ref id='b'/>", "<bsdf type='bumpmap' id='b'><texture type='sorcery'/>"
                                        "<ref id='b'/></bsdf>"),
               Error);
  EXPECT_THROW(bsdf_of("<ref id='a'/>", texture + "<bsdf type='bumpmap' id='a'><ref id='t'/>"
                                                  "<ref id='b'/></bsdf><bsdf type='bumpmap' id='b'>"
                                                  "<ref id='t'/><ref id='a'/></bsdf>"),
               Error);
  const auto shapes = [&](const std::string& xml) {
    return old_scene("<shape type='sphere'/>" + xml, options)->shapes().size();
  };
  EXPECT_EQ(shapes("<shape type='sorcery' id='g'/><shape type='instance'><ref id='g'/></shape>"),
            1u);
  EXPECT_EQ(shapes("<shape type='sphere'><sensor type='sorcery'/></shape>"), 2u);
}

}  // namespace
}  // namespace kinome::test::old_formats_test
