// Renders images with the plugins of tests/sdk/project, at least one of each category.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kinome/image_files.h"
#include "kinome/instruction_set.h"
#include "sdk.h"
#include "support/png.h"

namespace kinome::test::examples_test {
namespace {

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

/// Returns the text with one part replaced.
std::string replaced(std::string text, const std::string& part, const std::string& by) {
  const size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return at == std::string::npos ? text : text.replace(at, part.size(), by);
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

/// Returns the instruction sets of the libraries in `folder`, each of which must contain `names`.
std::vector<std::string> sets_built(const fs::path& folder, const std::vector<std::string>& names) {
  std::vector<std::string> sets = {
      instruction_set_named("x86-64-v2") ? "x86-64-v2" : to_string(least_instruction_set())};
  for (int i = 2; i < kInstructionSetCount; ++i) {
    const char* set = to_string(static_cast<InstructionSet>(i));
    if (!fs::exists(folder / set)) continue;
    for (const std::string& name : names) EXPECT_TRUE(fs::exists(folder / set / name)) << set;
    sets.emplace_back(set);
  }
  return sets;
}

/// True if the program may use plugins for this set on this machine.
bool is_usable(const std::string& set) {
  const auto known = instruction_set_named(set);
  return known && *known >= least_instruction_set() && *known <= processor_instruction_set();
}

/// A wide plugin is a library for each instruction set, under both of its names.
TEST_F(Sdk, WidePluginsAreBuiltForEachInstructionSet) {
  const auto sets = sets_built(fs::path(plugins()) / "texture", {"waves.so", "ripples.so"});
  // The program lists those that it may use.
  const std::string least = to_string(least_instruction_set());
  std::string list = "  built for " + least;
  for (const std::string& set : sets) {
    if (instruction_set_named(set) && *instruction_set_named(set) > least_instruction_set()) {
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
TEST_F(Sdk, WideBsdfShowsWhatPointsDo) {
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
    EXPECT_NE(result.out.find("Minnaert's, for " + set + "\n"), std::string::npos) << result.out;
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

/// Returns a scene of 16 x 16 pixels with the named sensor and its contents.
std::string scene_of(const std::string& integrator, const std::string& sensor,
                     const std::string& inside, const std::string& rfilter = "box",
                     int samples = 64) {
  return "<scene version='3.0.0'><integrator type='" + integrator + "'/><sensor type=" + sensor +
         "<sampler type='independent'><integer name='sample_count' value='" +
         std::to_string(samples) +
         "'/></sampler><film type='hdrfilm'><integer name='width' value='16'/>"
         "<integer name='height' value='16'/><string name='component_format' value='float32'/>"
         "<rfilter type='" +
         rfilter + "'/></film></sensor>" + inside + "</scene>";
}

const char* const kSky = R"(<emitter type="sky_gradient"><rgb name="zenith" value="2"/>
    <rgb name="horizon" value="1"/></emitter>)";

/// Stratified numbers leave less noise than independent ones, with the same mean.
TEST_F(Sdk, SamplerSpreadsItsNumbers) {
  const std::string scene = floor_scene("direct", kSky);
  const double expected = .5 * (1 + 2. / 3);
  double errors[2] = {0, 0};
  const Image images[] = {
      render_text(scene),
      render_text(replaced(scene, "<sampler type=\"independent\">", "<sampler type=\"golden\">"))};
  for (int i = 0; i < 2; ++i) {
    ASSERT_EQ(images[i].width, 16);
    // As in SkyGradientLightsAFloorAsDerived.
    EXPECT_NEAR(mean_of(images[i]).x, expected, expected * 5 / 128);
    for (int p = 0; p < 16 * 16; ++p) {
      errors[i] += std::pow(images[i].at(p % 16, p / 16, 0) - expected, 2);
    }
  }
  EXPECT_LT(errors[1], errors[0] / 4);
}

/// The sky by the camera's formula: each pixel's value is between those of its positions.
TEST_F(Sdk, SensorSeesAllOfTheSky) {
  for (const bool looks_up : {true, false}) {
    const std::string to_world =
        looks_up ? "<transform name='to_world'><lookat origin='0 0 0' target='0 1 0' up='0 0 1'/>"
                   "</transform>"
                 : "";
    const Image image = render_text(scene_of("direct", "'fisheye'>" + to_world, kSky));
    ASSERT_EQ(image.width, 16);
    for (int p = 0; p < 16 * 16; ++p) {
      double low = 2, high = 1;
      for (int k = 0; k < 9 * 9; ++k) {
        const double x = p % 16 - 8 + k % 9 / 8., y = p / 16 - 8 + k / 9 / 8.;
        const double r = std::hypot(x, y), angle = r * M_PI / 16;
        const double up = looks_up ? std::cos(angle) : r > 0 ? -std::sin(angle) * y / r : 0;
        low = std::min(low, 1 + std::max(up, 0.));
        high = std::max(high, 1 + std::max(up, 0.));
      }
      // Between the 81 positions, the sky may slightly exceed their range.
      EXPECT_GE(image.at(p % 16, p / 16, 0), low - 1e-3) << p;
      EXPECT_LE(image.at(p % 16, p / 16, 0), high + 1e-3) << p;
    }
  }
}

/// The ring seen directly, and lighting a ceiling that is visible through its hole. Closed form:
/// under a ring of radiance 1 with radii a < b, at distance h from its centre, irradiance is
/// pi (b² / (b² + h²) - a² / (a² + h²)).
TEST_F(Sdk, ShapeIsSeenAndShines) {
  const std::string ring = R"(<shape type="ring"><float name="radius" value=".8"/>
      <float name="inner" value=".4"/>)";
  const std::string above =
      "<transform name='to_world'><lookat origin='0 0 3' target='0 0 0' up='0 1 0'/></transform>";
  const Rgb seen =
      mean_of(render_text(scene_of("normals", "'orthographic'>" + above, ring + "</shape>")));
  // Fraction of 16384 rays in an image of area 4, with a standard deviation of .0038.
  const double share = M_PI * (.64 - .16) / 4;
  EXPECT_NEAR(seen.z, share, 5 * .0038);
  EXPECT_NEAR(seen.x, share / 2, 5 * .0019);

  const std::string below =
      "<float name='fov' value='2'/><transform name='to_world'>"
      "<lookat origin='0 0 -3' target='0 0 1' up='0 1 0'/></transform>";
  const std::string ceiling =
      R"(<shape type="rectangle"><transform name="to_world"><rotate x="1" angle="180"/>
      <scale value="4"/><translate z="1"/></transform>
      <bsdf type="diffuse"><rgb name="reflectance" value=".5"/></bsdf></shape>)";
  const Rgb lit = mean_of(render_text(scene_of(
      "direct", "'perspective'>" + below,
      ring + "<emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>" + ceiling)));
  const double expected = .5 * (.64 / 1.64 - .16 / 1.16);
  // Samples vary by less than their mean. The mean is over points up to .1 from the axis, which
  // differ by less than 1 %.
  EXPECT_NEAR(lit.x, expected, expected * (5. / 128 + .01));

  // The ring also reflects light of other plugins here: with 'joint', by light points on it.
  const std::string under_sky = ring + "</shape>" + ceiling + "<emitter type='sky_gradient'/>";
  const Rgb direct = mean_of(render_text(scene_of("direct", "'perspective'>" + below, under_sky)));
  const Rgb bounced =
      mean_of(render_text(scene_of("clustered", "'perspective'>" + below, under_sky)));
  // The ring sees only the fraction 1/17 of the sky that is beside the ceiling, and is .25 of what
  // the ceiling sees. It therefore adds less than .25 x .5 / 17. Both values vary as above, with a
  // standard deviation below their mean.
  EXPECT_NEAR(bounced.x, direct.x, direct.x * (.25 * .5 / 17 + 5 * std::sqrt(2.) / 128));
}

/// With each instruction set, a constant image stays constant, and an edge becomes the window's
/// integral.
TEST_F(Sdk, FilterBlursAnEdge) {
  const std::string above =
      "<transform name='to_world'><lookat origin='0 0 3' target='0 0 0' up='0 1 0'/></transform>";
  const std::string half =
      "<shape type='rectangle'><transform name='to_world'><scale value='2'/>"
      "<translate x='2'/></transform></shape>";
  const fs::path folder = fs::path(plugins()) / "rfilter";
  for (const std::string& set : sets_built(folder, {"hann.so"})) {
    if (!is_usable(set)) continue;
    const Image flat = render_text(
        replaced(floor_scene("normals", ""), "<rfilter type=\"box\"/>", "<rfilter type=\"hann\"/>"),
        {"--isa", set});
    const Image edge = render_text(
        scene_of("normals", "'orthographic'>" + above, half, "hann", 1024), {"--isa", set});
    ASSERT_EQ(flat.width, 16);
    ASSERT_EQ(edge.width, 16);
    for (int p = 0; p < 16 * 16; ++p) EXPECT_NEAR(flat.at(p % 16, p / 16, 1), 1, 1e-6) << set;
    double columns[16] = {};
    for (int p = 0; p < 16 * 16; ++p) columns[p % 16] += edge.at(p % 16, p / 16, 2) / 16;
    if (columns[0] > columns[15]) std::reverse(columns, columns + 16);
    // Half a pixel from the edge. There are 16 x 1024 samples in each of three columns, and their
    // squared weights have a mean of 3/8: a standard deviation below .5 / sqrt(3 x 16384 / 1.5) =
    // .0028.
    const double expected = .5 + .5 / 3 + std::sin(M_PI / 3) / (2 * M_PI);
    EXPECT_NEAR(columns[8], expected, 5 * .0028) << set;
    EXPECT_NEAR(columns[7], 1 - expected, 5 * .0028) << set;
    EXPECT_EQ(columns[5], 0) << set;
    EXPECT_NEAR(columns[10], 1, 1e-6) << set;
  }
}

/// An image of a floor that `normals` shows as (.5, 1, .5), half as bright.
TEST_F(Sdk, FilmWritesItsFormat) {
  const std::string scene = folder_->write(
      "film.xml", replaced(replaced(floor_scene("normals", ""), "<film type=\"hdrfilm\">",
                                    "<film type='png'><float name='exposure' value='-1'/>"),
                           R"(<string name="component_format" value="float32"/>)", ""));
  // The film adds its extension.
  expect_success(run_process(
      {program(), "-q", scene, "-o", folder_->path("picture"), "--plugin-path", plugins()}));
  const Png png = read_png(folder_->path("picture.png"));
  ASSERT_EQ(png.width, 16u);
  ASSERT_EQ(png.height, 16u);
  for (size_t p = 0; p < 16 * 16; ++p) {
    EXPECT_EQ(png.rgba[4 * p], 137);
    EXPECT_EQ(png.rgba[4 * p + 1], 188);
    EXPECT_EQ(png.rgba[4 * p + 2], 137);
  }
}

}  // namespace
}  // namespace kinome::test::examples_test
