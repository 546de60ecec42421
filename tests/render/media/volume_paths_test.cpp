/// `volpath` against closed forms, quadrature, and itself.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/volume_files.h"
#include "volume_scenes.h"

namespace kinome::test::volume_paths_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 30 z-tests

std::string volpath_xml(int max_depth = -1, const std::string& more = "") {
  return integrator_xml("volpath", max_depth, more);
}

/// A heterogeneous medium whose extinction is a grid in [-1, 1]³.
std::string smoke_xml(const std::string& file, const std::string& albedo, float scale,
                      const std::string& phase = phase_xml(0.5f)) {
  return "<medium type=\"heterogeneous\" name=\"interior\"><volume type=\"gridvolume\" "
         "name=\"sigma_t\"><string name=\"filename\" value=\"" +
         file +
         "\"/><transform name=\"to_world\"><translate x=\"-0.5\" y=\"-0.5\" z=\"-0.5\"/><scale "
         "value=\"2\"/></transform></volume>" +
         rgb_volume_xml("albedo", albedo) + "<float name=\"scale\" value=\"" +
         std::to_string(scale) + "\"/>" + phase + "</medium>";
}
std::string write_smoke(const TemporaryFolder& folder, int32_t channels) {
  VolFile file{.x = 19, .y = 11, .z = 10};
  file.channels = channels;
  return folder.write("smoke" + std::to_string(channels) + ".vol",
                      file.bytes([](int i) { return std::pow(mixed_value(i), 3.f); }));
}

/// Microflakes of random shape whose density varies.
std::string flakes_xml(const TemporaryFolder& folder) {
  VolFile file{.x = 3, .y = 4, .z = 2};
  file.channels = 6;
  const std::string path = folder.write("flakes.vol", file.bytes([](int i) {
    return i % 6 < 3 ? 0.15f + mixed_value(i) : 0.1f * mixed_value(i);
  }));
  const std::string phase =
      "<phase type=\"sggx\"><volume type=\"gridvolume\" name=\"S\"><string name=\"filename\" "
      "value=\"" +
      path +
      "\"/><transform name=\"to_world\"><translate x=\"-0.5\" y=\"-0.5\" z=\"-0.5\"/><scale "
      "value=\"2\"/></transform></volume></phase>";
  return smoke_xml(write_smoke(folder, 1), "1 1 1", 3, phase);
}

/// The transmittance of a slab is exp(-extinction x length) in each channel.
TEST(VolumePaths, SlabsAbsorbLight) {
  const auto scene = scene_from(fog_cube_xml(fog_xml("0.2 0.9 2.5", "0 0 0")) +
                                constant_xml("1 2 3") + volpath_xml() + parallel_view(0.9, 4, 64));
  const Rgb expected(static_cast<float>(std::exp(-0.4)), static_cast<float>(2 * std::exp(-1.8)),
                     static_cast<float>(3 * std::exp(-5.)));
  expect_equal(estimate_pixels(*scene, kRenders), exactly(expected, 16), kAlpha, "slab");
}

/// Light passes boundaries in front of a floor, also that of a lamp. Its transmittance is exact.
TEST(VolumePaths, ShadowRaysAreExactInHomogeneousMedia) {
  const std::string inner = shape_xml("cube", "<scale x=\"9\" y=\"9\" z=\"0.25\"/>",
                                      kBoundary + fog_xml("2 0 1", "0.5 0.5 0.5"));
  const std::string outer =
      fog_cube_xml(fog_xml("0.5 1 0", "0.5 0.5 0.5"), "<scale x=\"8\" y=\"8\" z=\"0.5\"/>");
  const std::string floor = shape_xml("rectangle", "<scale value=\"9\"/><translate z=\"-3\"/>",
                                      diffuse_xml("0.5 0.5 0.5"));
  const std::string sun =
      "<emitter type=\"directional\"><vector name=\"direction\" value=\"0 0 -1\"/></emitter>";
  const auto scene =
      scene_from(inner + outer + floor + sun + volpath_xml(2) +
                 sensor_xml("perspective", look_at("0 0 -2", "0 0 -3", "0 1 0"), 4, 1));
  const Image image = render_scene(*scene);
  // Without a stack of media, the outer medium doesn't continue behind the inner one.
  const Rgb expected(std::exp(-2 * 0.5f - 0.5f * 0.25f), std::exp(-0.25f), std::exp(-0.5f));
  for (size_t i = 0; i < image.data.size(); ++i) {
    EXPECT_NEAR(image.data[i], 0.5 / std::numbers::pi * expected[static_cast<int>(i % 3)], 1e-6);
  }
}

/// Media without absorption in uniform light have its radiance, whatever the boundary.
TEST(VolumePaths, MediaWithoutAbsorptionVanishInAnEvenLight) {
  const TemporaryFolder folder;
  const std::string smoke = smoke_xml(write_smoke(folder, 3), "1 1 1", 3);
  const std::string glass = "<bsdf type=\"dielectric\"/>";
  const std::string fog = fog_xml("0.5 1 2", "1 1 1", phase_xml(0.7f));
  const std::pair<const char*, std::string> shapes[] = {
      {"fog", fog_cube_xml(fog)},
      {"glass", shape_xml("sphere", "", glass + fog)},
      {"smoke", fog_cube_xml(smoke)},
      {"flakes", fog_cube_xml(flakes_xml(folder))},
  };
  for (const auto& [name, shape] : shapes) {
    const auto scene =
        scene_from(shape + constant_xml("1 1 1") + volpath_xml() + parallel_view(0.8, 2, 64));
    expect_equal(estimate_pixels(*scene, kRenders), exactly(Rgb(1), 4), kAlpha, name);
  }
}

/// Light of a lamp that is scattered once on the way, by quadrature along the ray.
TEST(VolumePaths, SingleScatteringAgreesWithQuadrature) {
  for (const double g : {0., 0.6}) {
    const double extinction = 0.8, albedo = 0.7, height = 0.4;
    double expected = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double t = 2 * (i + 0.5) / kSteps, z = 1 - t, r = std::hypot(z, height);
      // Light comes from the lamp at (0, height, 0), and leaves along +z.
      const double cosine = z / r;
      const double phase =
          (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
      expected += std::exp(-extinction * (t + r)) * phase / (r * r) * 2 / kSteps;
    }
    expected *= extinction * albedo;
    const auto scene = scene_from(
        fog_cube_xml(fog_xml("0.8 0.8 0.8", "0.7 0.7 0.7", phase_xml(static_cast<float>(g)))) +
        point_xml("0 0.4 0", "1 1 1") + volpath_xml(2) + parallel_view(0.001, 1, 1024));
    expect_equal(estimate_pixels(*scene, kRenders), exactly(Rgb(static_cast<float>(expected)), 1),
                 kAlpha, "g " + std::to_string(g));
  }
}

/// Reflectance of a deep medium under uniform light (van de Hulst 1980, vol. 2, table 40; its
/// formula is exact to 0.002), as irradiance above the medium.
TEST(VolumePaths, DeepMediaReflectAsTabulated) {
  const double albedo = 0.9, s = std::sqrt(1 - albedo);
  const double expected = (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s);
  const std::string meter =
      "<sensor type=\"irradiancemeter\"><sampler type=\"independent\"><integer "
      "name=\"sample_count\" value=\"1024\"/></sampler><film type=\"hdrfilm\"><integer "
      "name=\"width\" value=\"1\"/><integer name=\"height\" value=\"1\"/><rfilter "
      "type=\"box\"/></film></sensor>";
  const auto scene = scene_from(
      fog_cube_xml(fog_xml("1 1 1", "0.9 0.9 0.9"), "<translate z=\"-1\"/><scale value=\"200\"/>") +
      constant_xml("1 1 1") + volpath_xml() +
      shape_xml("rectangle",
                "<scale value=\"0.1\"/><rotate x=\"1\" angle=\"180\"/><translate "
                "z=\"0.1\"/>",
                kBoundary + meter));
  const Estimate measured = estimate_pixels(*scene, kRenders).front();
  EXPECT_NEAR(measured.mean / std::numbers::pi, expected,
              0.002 + 4 * std::sqrt(measured.variance_of_mean));
}

/// Each channel of a coloured medium is the image of a grey one.
TEST(VolumePaths, ChannelsMatchGreyMedia) {
  const auto scene = [](const std::string& extinction, const std::string& albedo) {
    return scene_from(fog_cube_xml(fog_xml(extinction, albedo, phase_xml(0.4f))) +
                      shape_xml("sphere", "<scale value=\"0.4\"/>", diffuse_xml("0.6 0.6 0.6")) +
                      shape_xml("rectangle", "<rotate x=\"1\" angle=\"90\"/><translate y=\"1.5\"/>",
                                area_xml("4 4 4")) +
                      constant_xml("0.5 0.5 0.5") + volpath_xml(5) + parallel_view(0.9, 4, 64));
  };
  const std::pair<const char*, const char*> greys[] = {
      {"0.3 0.3 0.3", "0.9 0.9 0.9"}, {"1 1 1", "0.7 0.7 0.7"}, {"3 3 3", "0.8 0.8 0.8"}};
  const auto coloured = estimate_pixels(*scene("0.3 1 3", "0.9 0.7 0.8"), kRenders);
  for (int c = 0; c < 3; ++c) {
    const auto grey = estimate_pixels(*scene(greys[c].first, greys[c].second), kRenders, 1000);
    const Verdict verdict = z_test(channel(coloured, c), channel(grey, c), kAlpha / 3);
    EXPECT_TRUE(verdict.passed) << "channel " << c << ": " << verdict.text;
  }
}

/// Tracked transmittances and distances agree with exact optical depths.
TEST(VolumePaths, TrackingAgreesWithExactOpticalDepths) {
  const TemporaryFolder folder;
  const std::string file = write_smoke(folder, 3);
  const std::string sun =
      "<emitter type=\"directional\"><vector name=\"direction\" value=\"0 0 -1\"/></emitter>";
  const std::string floor =
      shape_xml("rectangle", "<scale value=\"9\"/><translate z=\"-3\"/>", diffuse_xml("1 1 1"));
  const std::string smoke = fog_cube_xml(smoke_xml(file, "0 0 0", 4));
  constexpr float kSize = 1e-4f;  // of the view: a point
  const auto sunlit = scene_from(
      smoke + floor + sun + volpath_xml(2) +
      sensor_xml("orthographic",
                 "<scale value=\"0.0001\"/>" + look_at("0.1 0.2 -2", "0.1 0.2 -3", "0 1 0"), 1,
                 256));
  const auto seen = scene_from(
      smoke + constant_xml("1 1 1") + volpath_xml() +
      sensor_xml("orthographic",
                 "<scale value=\"0.0001\"/>" + look_at("0.1 0.2 5", "0.1 0.2 0", "0 1 0"), 1, 256));
  const Medium& medium = *sunlit->media().front();
  ASSERT_TRUE(medium.has_optical_depth());
  alignas(kColumnAlignment) float columns[10][kBlockLanes] = {};
  const auto three = [&](int i) { return Columns3(columns[i], columns[i + 1], columns[i + 2]); };
  three(0).set(0, Vec3(0.1f, 0.2f, 1.f));
  three(3).set(0, Vec3(0, 0, -1));
  columns[9][0] = 2 - kSize;
  medium.optical_depth_block(three(0), three(3), columns[9], 1, three(6));
  const Rgb depth = three(6).at(0);
  const Rgb transmittance(std::exp(-depth.x), std::exp(-depth.y), std::exp(-depth.z));
  expect_equal(estimate_pixels(*sunlit, kRenders), exactly(transmittance * kInvPi, 1), kAlpha,
               "transmittance");
  expect_equal(estimate_pixels(*seen, kRenders), exactly(transmittance, 1), kAlpha, "distances");
}

/// A grid of equal values is a homogeneous medium.
TEST(VolumePaths, EqualVoxelsAreHomogeneous) {
  const TemporaryFolder folder;
  VolFile file;
  file.channels = 1;
  const std::string path = folder.write("even.vol", file.bytes([](int) { return 0.5f; }));
  const std::string rest = constant_xml("1 0.7 0.4") + volpath_xml(6) + parallel_view(0.9, 2, 64);
  const auto grid = scene_from(fog_cube_xml(smoke_xml(path, "0.8 0.6 0.4", 3)) + rest);
  const auto fog =
      scene_from(fog_cube_xml(fog_xml("1.5 1.5 1.5", "0.8 0.6 0.4", phase_xml(0.5f))) + rest);
  expect_equal(estimate_pixels(*grid, kRenders), estimate_pixels(*fog, kRenders, 1000), kAlpha,
               "grid");
}

/// Surfaces that light passes straight don't end paths; with unlimited depth, `path` has the same
/// expectation.
TEST(VolumePaths, AgreesWithPathsWithoutMedia) {
  const auto scene = [](const std::string& integrator) {
    const std::string mask =
        "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.4\"/><bsdf type=\"twosided\">" +
        diffuse_xml("0.8 0.5 0.2") + "</bsdf></bsdf>";
    return scene_from(
        shape_xml("rectangle", "<translate z=\"0.5\"/>", mask) +
        shape_xml("rectangle", "<translate z=\"-0.5\"/>", diffuse_xml("0.5 0.5 0.5")) +
        shape_xml("cube", "<scale value=\"2\"/>", kBoundary) + constant_xml("1 1 1") +
        integrator_xml(integrator, -1) + parallel_view(0.9, 4, 64));
  };
  expect_equal(estimate_pixels(*scene("volpath"), kRenders),
               estimate_pixels(*scene("path"), kRenders, 1000), kAlpha, "mask");
}

/// `clustered` renders media that vary by the same paths.
TEST(VolumePaths, ClusteredRendersGrids) {
  const TemporaryFolder folder;
  const std::string smoke = fog_cube_xml(smoke_xml(write_smoke(folder, 3), "0.9 0.8 0.7", 2));
  const auto image = [&](const std::string& integrator) {
    return render_scene(*scene_from(smoke + constant_xml("1 2 3") + integrator_xml(integrator, -1) +
                                    parallel_view(0.9, 8, 4)));
  };
  EXPECT_EQ(image("clustered").data, image("volpath").data);
}

/// Alpha is the share of rays that a medium scatters or absorbs, and 1 where a lamp is seen.
TEST(VolumePaths, AlphaIsTheShareOfRaysThatTheMediumStops) {
  const std::string view = sensor_xml("orthographic", look_at("0 0 5", "0 0 0", "0 1 0"), 8, 1024,
                                      "independent", "rgba");
  const std::string lamp = shape_xml("rectangle", "<translate z=\"1.5\"/>", area_xml("1 1 1"));
  const std::string fog =
      fog_cube_xml(fog_xml("0.5 0.5 0.5", "0.3 0.3 0.3"), "<scale value=\"2\"/>");
  const auto mean = [](const Image& image) {
    double sum = 0;
    for (size_t i = 3; i < image.data.size(); i += 4) sum += image.data[i];
    return sum / 64;
  };
  const std::string unseen = shape_xml("rectangle", "<translate z=\"9\"/>", area_xml("1 1 1"));
  const double alpha = 1 - std::exp(-2.), deviation = std::sqrt(alpha * (1 - alpha) / (64 * 1024));
  EXPECT_NEAR(mean(render_scene(*scene_from(fog + unseen + volpath_xml() + view))), alpha,
              4 * deviation);
  EXPECT_EQ(mean(render_scene(*scene_from(fog + lamp + volpath_xml() + view))), 1);
}

/// The image doesn't depend on the number of threads, and extreme media don't cause invalid values.
TEST(VolumePaths, ExtremesAreFiniteOnAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const std::string file = write_smoke(folder, 3);
  const std::pair<const char*, std::string> media[] = {
      {"smoke", smoke_xml(file, "0.9 0.8 0.7", 5)},
      {"dense smoke", smoke_xml(file, "0.9 0.8 0.7", 1e6f)},
      {"empty", fog_xml("0 0 0", "1 1 1")},
      {"red", fog_xml("1000000 0 0", "1 1 1")},
      {"dense", fog_xml("1000000 1000000 1000000", "1 1 1")},
  };
  for (const auto& [name, medium] : media) {
    const auto scene =
        scene_from(fog_cube_xml(medium) +
                   shape_xml("rectangle", "<rotate x=\"1\" angle=\"90\"/><translate y=\"1.5\"/>",
                             area_xml("4 4 4")) +
                   constant_xml("0.5 0.5 0.5") + volpath_xml() + parallel_view(1.2, 16, 8));
    const Image one = render_scene(*scene, 3, 1);
    EXPECT_EQ(one.data, render_scene(*scene, 3, 4).data) << name;
    for (const float value : one.data) EXPECT_TRUE(std::isfinite(value) && value >= 0) << name;
    EXPECT_EQ(scene->sensors().front()->film().non_finite(), 0u) << name;
  }
}

}  // namespace
}  // namespace kinome::test::volume_paths_test
