// Renders images with the plugins of tests/sdk/project, at least one of each category.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinome/image_files.h"
#include "kinome/instruction_set.h"
#include "sdk.h"
#include "sdk/examples.h"
#include "support/png.h"

namespace kinome::test::examples_test {
namespace {

using namespace examples;

/// A parameter of `clustered`.
const char* const kDirectLight = R"(<integer name="max_depth" value="2"/>)";

/// Returns the scene with another BSDF of the floor: `type`, with albedo .5 and k = 3.
std::string with_bsdf(std::string scene, const std::string& type) {
  const std::string old = R"(<bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf>)";
  return scene.replace(scene.find(old), old.size(),
                       "<bsdf type='" + type + "'><float name='k' value='3'/></bsdf>");
}

/// Closed form: under L = h + (z - h) cos theta, a floor of reflectance rho has the radiance
/// rho / pi (pi h + 2 pi / 3 (z - h)) = rho (h + 2/3 (z - h)).
TEST_F(Sdk, SkyGradientLightsAFloorAsDerived) {
  const std::string sky = R"(<emitter type="sky_gradient"><rgb name="zenith" value=".1 .4 2"/>
      <rgb name="horizon" value="1 .4 .5"/></emitter>)";
  const double zenith[3] = {.1, .4, 2};
  const double horizon[3] = {1, .4, .5};
  // direct: 16384 samples of uniform directions and cosine lobes by MIS. Each sample's standard
  // deviation is below the value itself, so that the mean's is below 1/128 of it. 5 of these give
  // false alarms of 6e-7. clustered adds the error of the points, about one cell.
  for (const char* integrator : {"direct", "clustered"}) {
    const std::string depth = std::string(integrator) == "direct" ? "" : kDirectLight;
    const Rgb mean = mean_of(render_text(floor_scene(integrator, sky, depth)));
    for (int c = 0; c < 3; ++c) {
      const double expected = .5 * (horizon[c] + 2. / 3 * (zenith[c] - horizon[c]));
      EXPECT_NEAR(mean[c], expected, expected * 5 / 128) << integrator << ", channel " << c;
    }
  }
}

/// Closed form: at a distance r from the point below a lamp of intensity I cos at height h, a floor
/// of reflectance rho has the radiance
/// rho / pi I h² / (h² + r²)².
TEST_F(Sdk, DownlightLightsAFloorAsDerived) {
  const double half = 3 * std::tan(10 * std::numbers::pi / 180);  // half of the visible width
  constexpr int kSteps = 64;
  double expected = 0;
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const double x = half * (2 * (i % kSteps + .5) / kSteps - 1);
    const double z = half * (2 * (i / kSteps + .5) / kSteps - 1);
    expected += .5 * std::numbers::inv_pi * 4 / std::pow(4 + x * x + z * z, 2) / (kSteps * kSteps);
  }
  // 16384 samples, each of which differs by less than 0.1 of the mean; 5 standard deviations of the
  // mean.
  for (const char* integrator : {"direct", "path", "clustered"}) {
    const std::string depth = std::string(integrator) == "direct" ? "" : kDirectLight;
    const Rgb mean =
        mean_of(render_text(floor_scene(integrator, "<emitter type='downlight'/>", depth)));
    EXPECT_NEAR(mean.x, expected, expected * 0.1 * 5 / 128) << integrator;
  }
}

/// The plugin's emitter divides the sky into cells: all stages of product sampling run. Nothing is
/// occluded, so that the control terms leave hardly any noise.
TEST_F(Sdk, SkyGradientIsSampledByItsCells) {
  const std::string sky = R"(<emitter type="sky_gradient"><rgb name="zenith" value=".1 .4 2"/>
      <rgb name="horizon" value="1 .4 .5"/></emitter>)";
  const std::string scene =
      folder_->write("cells.xml", floor_scene("clustered", sky, kDirectLight));
  const std::string image = folder_->path("cells.exr");
  const ProcessResult result = run_process(
      {program(), "-q", scene, "-o", image, "--plugin-path", plugins(), "--stats=json"});
  expect_success(result);
  for (const char* stage : {"\"cells\"", "\"pilot\"", "\"plan\"", "\"main\""}) {
    EXPECT_NE(result.out.find(stage), std::string::npos) << stage << result.out;
  }
  const Rgb mean = mean_of(read_exr(image));
  const double zenith[3] = {.1, .4, 2}, horizon[3] = {1, .4, .5};
  for (int c = 0; c < 3; ++c) {
    const double expected = .5 * (horizon[c] + 2. / 3 * (zenith[c] - horizon[c]));
    EXPECT_NEAR(mean[c], expected, expected * 2e-3) << c;
  }

  // Light after a bounce needs functions that this emitter lacks, which a message states.
  const std::string bounce = folder_->write("bounce.xml", floor_scene("clustered", sky));
  const ProcessResult deep =
      run_process({program(), bounce, "-o", image, "--plugin-path", plugins()});
  expect_success(deep);
  EXPECT_NE(deep.err.find("importance 'product' requires for reflected light"), std::string::npos)
      << deep.err;
}

/// The engine's stages give an integrator of another project the bits of `direct`.
TEST_F(Sdk, IntegratorOfStagesIsDirectLight) {
  const std::string source =
      read_text(std::string(KINOME_TEST_SOURCE) + "/tests/sdk/project/one_bounce.cpp");
  EXPECT_LE(std::count(source.begin(), source.end(), '\n'), 120);
  const std::string lights = R"(<emitter type="constant"/>
      <shape type="sphere">
        <point name="center" x="1" y="1" z="0"/> <float name="radius" value=".5"/>
        <emitter type="area"> <rgb name="radiance" value="7"/> </emitter> </shape>)";
  const Image ours = render_text(floor_scene("one_bounce", lights));
  const Image expected = render_text(floor_scene("direct", lights));
  ASSERT_EQ(ours.width, 16);
  EXPECT_GT(mean_of(expected).x, .5f);
  EXPECT_EQ(ours.data, expected.data);
}

/// Only the radiance of this sky is known. Every integrator and every importance of `clustered`
/// renders its light.
TEST_F(Sdk, SkyOfOneFunctionIsSupportedEverywhere) {
  // Irradiance on the floor, for a radiance of exp(-8 y): the integral of 2 pi y exp(-8 y) dy.
  const double irradiance = 2 * M_PI * (1 - 9 * std::exp(-8.)) / 64;
  const double expected = .5 * irradiance / M_PI;
  const std::string sky = "<emitter type='dawn'><rgb name='colour' value='1'/></emitter>";
  const std::string depth = R"(<integer name="max_depth" value="2"/>)";
  const auto importance = [&](const char* name) {
    return depth + R"(<string name="importance" value=")" + name + R"("/>)";
  };
  const struct {
    const char* integrator;
    std::string parameters;
    double tolerance;
  } cases[] = {
      {"direct", "", 0.02},
      {"path", depth, 0.02},
      {"ptracer", depth, 0.04},
      {"groundtruth", depth, 0.02},
      {"clustered", depth, 0.01},
      {"clustered", importance("joint"), 0.05},
      {"clustered", importance("luminance"), 0.05},
      {"clustered", importance("brdf"), 0.05},
      {"clustered", "", 0.02},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.integrator + c.parameters);
    std::string scene = floor_scene(c.integrator, sky, c.parameters);
    if (c.integrator == std::string("ptracer")) {
      // More light paths, and a floor that most of them hit where the camera sees it. The standard
      // deviation of the mean is some 0.7 %.
      scene = replaced(replaced(scene, "<scale value=\"10\"/>", "<scale value=\"0.6\"/>"),
                       "value=\"64\"", "value=\"1024\"");
    }
    EXPECT_NEAR(mean_of(render_text(scene)).x, expected, c.tolerance * expected);
  }
}

TEST_F(Sdk, IntegratorShowsNormals) {
  const Image image = render_text(floor_scene("normals", ""));
  ASSERT_EQ(image.width, 16);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      // n = (0, 1, 0) after a rotation by 90 degrees in floats: accurate within a few ulp.
      EXPECT_NEAR(image.at(x, y, 0), .5f, 1e-6f);
      EXPECT_NEAR(image.at(x, y, 1), 1.f, 1e-6f);
      EXPECT_NEAR(image.at(x, y, 2), .5f, 1e-6f);
    }
  }
}

/// A wide plugin is a library for each instruction set, under both of its names.
TEST_F(Sdk, WidePluginsAreBuiltForEachInstructionSet) {
  const auto sets = sets_built(fs::path(plugins()) / "texture", {"waves.so", "ripples.so"});
  // The program lists those that it may use.
  const std::string least = to_string(min_instruction_set());
  std::string list = "  built for " + least;
  for (const std::string& set : sets) {
    if (instruction_set_named(set) && *instruction_set_named(set) > min_instruction_set()) {
      list += ", " + set;
    }
  }
  std::vector<Image> images;
  for (const std::string& set : sets) {
    if (!is_usable(set)) continue;
    for (const char* name : {"waves", "ripples"}) {
      const ProcessResult result = run_process({"env", "COLUMNS=200", program(), "plugins", name,
                                                "--plugin-path", plugins(), "--isa", set});
      expect_success(result);
      EXPECT_NE(result.out.find("Waves, built for " + set + "."), std::string::npos) << result.out;
      if (sets.size() > 1) {
        EXPECT_NE(result.out.find(list + "\n"), std::string::npos) << result.out;
      }
    }
    const std::string reflectance = R"(<rgb name="reflectance" value=".5"/>)";
    std::string xml = floor_scene("direct", "<emitter type='constant'/>");
    xml.replace(xml.find(reflectance), reflectance.size(),
                "<texture name='reflectance' type='waves'/>");
    const std::string scene = folder_->write("waves.xml", xml);
    const std::string image = folder_->path("waves.exr");
    expect_success(run_process(
        {program(), "-q", scene, "-o", image, "--plugin-path", plugins(), "--isa", set}));
    images.push_back(read_exr(image));
    const Rgb mean = mean_of(images.back()), first = mean_of(images.front());
    EXPECT_NEAR(mean.x, first.x, 1e-4f * first.x) << set;
    // Whole vectors, and scalars in the baseline.
    for (int p = 0; p < 16 * 16; ++p) {
      const float expected = images.front().at(p % 16, p / 16, 0);
      EXPECT_NEAR(images.back().at(p % 16, p / 16, 0), expected, 1e-4f * expected) << set;
    }
  }
}

/// The same reflector twice: point by point, and as formulas for blocks.
TEST_F(Sdk, WideBsdfMatchesSinglePoints) {
  const std::string source =
      read_text(std::string(KINOME_TEST_SOURCE) + "/tests/sdk/project/wide_minnaert.cpp");
  EXPECT_LE(std::count(source.begin(), source.end(), '\n'), 60);  // as docs/writing-plugins.md says
  const fs::path folder = fs::path(plugins()) / "bsdf";
  EXPECT_FALSE(fs::exists(folder / to_string(InstructionSet::kX86V3) / "minnaert.so"));
  const std::string light = "<emitter type='constant'/>";
  const std::string bsdf_samples = R"(<integer name="emitter_samples" value="0"/>
      <integer name="bsdf_samples" value="1"/>)";
  // Under uniform radiance of 1: the mean of albedo cos_i^(k - 1), with k = 3.
  double expected = 0;
  for (int i = 0; i < 64 * 64; ++i) {
    const double side = std::tan(10 * M_PI / 180) / 32;
    const double u = side * (i % 64 - 31.5), v = side * (i / 64 - 31.5);
    expected += .5 / (1 + u * u + v * v) / (64 * 64);
  }
  for (const std::string& set : sets_built(folder, {"wide_minnaert.so"})) {
    if (!is_usable(set)) continue;
    const ProcessResult result =
        run_process({"env", "COLUMNS=200", program(), "plugins", "wide_minnaert", "--plugin-path",
                     plugins(), "--isa", set});
    expect_success(result);
    EXPECT_NE(result.out.find("Minnaert's reflector, for " + set + "\n"), std::string::npos)
        << result.out;
    for (const std::string& samples : {std::string(), bsdf_samples}) {
      const std::string scene = floor_scene("direct", light, samples);
      const Image points = render_text(with_bsdf(scene, "minnaert"), {"--isa", set});
      const Image wide = render_text(with_bsdf(scene, "wide_minnaert"), {"--isa", set});
      ASSERT_EQ(points.width, 16);
      ASSERT_EQ(wide.width, 16);
      for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
          // Formulas differ by a few ulp (6e-8), and by more near the horizon, where the light is
          // weaker.
          EXPECT_NEAR(wide.at(x, y, 0), points.at(x, y, 0), 1e-6f * points.at(x, y, 0)) << set;
        }
      }
      // All samples of the lobe have the same weight. Across a pixel, cos_i^2 has a standard
      // deviation below .2 %, and the mean of 16384 one of 1.6e-5, of which 5 are allowed. With
      // samples of the emitter, it is below 1/128, see SkyGradientLightsAFloorAsDerived.
      const double tolerance = samples.empty() ? 5. / 128 : 8e-5;
      EXPECT_NEAR(mean_of(wide).x, expected, expected * tolerance) << set << samples;
    }
  }
}

}  // namespace
}  // namespace kinome::test::examples_test
