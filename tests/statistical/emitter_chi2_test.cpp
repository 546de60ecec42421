/// chi² tests of emitters: origins and directions of emitted rays, and the points that a surface
/// point samples.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/gtc/matrix_transform.hpp>

#include "emitter_cases.h"
#include "shape_cells.h"
#include "support/statistics.h"
#include "support/shape_helpers.h"

namespace kinome::test::emitter_chi2_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 40 tests
constexpr double kPiD = std::numbers::pi;

// ---- emitters without area

/// Maps [0, 1]² to the directions of a lamp, so that the lamp's edges are edges of cells: a cone
/// around the axis, or the rectangle of an image at z = 1.
struct Directions {
  std::string name;   ///< of an emitter case
  double cutoff = 0;  ///< half angle of the cone in degrees
  Vec2 half_size{0};  ///< half the size of the rectangle

  double height() const { return 1 - std::cos(cutoff * kPiD / 180); }
  Vec3 at(double u, double v) const {
    if (cutoff == 0) {
      return glm::normalize(Vec3((2.f * Vec2(u, v) - 1.f) * half_size, 1));
    }
    const double z = 1 - u * height(), r = std::sqrt(1 - z * z), phi = 2 * kPiD * (v - 0.5);
    return Vec3(glm::dvec3(r * std::cos(phi), r * std::sin(phi), z));
  }
  double solid_angle(const Vec3& d) const {  ///< per unit of u and v
    return cutoff == 0 ? 4. * half_size.x * half_size.y * std::pow(d.z, 3) : 2 * kPiD * height();
  }
  int cell(const Vec3& d) const {
    if (cutoff != 0)
      return part((1. - d.z) / height(), kSide) * kSide + part(turn(d.x, d.y), kSide);
    const Vec2 uv = (Vec2(d.x, d.y) / d.z / half_size + 1.f) * 0.5f;
    return part(uv.x, kSide) * kSide + part(uv.y, kSide);
  }

  static constexpr int kSide = 14;
};

std::vector<Directions> shaped_lights() {
  const auto image = [](double fov, double aspect) {
    const double half_width = std::tan(fov * kPiD / 360);
    return Vec2(half_width, half_width / aspect);
  };
  // A focal length of 50 mm; the diagonal of the film is 43.27 mm.
  const double normal_lens = 2 * std::atan(0.43266615) * 180 / kPiD;
  const auto by_diagonal = [&](double aspect) {
    return image(normal_lens, aspect) / static_cast<float>(std::sqrt(1 + 1 / (aspect * aspect)));
  };
  return {
      {"point", 180},
      {"spot", 35},
      {"spot with a hard edge", 25},
      {"spot without a beam", 40},
      {"spot that shines backward, too", 170},
      {"spot with an image", 35},
      {"spot with a checkerboard", 35},
      {"projector", 0, image(50, 5. / 3)},
      {"projector of a stretched image", 0, image(50, 5. / 3) * Vec2(1.5f, 0.7f) / 2.f},
      {"projector of a turned image", 0, by_diagonal(5. / 3)},
      {"projector of a checkerboard", 0, by_diagonal(1)},
      {"projector without an image", 0, image(90, 1)},
  };
}

/// Returns the axes of lamps with the transform kAbove.
Frame above_frame() {
  const Vec3 axis = glm::normalize(Vec3(0, .1, 0) - Vec3(.4, .2, 1.6));
  const Vec3 left = glm::normalize(glm::cross(Vec3(.3, 1, 0), axis));
  return {left, glm::cross(axis, left), axis};
}

/// Tests the number of samples in each cell, out of `drawn` attempts, against the cell's
/// probability: the total by a z-test, and the distribution by a chi² test. The probabilities were
/// integrated over `steps` x `steps` elements. About `steps` of these are cut by an edge of the
/// light and count either fully or not at all.
void expect_frequencies(const std::vector<double>& observed, std::vector<double> probability,
                        int drawn, int steps, const std::string& name) {
  const double accepted = std::accumulate(observed.begin(), observed.end(), 0.);
  const double mass = std::accumulate(probability.begin(), probability.end(), 0.);
  ASSERT_TRUE(accepted > 0 && mass > 0) << name;
  const Verdict all = z_test({{accepted / drawn, mass * std::max(1 - mass, 0.) / drawn}},
                             {{mass, std::pow(steps, -3.)}}, kAlpha / 2);
  EXPECT_TRUE(all.passed) << name << ": " << all.text;
  for (double& p : probability) p *= accepted / mass;
  const Verdict cells = chi2_test(observed, probability, kAlpha / 2);
  EXPECT_TRUE(cells.passed) << name << ": " << cells.text;
}

/// Keeps rays with a probability in proportion to their power. If their directions have the
/// returned density, the kept rays are distributed as the intensity that sample_direct() returns.
void expect_directions_by_intensity(const Emitter& emitter, const Directions& directions) {
  constexpr int kCount = 200000, kSide = Directions::kSide;
  const Frame frame = above_frame();
  const auto for_each_ray = [&](const auto& fn) {
    Random random(61);
    for (int i = 0; i < kCount; ++i) {
      const auto ray = emitter.sample_emission(Vec2(0.f), {random.unit(), random.unit()});
      const float u = random.unit();
      if (ray) fn(*ray, u);
    }
  };
  float max_power = 0;
  Vec3 origin(0.f);
  for_each_ray([&](const EmissionSample& ray, float) {
    origin = ray.o;
    max_power = std::max(max_power, luminance(ray.power));
  });
  std::vector<double> observed(kSide * kSide), probability(kSide * kSide);
  for_each_ray([&](const EmissionSample& ray, float u) {
    if (u * max_power < luminance(ray.power)) observed[directions.cell(frame.to_local(ray.d))] += 1;
  });
  constexpr int kSteps = 40 * kSide;  // an edge inside a cell is located to 1/40 of its width
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const Vec3 d = directions.at((i / kSteps + 0.5) / kSteps, (i % kSteps + 0.5) / kSteps);
    const auto light = emitter.sample_direct(origin + frame.to_world(d), Vec2(0.5f));
    if (!light) continue;
    probability[directions.cell(d)] += luminance(light->radiance * sqr(light->distance)) /
                                       max_power * directions.solid_angle(d) /
                                       (double{kSteps} * kSteps);
  }
  expect_frequencies(observed, probability, kCount, kSteps, directions.name);
}

TEST(EmitterChi2, DirectionsOfLightsWithoutExtent) {
  for (const Directions& directions : shaped_lights()) {
    const auto tested =
        std::find_if(emitter_cases().begin(), emitter_cases().end(),
                     [&](const EmitterCase& entry) { return entry.name == directions.name; });
    ASSERT_NE(tested, emitter_cases().end()) << directions.name;
    const LitFloor floor(tested->xml);
    expect_directions_by_intensity(floor.emitter(), directions);
  }
}

/// Light from infinitely far covers the whole scene uniformly, and starts outside it.
TEST(EmitterChi2, DistantLightCoversTheScene) {
  const std::string shapes =
      "<shape type='cube'><transform name='to_world'><scale value='3 .5 1'/><rotate z='1' "
      "angle='20'/><translate value='100 -20 5'/></transform></shape>";
  for (const char* light : {"directional", "constant"}) {
    const auto scene = scene_from(shapes + "<emitter type='" + light + "'/>");
    const Aabb box = scene->bounds();
    constexpr int kRings = 6, kSectors = 8, kCount = 50000;
    std::vector<double> observed(kRings * kSectors);
    Random random(25);
    for (int i = 0; i < kCount; ++i) {
      const Vec2 position(random.unit(), random.unit());
      const auto ray =
          scene->emitters()[0]->sample_emission(position, {random.unit(), random.unit()});
      ASSERT_TRUE(ray);
      const float radius = std::sqrt(1 / (kPi * ray->pdf_position));
      EXPECT_GE(radius, 0.5f * glm::length(box.extent()));
      for (unsigned k = 0; k < 8; ++k) EXPECT_GT(glm::dot(box.corner(k) - ray->o, ray->d), 0);
      // Offset across the ray from the centre.
      const Vec3 offset = Frame::from_normal(ray->d).to_local(ray->o - box.centre()) / radius;
      const double r2 = offset.x * offset.x + offset.y * offset.y;
      ASSERT_LT(r2, 1 + 1e-5);
      observed[part(r2, kRings) * kSectors + part(turn(offset.x, offset.y), kSectors)] += 1;
    }
    const std::vector<double> expected(observed.size(), double{kCount} / (kRings * kSectors));
    const Verdict verdict = chi2_test(observed, expected, kAlpha);
    EXPECT_TRUE(verdict.passed) << light << ": " << verdict.text;
  }
}

// ---- the sun and the sky

/// Tests sampled directions, by cells of equal solid angle, against pdf_environment().
TEST(EmitterChi2, DirectionsTowardSunAndSky) {
  constexpr int kColumns = 36, kRows = 18, kCount = 400000, kSteps = 16;
  int skies = 0;
  for (const EmitterCase& tested : emitter_cases()) {
    const bool is_tiny = tested.name == "sun without a sky";
    if (tested.xml.find("sunsky") == std::string::npos || is_tiny) continue;
    ++skies;
    const LitFloor floor(tested.xml);
    const Emitter& emitter = floor.emitter();
    const auto cell_of = [&](const Vec3& d) {
      return part(0.5 - 0.5 * d.z, kRows) * kColumns + part(turn(d.x, d.y), kColumns);
    };
    std::vector<double> observed(kColumns * kRows), probability(observed.size());
    Random random(71);
    for (int i = 0; i < kCount; ++i) {
      const auto sample = emitter.sample_direct(Vec3(0.f), {random.unit(), random.unit()});
      if (!sample) continue;
      ASSERT_NEAR(glm::length(sample->d), 1, 1e-6) << tested.name;
      ASSERT_NEAR(emitter.pdf_environment(sample->d) / sample->pdf, 1, 0.5) << tested.name;
      // A small sun affects only one cell, and the next test covers it.
      if (sample->pdf < 100) observed[cell_of(sample->d)] += 1;
    }
    // A random position in each step makes steps across an edge correct on average.
    for (int i = 0; i < kColumns * kSteps * kRows * kSteps; ++i) {
      const double u = (i % (kColumns * kSteps) + random.unit()) / (kColumns * kSteps);
      const double v = (i / (kColumns * kSteps) + random.unit()) / (kRows * kSteps);
      const double z = 1 - 2 * v, r = std::sqrt(1 - z * z), phi = 2 * kPiD * (u - 0.5);
      const Vec3 d(glm::dvec3(r * std::cos(phi), r * std::sin(phi), z));
      const double pdf = emitter.pdf_environment(d);
      if (pdf >= 100) continue;
      probability[cell_of(d)] += pdf * 4 * kPiD / (double{kColumns} * kRows * kSteps * kSteps);
    }
    expect_frequencies(observed, probability, kCount, kColumns * kSteps, tested.name);
  }
  EXPECT_GE(skies, 4);
}

/// A sun of its real size: samples are uniform over its disk, and as frequent as the density
/// requires.
TEST(EmitterChi2, DirectionsTowardASmallSun) {
  const LitFloor floor(
      "<emitter type='sunsky'><vector name='sun_direction' value='.5 -.3 .8'/></emitter>");
  const Emitter& emitter = floor.emitter();
  const Vec3 sun = glm::normalize(Vec3(.5, -.3, .8));
  const Frame frame = Frame::from_normal(sun);
  const double half_angle = 0.5358 / 2 * kPiD / 180, chord2 = 2 * (1 - std::cos(half_angle));
  constexpr int kRings = 5, kSectors = 8, kCount = 100000;
  std::vector<double> observed(kRings * kSectors);
  Random random(72);
  for (int i = 0; i < kCount; ++i) {
    const auto sample = emitter.sample_direct(Vec3(0.f), {random.unit(), random.unit()});
    ASSERT_TRUE(sample);
    const glm::dvec3 offset(frame.to_local(sample->d - sun));
    const double share = (offset.x * offset.x + offset.y * offset.y) / chord2;
    if (share >= 1) continue;
    observed[part(share, kRings) * kSectors + part(turn(offset.x, offset.y), kSectors)] += 1;
  }
  const double of_sun = emitter.pdf_environment(sun) * kPiD * chord2;
  EXPECT_GT(of_sun, 0.3);
  expect_frequencies(observed, std::vector<double>(observed.size(), of_sun / observed.size()), kCount,
                     1000, "a small sun");
}

// ---- emitters on surfaces

/// An area light on a rotated, translated and enlarged shape, and cells of equal area on it.
struct SurfaceLight {
  std::string name;
  std::shared_ptr<Shape> shape;
  ShapeCells cells;
};

const glm::mat4 kToWorld = glm::translate(glm::mat4(1.f), {10, -7, 3}) *
                           glm::rotate(glm::mat4(1.f), 1.3f, {1, 2, -1}) *
                           glm::scale(glm::mat4(1.f), Vec3(3));

Vec3 to_object(const Vec3& p) {
  static const glm::dmat4 inverse = glm::inverse(glm::dmat4(kToWorld));
  return Vec3(inverse * glm::dvec4(p, 1));
}

std::vector<SurfaceLight> surface_lights() {
  std::string numbers;
  for (int i = 0; i < 16; ++i) numbers += " " + std::to_string(kToWorld[i % 4][i / 4]);
  const std::string rest = "<transform name='to_world'><matrix value='" + numbers +
                           "'/></transform><emitter type='area'/></shape>";
  std::vector<SurfaceLight> lights;
  for (const auto& [type, cells] : shape_cells()) {
    lights.push_back({type, make<Shape>("<shape type='" + type + "'>" + rest), cells});
  }
  // A square of triangles with very different sizes.
  const TemporaryFolder folder;
  const std::string path = folder.write("mesh.obj",
                                        "v -1 -1 0\nv -1 1 0\nv -.9 -1 0\nv -.9 1 0\nv 1 -1 0\n"
                                        "v 1 1 0\nf 1 3 2\nf 3 4 2\nf 3 5 4\nf 5 6 4\n");
  lights.push_back(
      {"mesh",
       make<Shape>("<shape type='obj'><string name='filename' value='" + path + "'/>" + rest),
       shape_cells().at("rectangle")});
  return lights;
}

/// Rays are uniform over the surface and cosine-distributed over directions, jointly.
TEST(EmitterChi2, RaysOfAreaLights) {
  constexpr int kCount = 100000, kRings = 3, kSectors = 4;
  for (const SurfaceLight& light : surface_lights()) {
    std::vector<double> observed(static_cast<size_t>(light.cells.count) * kRings * kSectors);
    Random random(62);
    for (int i = 0; i < kCount; ++i) {
      const Vec2 position(random.unit(), random.unit());
      const auto ray =
          light.shape->emitter()->sample_emission(position, {random.unit(), random.unit()});
      ASSERT_TRUE(ray) << light.name;
      const Vec3 d = Frame::from_normal(ray->n).to_local(ray->d);
      ASSERT_GT(d.z, 0) << light.name;
      ASSERT_NEAR(ray->pdf_direction, d.z * kInvPi, 1e-5) << light.name;
      const int direction =
          part(d.x * d.x + d.y * d.y, kRings) * kSectors + part(turn(d.x, d.y), kSectors);
      observed[light.cells.cell(to_object(ray->o)) * kRings * kSectors + direction] += 1;
    }
    const std::vector<double> expected(observed.size(), kCount / double(observed.size()));
    const Verdict verdict = chi2_test(observed, expected, kAlpha);
    EXPECT_TRUE(verdict.passed) << light.name << ": " << verdict.text;
  }
}

/// Tests the points that p samples, by cells of the surface, against integrals of pdf_surface().
void expect_sampled_by_density(const SurfaceLight& light, const Vec3& p) {
  const Emitter& emitter = *light.shape->emitter();
  std::vector<double> probability(static_cast<size_t>(light.cells.count));
  constexpr int kSteps = 600;
  Random place(64);  // jitters each step, so that steps across a horizon are correct on average
  for (int i = 0; i < kSteps * kSteps; ++i) {
    const Vec2 step(i / kSteps, i % kSteps);
    SurfaceInteraction si = light.shape->sample_surface((step + Vec2(place.unit(), place.unit())) /
                                                        static_cast<float>(kSteps));
    const Vec3 to = p - si.p;
    si.wi = si.frame.to_local(glm::normalize(to));
    const double solid_angle = std::abs(glm::dot(si.n, glm::normalize(to))) / glm::dot(to, to) *
                               light.shape->area() / (double{kSteps} * kSteps);
    probability[light.cells.cell(to_object(si.p))] += emitter.pdf_surface(p, si) * solid_angle;
  }
  constexpr int kCount = 100000;
  std::vector<double> observed(probability.size());
  Random random(63);
  for (int i = 0; i < kCount; ++i) {
    const auto sample = emitter.sample_direct(p, {random.unit(), random.unit()});
    if (!sample) continue;
    observed[light.cells.cell(to_object(p + sample->distance * sample->d))] += 1;
  }
  expect_frequencies(observed, probability, kCount, kSteps, light.name);
}

TEST(EmitterChi2, DirectionsTowardAreaLights) {
  for (const SurfaceLight& light : surface_lights()) {
    for (const Vec3& place : {Vec3(-1.3, .6, 4), Vec3(1.8, -.5, .7), Vec3(1.1, -.3, 1.2)}) {
      expect_sampled_by_density(light, Vec3(kToWorld * glm::vec4(place, 1)));
    }
  }
}

}  // namespace
}  // namespace kinome::test::emitter_chi2_test
