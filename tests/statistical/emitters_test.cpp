/// Tests of emitters of local light: the light that a point samples against the light that they
/// emit.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "direction_test.h"
#include "emitter_cases.h"

namespace kinome::test::emitters_test {
namespace {

constexpr double kAlpha = 1e-4;  // level of each of about 60 statistical tests
constexpr double kPiD = std::numbers::pi;

constexpr int kSide = 4;  ///< cells of the floor along each axis

/// Collects flux by cells of the floor and by channel, from `count` rays or points.
class FloorFlux {
 public:
  FloorFlux() : moments_(kSide * kSide * 3) {}
  /// Adds flux at `uv` of the floor; positions outside [0, 1] are ignored.
  void add(const Vec2& uv, const Rgb& flux) {
    const auto x = static_cast<int>(std::floor(uv.x * kSide));
    const auto y = static_cast<int>(std::floor(uv.y * kSide));
    const bool inside = x >= 0 && x < kSide && y >= 0 && y < kSide;
    for (int cell = 0; cell < kSide * kSide; ++cell) {
      const bool hit = inside && cell == y * kSide + x;
      for (int c = 0; c < 3; ++c) {
        moments_[cell * 3 + c].add(hit ? static_cast<double>(flux[c]) : 0.);
      }
    }
  }
  std::vector<Estimate> channel(int c) const {
    std::vector<Estimate> estimates;
    for (size_t i = static_cast<size_t>(c); i < moments_.size(); i += 3) {
      estimates.push_back({moments_[i].mean(), moments_[i].variance_of_mean()});
    }
    return estimates;
  }

 private:
  std::vector<Moments> moments_;
};

/// Returns the flux that emitted rays bring to each cell of the floor's upper side.
FloorFlux traced_flux(const LitFloor& floor, int count) {
  FloorFlux flux;
  Random random(21);
  for (int i = 0; i < count; ++i) {
    const Vec2 position(random.unit(), random.unit());
    const Vec2 direction(random.unit(), random.unit());
    const auto light = floor.emitter().sample_emission(position, direction);
    Vec2 uv(-1.f);
    if (light) {
      const Ray ray = light->ray();
      const RayHit hit = trace(floor.scene(), ray.o, ray.d);
      if (hit.hit.shape == 0 && light->d.z < 0) uv = floor.scene().interaction(hit).uv;
    }
    flux.add(uv, light ? light->power : Rgb(0.f));
  }
  return flux;
}

/// Returns the same flux, computed by sample_direct() at points of the floor.
FloorFlux gathered_flux(const LitFloor& floor, int count) {
  FloorFlux flux;
  Random random(22);
  RenderCounters counters;
  for (int i = 0; i < count; ++i) {
    const Vec2 uv(random.unit(), random.unit());
    SurfaceInteraction si;
    si.p = Vec3(2.f * uv - 1.f, 0);
    si.p_error = 1e-6f;
    const auto light = floor.emitter().sample_direct(si.p, {random.unit(), random.unit()});
    Rgb arriving(0.f);
    if (light && light->d.z > 0) {
      Ray ray = si.shadow_ray(light->d, light->distance);
      floor.scene().occluded({&ray, 1}, Coherence::kIncoherent, counters);
      // The floor's area is 4.
      if (!ray.is_occluded()) arriving = light->radiance * (4 * light->d.z / light->pdf);
    }
    flux.add(uv, arriving);
  }
  return flux;
}

/// Tests positions, directions, densities and powers of emitted rays together.
TEST(Emitters, LightIsTracedToWhereItIsGathered) {
  for (const EmitterCase& tested : emitter_cases()) {
    const LitFloor floor(tested.xml);
    const FloorFlux traced = traced_flux(floor, 60000);
    const FloorFlux gathered = gathered_flux(floor, 60000);
    for (int c = 0; c < 3; ++c) {
      double total = 0;
      for (const Estimate& cell : gathered.channel(c)) total += cell.mean;
      EXPECT_GT(total, 0) << tested.name;
      const Verdict verdict = z_test(traced.channel(c), gathered.channel(c), kAlpha / 3);
      EXPECT_TRUE(verdict.passed) << tested.name << ", channel " << c << ": " << verdict.text;
    }
  }
}

/// Each ray of a lamp carries the intensity that sample_direct() returns.
TEST(Emitters, RaysCarryTheIntensityThatPointsSee) {
  for (const EmitterCase& tested : emitter_cases()) {
    const LitFloor floor(tested.xml);
    const Emitter& emitter = floor.emitter();
    const auto seen = emitter.sample_direct(Vec3(0.f), Vec2(0.5f));
    if (!seen || !seen->is_delta || seen->distance == kInfinity) continue;
    Random random(23);
    int rays = 0, different = 0;
    for (int i = 0; i < 20000; ++i) {
      const auto ray = emitter.sample_emission(Vec2(0.f), {random.unit(), random.unit()});
      if (!ray) continue;
      ++rays;
      ASSERT_NEAR(glm::length(ray->d), 1, 1e-6) << tested.name;
      ASSERT_EQ(ray->n, Vec3(0.f)) << tested.name;
      ASSERT_GT(ray->pdf_direction, 0) << tested.name;
      const auto light = emitter.sample_direct(ray->o + ray->d, Vec2(0.5f));
      const Rgb intensity = ray->power * ray->pdf_direction;
      const Rgb difference = glm::abs(intensity - (light ? light->radiance : Rgb(0.f)));
      different += max_component(difference) > 1e-4f * max_component(intensity);
    }
    // Directions have an error of about 1e-7, which matters at edges and at the end of a falloff.
    EXPECT_GT(rays, 5000) << tested.name;
    EXPECT_LE(different, rays / 500) << tested.name;
  }
}

/// Emitters without a surface return the densities of all rays that they emit.
TEST(Emitters, ReturnTheDensitiesOfTheirRays) {
  int lights = 0;
  for (const EmitterCase& tested : emitter_cases()) {
    const LitFloor floor(tested.xml);
    const Emitter& emitter = floor.emitter();
    if (emitter.is_surface()) continue;
    ++lights;
    Random random(25);
    int rays = 0, different = 0;
    for (int i = 0; i < 20000; ++i) {
      const Vec2 position(random.unit(), random.unit());
      const auto ray = emitter.sample_emission(position, {random.unit(), random.unit()});
      if (!ray) continue;
      ++rays;
      const auto density = emitter.emission_density(ray->d);
      ASSERT_TRUE(density) << tested.name;
      EXPECT_EQ(density->position, ray->pdf_position) << tested.name;
      different += std::abs(density->direction - ray->pdf_direction) > 1e-4f * ray->pdf_direction;
    }
    // Densities are constant within cells: rays within rounding of a border may have the
    // neighbour's density.
    EXPECT_GT(rays, 5000) << tested.name;
    EXPECT_LE(different, rays / 200) << tested.name;
  }
  EXPECT_GE(lights, 8);
}

/// Mean of a function over emitted rays; a failed sample counts as 0.
Estimate mean_of_rays(const Emitter& emitter, const std::function<double(const EmissionSample&)>& f,
                      int count = 100000) {
  Random random(24);
  Moments moments;
  for (int i = 0; i < count; ++i) {
    const Vec2 position(random.unit(), random.unit());
    const auto ray = emitter.sample_emission(position, {random.unit(), random.unit()});
    moments.add(ray ? f(*ray) : 0);
  }
  return {moments.mean(), moments.variance_of_mean()};
}

void expect_mean(const Estimate& mean, double expected, const std::string& name) {
  const Verdict verdict = z_test({mean}, {{expected, 0}}, kAlpha);
  EXPECT_TRUE(verdict.passed) << name << ": " << verdict.text;
}

double green_power(const EmissionSample& ray) {
  return static_cast<double>(ray.power.y);
}

TEST(Emitters, SendTheirWholePower) {
  const double radians = kPiD / 180;
  const double mean_green = [] {
    double sum = 0;
    for (int i = 0; i < 15; ++i) sum += 0.5 + i * 4 % 13;
    return sum / 15;
  }();
  // Area of the image, with the aspect 5 : 3, on the plane z = 1.
  const double projected = 4 * std::pow(std::tan(25 * radians), 2) * 3 / 5;
  const auto spot = [&](double cutoff, double beam) {  // integral of the falloff, computed by hand
    const double c = cutoff * radians, b = beam * radians;
    return 2 * 2 * kPiD * (1 - (c == b ? std::cos(c) : (std::sin(c) - std::sin(b)) / (c - b)));
  };
  // The floor's bounds are a square of side 2: the disk has the area 2 pi, slightly enlarged for
  // rounding.
  const double disk = 2 * kPiD * std::pow(1 + 1e-4 + 1e-6 / std::sqrt(2.), 2);
  const std::map<std::string, double> expected = {
      {"point", 8 * kPiD},
      {"spot", spot(35, 10)},
      {"spot with a hard edge", spot(25, 25)},
      {"spot without a beam", spot(40, 0)},
      {"spot that shines backward, too", spot(170, 100)},
      {"projector", kPiD * mean_green * projected},
      {"projector without an image", kPiD * 4},
      {"directional", 2 * disk},
      {"rectangle", 2 * kPiD * 4 * 0.15},
      {"sphere", 2 * kPiD * 4 * kPiD * 0.04},
      {"cylinder", 2 * kPiD * 2 * kPiD * 0.1 * 0.5},
      {"cube", 2 * kPiD * 24 * 0.04},
      {"constant", 2 * 4 * kPiD * disk},
  };
  size_t found = 0;
  for (const EmitterCase& tested : emitter_cases()) {
    const auto power = expected.find(tested.name);
    if (power == expected.end()) continue;
    ++found;
    const LitFloor floor(tested.xml);
    expect_mean(mean_of_rays(floor.emitter(), green_power), power->second, tested.name);
  }
  EXPECT_EQ(found, expected.size());
}

/// The mean of 1 / density over all directions is the solid angle that receives light.
TEST(Emitters, DensitiesOfDirectionsCoverTheLight) {
  const double a = std::tan(25 * kPiD / 180), b = a * 3 / 5;
  const auto cone = [](double cutoff) { return 2 * kPiD * (1 - std::cos(cutoff * kPiD / 180)); };
  const std::map<std::string, double> expected = {
      {"point", 4 * kPiD},
      {"spot", cone(35)},
      {"spot with a hard edge", cone(25)},
      {"spot that shines backward, too", cone(170)},
      {"projector", 4 * std::asin(a * b / std::sqrt((1 + a * a) * (1 + b * b)))},
      {"sphere", 2 * kPiD},
      {"constant", 4 * kPiD},
      {"envmap", 4 * kPiD},
      {"mesh with bent normals", 2 * kPiD},
  };
  size_t found = 0;
  for (const EmitterCase& tested : emitter_cases()) {
    const auto angle = expected.find(tested.name);
    if (angle == expected.end()) continue;
    ++found;
    const LitFloor floor(tested.xml);
    // With a cosine-weighted density, 1 / density has infinite variance; grazing rays are left out.
    const bool is_sphere = tested.name == "sphere";
    const double least = is_sphere ? 0.05 : 0;
    expect_mean(mean_of_rays(floor.emitter(),
                             [&](const EmissionSample& ray) {
                               const bool grazing = is_sphere && glm::dot(ray.d, ray.n) < least;
                               return grazing ? 0 : 1 / static_cast<double>(ray.pdf_direction);
                             }),
                angle->second * (1 - least), tested.name);
  }
  EXPECT_EQ(found, expected.size());
}

/// Rays are distributed by flux: their powers differ little, however bright a texel is.
TEST(Emitters, RaysOfShapedLightCarryEqualPower) {
  for (const EmitterCase& tested : emitter_cases()) {
    if (tested.xml.find("type='spot'") == std::string::npos &&
        tested.xml.find("type='projector'") == std::string::npos) {
      continue;
    }
    const LitFloor floor(tested.xml);
    const auto brightness = [](const EmissionSample& ray) { return luminance(ray.power); };
    const Estimate mean = mean_of_rays(floor.emitter(), brightness);
    const double deviation = std::sqrt(mean.variance_of_mean * 100000) / mean.mean;
    // The rest is the variation within cells. It is larger if a black edge crosses them. The
    // image's own variation is 0.6.
    const bool has_edges = tested.name == "projector of a checkerboard";
    EXPECT_LT(deviation, has_edges ? 0.3 : 0.1) << tested.name;
  }
}

/// Tests the directions sampled from area lights against the density that BSDF sampling queries.
TEST(Emitters, AreaLightsAreSampledByTheirDensity) {
  for (const EmitterCase& tested : emitter_cases()) {
    // Seen edge on, a curved surface sampled by area has a density with infinite variance.
    if (tested.xml.find("'area'") == std::string::npos || tested.name == "cylinder") continue;
    const LitFloor floor(tested.xml);
    const Emitter& emitter = floor.emitter();
    for (const Vec3& p : {Vec3(0.1f, -0.3f, 0.05f), Vec3(-0.9f, 0.6f, 0.3f), Vec3(0.2f, 0.1f, 2)}) {
      DirectionTest directions;
      directions.sample = [&](Vec2 u) -> std::optional<Vec3> {
        const auto light = emitter.sample_direct(p, u);
        if (!light) return std::nullopt;
        return light->d;
      };
      directions.pdf = [&](const Vec3& d) {
        return density_along(floor.scene(), p, d, [&](const SurfaceInteraction& si) {
          return si.shape->emitter() ? emitter.pdf_surface(p, si) : 0;
        });
      };
      aim_at(directions, p, emitter.shape()->bounds());
      const Verdict verdict = direction_test(directions, kAlpha);
      EXPECT_TRUE(verdict.passed) << tested.name << " from " << p.x << ", " << p.y << ", " << p.z
                                  << ": " << verdict.text;
    }
  }
}

/// A ray to a sampled point finds the same values as the sample contains.
TEST(Emitters, SamplesOfAreaLightsAgreeWithRays) {
  for (const EmitterCase& tested : emitter_cases()) {
    if (tested.xml.find("'area'") == std::string::npos) continue;
    const LitFloor floor(tested.xml);
    Random random(26);
    int agreed = 0;
    for (int i = 0; i < 5000; ++i) {
      const Vec3 p(random.between(-1, 1), random.between(-1, 1), random.between(0.01f, 1));
      const auto light = floor.emitter().sample_direct(p, {random.unit(), random.unit()});
      if (!light) continue;
      const RayHit hit = trace(floor.scene(), p, light->d);
      const float difference = std::abs(hit.ray.tmax - light->distance);
      // Another surface is nearer, or the ray misses the emitter's edge.
      if (!hit.hit.valid() || difference > 1e-3f * light->distance) continue;
      const SurfaceInteraction si = floor.scene().interaction(hit);
      if (std::abs(si.wi.z) < 0.02f) continue;  // densities change strongly with the direction
      ++agreed;
      ASSERT_NEAR(floor.emitter().pdf_surface(p, si) / light->pdf, 1, 2e-3) << tested.name;
      const Rgb radiance = floor.emitter().eval_surface(si);
      for (int c = 0; c < 3; ++c) {
        ASSERT_NEAR(radiance[c], light->radiance[c], 0.01f * max_component(radiance))
            << tested.name;
      }
    }
    EXPECT_GT(agreed, 200) << tested.name;
  }
}

}  // namespace
}  // namespace kinome::test::emitters_test
