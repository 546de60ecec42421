/// Media in scenes: which ones there are, their coefficients, and textures of volumes.
#include <gtest/gtest.h>

#include "kinome/interaction.h"
#include "kinome/log_listener.h"
#include "kinome/texture.h"
#include "support/render.h"
#include "support/volume_files.h"

namespace kinome::test::media_test {
namespace {

std::vector<std::string> warnings_of(const std::string& xml) {
  std::vector<std::string> warnings;
  const LogListener listener([&](const std::string& warning) { warnings.push_back(warning); });
  scene_from(xml);
  return warnings;
}

TEST(Media, OfASceneAreListedOnce) {
  const auto scene = scene_from(
      "<integrator type='direct'/><medium type='homogeneous' id='a'/><medium type='homogeneous' "
      "id='b'/><medium type='homogeneous' id='unused'/>"
      "<shape type='sphere'><ref name='interior' id='b'/><ref name='exterior' id='a'/></shape>"
      "<shape type='shapegroup' id='group'><shape type='cube'><medium name='interior' "
      "type='homogeneous' id='c'/></shape></shape><shape type='instance'><ref id='group'/></shape>"
      "<shape type='cube'/><sensor type='perspective'><ref id='a'/></sensor>");
  std::string ids;
  for (const Medium* const medium : scene->media()) ids += medium->id();
  EXPECT_EQ(ids, "abc");
  EXPECT_EQ(scene->sensors()[0]->medium(), scene->media()[0]);
  EXPECT_EQ(scene->sensors()[0]->with_sample_count(3)->medium(), scene->media()[0]);
  EXPECT_EQ(scene->shapes()[0]->interior(), scene->media()[1]);
  EXPECT_EQ(scene->shapes()[0]->exterior(), scene->media()[0]);
  EXPECT_EQ(scene->shapes()[1]->interior(), scene->media()[2]);
  EXPECT_FALSE(scene->shapes()[1]->exterior());
  EXPECT_FALSE(scene->shapes()[2]->separates_media());
}

TEST(Media, ThatTheIntegratorIgnoresGiveOneWarning) {
  const std::string fog =
      "<shape type='sphere'><medium type='homogeneous' name='interior'/></shape>";
  const std::string ignored = "the scene's media are ignored";
  for (const char* integrator : {"direct", "path"}) {
    const auto warnings =
        warnings_of("<integrator type='" + std::string(integrator) + "'/>" + fog + fog);
    ASSERT_EQ(warnings.size(), 1u) << integrator;
    EXPECT_NE(warnings[0].find(ignored), std::string::npos) << warnings[0];
  }
  EXPECT_TRUE(
      warnings_of("<integrator type='direct'/><medium type='homogeneous' id='a'/>").empty());
  const auto warnings = warnings_of(
      "<integrator type='direct'/><medium type='homogeneous' id='a'/><emitter type='constant'><ref "
      "id='a'/></emitter>");
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("emitter 'constant': 'medium' is ignored"), std::string::npos);
}

/// A heterogeneous medium ends at the box of sigma_t, and scale has no effect on the albedo.
TEST(Media, CoefficientsAreExtinctionTimesAlbedo) {
  const TemporaryFolder folder;
  const std::string grid = "type='gridvolume'><string name='filename' value='" +
                           folder.write("a.vol", VolFile().bytes(mixed_value)) + "'/></volume>";
  const auto volume = make<Volume>("<volume " + grid);
  const auto medium = make<Medium>(
      "<medium type='heterogeneous'><float name='scale' value='3'/>"
      "<volume name='albedo' " +
      grid + "<volume name='sigma_t' " + grid + "</medium>");
  const Vec3 p(0.3f, 0.6f, 0.2f);
  const MediumCoefficients at = medium->coefficients(p, Vec3(0, 0, 1));
  const Rgb value = volume->color(p);
  EXPECT_LT(glm::length(at.extinction - 3.f * value), 1e-6f);
  EXPECT_LT(glm::length(at.scattering - 3.f * value * value), 1e-6f);
  EXPECT_TRUE(medium->is_coloured());
  EXPECT_FALSE(medium->is_uniform());
  EXPECT_EQ(medium->coefficients(Vec3(0.3f, 1.01f, 0.2f), {}).extinction, Rgb(0.f));
  EXPECT_EQ(medium->box().hi, Vec3(1.f));

  const auto constant = make<Medium>(
      "<medium type='heterogeneous'><volume name='sigma_t' type='constvolume'><float name='value' "
      "value='5'/><transform name='to_world'><scale value='2'/></transform></volume></medium>");
  EXPECT_EQ(constant->box().hi, Vec3(2.f));
  EXPECT_EQ(constant->max_extinction(), 5);
  EXPECT_FALSE(constant->is_coloured());

  const auto grey = make<Medium>(
      "<medium type='homogeneous'><texture type='uniform' name='sigma_t'><float name='value' "
      "value='5'/></texture><spectrum name='albedo' value='0.5'/></medium>");
  EXPECT_EQ(grey->coefficients(p, {}).extinction, Rgb(5.f));
  EXPECT_EQ(grey->coefficients(p, {}).scattering, Rgb(2.5f));

  const auto milk = make<Medium>("<medium type='homogeneous'><volume name='albedo' " + grid +
                                 "<float name='sigma_t' value='7'/></medium>");
  EXPECT_LT(glm::length(milk->coefficients(p, {}).scattering - 7.f * value), 1e-5f);
  EXPECT_EQ(milk->min_extinction(), 7);
  EXPECT_FALSE(milk->is_uniform());
  try {
    make_object("<medium type='homogeneous'><volume name='sigma_t' " + grid + "</medium>");
    ADD_FAILURE() << "homogeneous with a grid";
  } catch (const Error& error) {
    EXPECT_NE(error.message().find("'sigma_t' must be uniform, got a volume that varies"),
              std::string::npos)
        << error.message();
  }
}

TEST(Media, ErrorsNameTheVoxelAndItsFile) {
  const TemporaryFolder folder;
  const auto grid = [&](float low, float high) {
    return folder.write("a.vol", VolFile{.x = 4, .y = 3, .z = 2, .channels = 1}.bytes([=](int i) {
      return i == 17 ? low : i == 6 ? high : 0.5f;
    }));
  };
  const auto error_with = [](const std::string& parameter, const std::string& file) {
    try {
      make_object("<medium type='heterogeneous'><volume type='gridvolume' name='" + parameter +
                  "'><string name='filename' value='" + file + "'/></volume></medium>");
    } catch (const Error& error) {
      return error.message();
    }
    return std::string("no error");
  };
  const std::string file = grid(-1, 2);
  EXPECT_EQ(error_with("sigma_t", file),
            "'sigma_t' must not be negative, got -1 in voxel (1, 1, 1) of " + file);
  grid(0, 2);
  EXPECT_EQ(error_with("albedo", file),
            "'albedo' must be at most 1, got 2 in voxel (2, 1, 0) of " + file);
  grid(0, 1);
  EXPECT_EQ(error_with("albedo", file), "no error");
}

TEST(Blends, WarnOfWeightsThatAreClamped) {
  const auto warnings_with = [](const std::string& tag, const std::string& nested, float weight) {
    std::vector<std::string> warnings;
    const LogListener listener([&](const std::string& warning) { warnings.push_back(warning); });
    const std::string part = "<" + tag + " type='" + nested + "'/>";
    make_object("<" + tag + " type='blend" + tag + "'><float name='weight' value='" +
                std::to_string(weight) + "'/>" + part + part + "</" + tag + ">");
    return warnings;
  };
  for (const auto& [tag, nested] : {std::pair("phase", "hg"), std::pair("bsdf", "diffuse")}) {
    for (const float weight : {0.f, 0.3f, 1.f}) {
      EXPECT_TRUE(warnings_with(tag, nested, weight).empty()) << tag << weight;
    }
    for (const float weight : {-0.5f, 1.5f}) {
      const auto warnings = warnings_with(tag, nested, weight);
      ASSERT_EQ(warnings.size(), 1u) << tag << weight;
      EXPECT_NE(warnings[0].find("'weight' has values outside [0,1], which are clamped: from " +
                                 format_number(weight) + " to " + format_number(weight)),
                std::string::npos)
          << warnings[0];
    }
  }
}

TEST(VolumeTexture, IsTheVolumeAtThePoint) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.vol", VolFile().bytes(mixed_value));
  const std::string xml =
      "<volume name='volume' type='gridvolume'><string name='filename' value='" + file +
      "'/></volume>";
  const auto volume = make<Volume>(xml);
  const auto texture = make<Texture>("<texture type='volume'>" + xml + "</texture>");
  SurfaceInteraction si;
  si.p = Vec3(0.4f, 0.7f, 0.6f);
  EXPECT_EQ(texture->eval_at(si), volume->color(si.p));
  EXPECT_FLOAT_EQ(texture->eval_1_at(si), luminance(volume->color(si.p)));
  EXPECT_EQ(texture->eval(Vec2(0.1f)), volume->color(Vec3(0.5f)));
}

}  // namespace
}  // namespace kinome::test::media_test
