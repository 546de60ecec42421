// `clustered` with importance = product has the expectation of `direct`: z-tests over tiles of
// pixels and over the image, for each kind of material, emitter, camera, film and budget. Each
// z-test has a false-alarm rate of 1e-4.
#include <gtest/gtest.h>

#include <numeric>

#include "kinome/image_files.h"
#include "product_scenes.h"
#include "render/product/product_cases.h"

namespace kinome::test::product_test {
namespace {

using namespace product_cases;

/// Normals that are tilted by up to 40 degrees, texel by texel.
std::string normal_map(const std::string& nested) {
  const Vec3 normals[4] = {{.6f, 0, .8f}, {0, 0, 1}, {-.5f, -.3f, .8f}, {0, .6f, .8f}};
  Image image{8, 8, {"R", "G", "B"}, {}};
  for (int i = 0; i < 64; ++i) {
    const Vec3 colour = 0.5f * (glm::normalize(normals[(i + i / 8) % 4]) + 1.f);
    image.data.insert(image.data.end(), {colour.x, colour.y, colour.z});
  }
  const std::string path = folder().path("normals.exr");
  write_exr(path, image, ExrSampleType::kFloat, {});
  return bsdf("normalmap",
              "<texture name=\"normalmap\" type=\"bitmap\"><string name=\"filename\" value=\"" +
                  path + "\"/><boolean name=\"raw\" value=\"true\"/></texture>" + nested);
}
class Unbiased : public testing::TestWithParam<Case> {};
TEST_P(Unbiased, AsDirectIs) {
  expect_unbiased(GetParam().setup);
}

std::vector<Case> materials() {
  return {
      of_material("Diffuse", kGrey),
      of_material("Textured", bsdf("diffuse", checkerboard("reflectance"))),
      of_material("Twosided", bsdf("twosided", kGrey)),
      of_material("Phong", bsdf("phong", number("exponent", 40))),
      of_material("WardAnisotropic", bsdf("ward", number("alpha_u", .05) + number("alpha_v", .3))),
      of_material("RoughPlastic", bsdf("roughplastic", number("alpha", .1))),
      of_material("RoughPlasticTextured",
                  bsdf("roughplastic", number("alpha", .3) + checkerboard("diffuse_reflectance"))),
      of_material("SharpMetal", metal(.02), 16),
      of_material("SharpestMetal", metal(.0005), 16),
      of_material("WideMetal", metal(.4)),
      of_material("Mirror", bsdf("conductor"), 16),
      of_material("Plastic", bsdf("plastic")),
      of_material("NormalMap", normal_map(kGrey)),
      of_material("NormalMapOnPlastic", normal_map(bsdf("roughplastic", number("alpha", .2)))),
      of_material("NormalMapOnMetal", normal_map(metal(.1)), 8),
      of_material("NormalMapOnBothSides", bsdf("twosided", normal_map(kGrey))),
      // BSDFs without a form for kernels are evaluated point by point.
      of_material("TwoNormalMaps", normal_map(normal_map(kGrey))),
      of_material("TwoNormalMapsOnMetal", normal_map(normal_map(metal(.1))), 8),
  };
}
INSTANTIATE_TEST_SUITE_P(Materials, Unbiased, testing::ValuesIn(materials()),
                         [](const auto& c) { return std::string(c.param.name); });

std::vector<Case> lights() {
  const auto light = [](const char* name, const std::string& xml) {
    return with(name, [&](Arrangement& s) { s.light = xml; });
  };
  const auto one_texel = [](int x, int y) {
    return x == 12 && y == 5 ? Rgb(500, 300, 100) : Rgb(0.f);
  };
  const auto pole = [](int x, int y) {
    return y == 0 && x == 5 ? Rgb(900, 700, 500) : Rgb(0.1f, 0.2f, 0.3f);
  };
  const auto coarse = [](int x, int y) {
    return Rgb(0.3f + 0.5f * static_cast<float>(x), 0.2f + static_cast<float>(y * y), 1);
  };
  // Little noise, so that small errors of candidates' weights are visible.
  Case gradient = light("GradientOnMetal", map_xml("gradient", 32, 17, [](int x, int y) {
                          return Rgb(0.1f + 0.05f * static_cast<float>(y)) *
                                 (x < 16 ? Rgb(1, 0.9f, 0.8f) : Rgb(0.7f, 0.8f, 0.9f));
                        }));
  gradient.setup.shapes =
      "<shape type=\"sphere\"><float name=\"radius\" value=\"1.2\"/>" + metal(.3) + "</shape>";
  gradient.setup.rays = 32;
  gradient.setup.direct_samples = 64;
  Case texel = light("TexelOnMetal", map_xml("texel", 32, 17, one_texel));
  texel.setup.shapes =
      "<shape type=\"sphere\"><float name=\"radius\" value=\"1.2\"/>" + metal(.05) + "</shape>";
  texel.setup.rays = 32;
  texel.setup.direct_samples = 512;  // little noise: small errors of densities are visible
  return {
      gradient,
      texel,
      light("Constant", constant_xml("1 .8 .6")),
      light("OneLitTexel", map_xml("texel", 32, 17, one_texel)),
      light("SunAtThePole", map_xml("pole", 16, 9, pole)),
      light("Turned", map_xml("turned", 32, 17, harsh,
                              "<rotate x=\"1\" angle=\"40\"/><rotate y=\"1\" angle=\"70\"/>")),
      light("Map1x1", map_xml("1x1", 1, 1, coarse)),
      light("Map1x7", map_xml("1x7", 1, 7, coarse)),
      light("Map2x2", map_xml("2x2", 2, 2, coarse)),
      light("Map5x1", map_xml("5x1", 5, 1, coarse)),
      light("Faint", constant_xml("1e-20")),
      light("Glaring", constant_xml("1e15")),
  };
}
INSTANTIATE_TEST_SUITE_P(Lights, Unbiased, testing::ValuesIn(lights()),
                         [](const auto& c) { return std::string(c.param.name); });

std::vector<Case> settings() {
  std::vector<Case> all;
  const auto parameter = [&](const char* name, const std::string& xml) {
    all.push_back(with(name, [&](Arrangement& s) { s.parameters = xml; }));
  };
  const auto rays = [&](const char* name, double count) {
    all.push_back(with(name, [&](Arrangement& s) {
      s.rays = count;
      s.shapes = shapes_xml(bsdf("roughplastic", number("alpha", .1)));
    }));
  };
  parameter("NoControlVariate", off("control_variate"));
  parameter("NoLearnedSigma", off("learned_sigma"));
  parameter("NotAdaptive", off("adaptive"));
  parameter("NotCheckedSigma", off("checked_sigma"));
  parameter("NotSmoothed", off("smooth_plan"));
  parameter("NoHorizonTerms", off("horizon_terms"));
  parameter("NoFewerCells", off("fewer_cells"));
  parameter("NoSharedCandidates", off("shared_candidates"));
  parameter("NothingLearned", off("control_variate") + off("learned_sigma") + off("adaptive"));
  parameter("OneCell", integer("cut_size", 1));
  parameter("FewCells", integer("cut_size", 20));
  parameter("ManyCells", integer("cut_size", 100000));
  rays("Rays2", 2);
  rays("Rays3", 3);
  rays("Rays6", 6);
  rays("Rays48", 48);
  all.push_back(with("Huge", [](Arrangement& s) { s.scale = 1e4; }));
  all.push_back(with("Tiny", [](Arrangement& s) { s.scale = 1e-4; }));
  for (Case& c : all) {
    if (c.setup.scale == 1) continue;
    // The whole world is scaled; shapes are defined in its units.
    const std::string scale = "<scale value=\"" + std::to_string(c.setup.scale) + "\"/>";
    const auto in = [&](const std::string& before) {
      return "<shape type=\"" + before + "\"><transform name=\"to_world\">";
    };
    const std::string end = scale + "</transform>" + kGrey + "</shape>";
    c.setup.shapes = in("sphere") + "<scale value=\".7\"/><translate y=\".7\"/>" + end +
                     in("rectangle") + "<scale value=\"5\"/><rotate x=\"1\" angle=\"-90\"/>" + end;
  }
  return all;
}
INSTANTIATE_TEST_SUITE_P(Settings, Unbiased, testing::ValuesIn(settings()),
                         [](const auto& c) { return std::string(c.param.name); });

/// Films of direct are weighted means, whose bias falls with the number of samples.
std::vector<Case> cameras() {
  const auto film = [](const char* name, const std::string& xml, int samples = 16) {
    return with(name, [&](Arrangement& s) {
      s.film = xml;
      s.direct_samples = samples;
    });
  };
  const std::string size = integer("width", 16) + integer("height", 12);
  const std::string crop = integer("crop_offset_x", 5) + integer("crop_offset_y", 2) +
                           integer("crop_width", 9) + integer("crop_height", 7);
  const std::string border = "<boolean name=\"sample_border\" value=\"true\"/>";
  const auto filter = [](const char* type) {
    return "<rfilter type=\"" + std::string(type) + "\"/>";
  };
  std::vector<Case> all = {
      film("Gaussian", size + filter("gaussian"), 128),
      film("Tent", size + filter("tent"), 128),
      film("Mitchell", size + filter("mitchell"), 128),
      film("Lanczos", size + filter("lanczos"), 128),
      film("CropCatmullRom", size + crop + filter("catmullrom"), 128),
      film("Crop", size + crop + filter("box")),
      film("CropGaussian", size + crop + filter("gaussian"), 128),
      film("SmallCropGaussian",
           size + integer("crop_offset_x", 6) + integer("crop_offset_y", 5) +
               integer("crop_width", 3) + integer("crop_height", 2) +
               "<rfilter type=\"gaussian\">" + number("stddev", 1) + "</rfilter>",
           512),
      film("BorderGaussian", size + crop + border + filter("gaussian"), 128),
      film("OnePixel", integer("width", 1) + integer("height", 1) + filter("box"), 256),
      film("OnePixelGaussian", integer("width", 1) + integer("height", 1) + filter("gaussian"),
           4096),
      film("OnePixelLanczos", integer("width", 1) + integer("height", 1) + filter("lanczos"), 1024),
      film("TwoByOneLanczos", integer("width", 2) + integer("height", 1) + filter("lanczos"), 512),
      film("FiveByThree", integer("width", 5) + integer("height", 3) + filter("box"), 64),
      film("FiveByThreeOfFewRays",
           integer("width", 5) + integer("height", 3) + filter("box"), 64),
      film("Wide", integer("width", 61) + integer("height", 2) + filter("box")),
      film("Tall", integer("width", 2) + integer("height", 41) + filter("box")),
  };
  for (Case& c : all) {
    const std::string name = c.name;
    if (name == "OnePixelGaussian") {
      c.setup.light = constant_xml("1 .8 .6");  // little noise: positions of samples are visible
      c.setup.rays = 400;
    } else if (name == "FiveByThreeOfFewRays") {
      c.setup.rays = 6;  // the pilot probes squares that the border cuts
      c.setup = often(c.setup, 4);
    } else if (c.setup.film.find("\"width\" value=\"16") == std::string::npos ||
               name == "SmallCropGaussian") {
      c.setup.rays *= 16;  // few pixels: noise of direct is small there
    }
  }
  all.push_back(with("ThinLens", [](Arrangement& s) {
    s.sensor = "thinlens";
    s.optics += number("aperture_radius", .3) + number("focus_distance", 5);
  }));
  all.push_back(with("Orthographic", [](Arrangement& s) {
    s.sensor = "orthographic";
    s.optics = "";
  }));
  all.push_back(with("VisibleSky", [](Arrangement& s) {
    s.hide = false;
    s.light = constant_xml("1 .5 .25");
  }));
  return all;
}
INSTANTIATE_TEST_SUITE_P(Cameras, Unbiased, testing::ValuesIn(cameras()),
                         [](const auto& c) { return std::string(c.param.name); });

}  // namespace
}  // namespace kinome::test::product_test
