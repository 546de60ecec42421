/// Tests the choice of the light source to which the end of an eye path is connected.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numeric>

#include "clustered/product/lights/source_choice.h"
#include "plugins/integrators/kernels/kernel_helpers.h"

namespace kinome::test::source_choice_test {
namespace {

/// Emits `intensity` in all directions. The irradiance on a surface that faces it is intensity /
/// r².
class Lamp : public Emitter {
 public:
  Lamp(const Vec3& at, float intensity) : at_(at), intensity_(intensity) {}
  std::optional<DirectSample> sample_direct(const Vec3& p, const Vec2&) const override {
    const Vec3 to = at_ - p;
    DirectSample sample;
    sample.distance = glm::length(to);
    if (!(sample.distance > 0)) return std::nullopt;
    sample.d = to / sample.distance;
    sample.pdf = 1;
    sample.radiance = Rgb(intensity_ / sqr(sample.distance));
    return sample;
  }

 private:
  Vec3 at_;
  float intensity_;
};

class Sky : public Emitter {
 public:
  bool is_environment() const override { return true; }
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2&) const override {
    return std::nullopt;
  }
};

struct Sources {
  std::vector<std::unique_ptr<Emitter>> owned;
  std::vector<float> shares;
  std::vector<double> fluxes;
  void add(std::unique_ptr<Emitter> emitter, double flux) {
    owned.push_back(std::move(emitter));
    fluxes.push_back(flux);
  }
  SourceChoice choice(float radius) {
    const double all = std::accumulate(fluxes.begin(), fluxes.end(), 0.);
    std::vector<const Emitter*> emitters;
    shares.clear();
    for (size_t s = 0; s < owned.size(); ++s) {
      emitters.push_back(owned[s].get());
      shares.push_back(static_cast<float>(fluxes[s] / all));
    }
    return SourceChoice(emitters, fluxes, radius);
  }
};

void expect_picks_by_probability(const SourceChoice::At& at, uint32_t count) {
  constexpr uint32_t kDraws = 200000;
  std::vector<double> observed(count);
  for (uint32_t i = 0; i < kDraws; ++i) {
    ++observed[at.pick((static_cast<float>(i) + 0.5f) / kDraws)];
  }
  double sum = 0;
  for (uint32_t s = 0; s < count; ++s) {
    sum += static_cast<double>(at.probability(s));
    // Samples are equally spaced: each count is off by at most one, and by the rounding of the
    // ends.
    EXPECT_NEAR(observed[s], kDraws * static_cast<double>(at.probability(s)), 1 + 1e-6 * kDraws);
  }
  EXPECT_NEAR(sum, 1, 1e-6 * count);
}

TEST(SourceChoice, UsesArrivingLightAndFlux) {
  Sources sources;
  sources.add(std::make_unique<Lamp>(Vec3(0, 0, 1), 1.f), 12);
  sources.add(std::make_unique<Lamp>(Vec3(0, 0, 10), 1.f), 12);
  sources.add(std::make_unique<Lamp>(Vec3(0, 0, -1), 1.f), 12);  // behind the surface
  sources.add(std::make_unique<Sky>(), 500);
  const SourceChoice choice = sources.choice(10);
  const SourceChoice::At at = choice.at(Vec3(0.f), Vec3(0, 0, 1));
  expect_picks_by_probability(at, 4);
  EXPECT_GT(at.probability(0), 0.5f) << "the nearest lamp, in spite of its small flux";
  EXPECT_GT(at.probability(0), 20 * at.probability(1));
  for (uint32_t s = 0; s < 4; ++s) {
    EXPECT_GE(at.probability(s), 0.249f * sources.shares[s]) << "no source is omitted: " << s;
  }
  // From the other side of the surface, the lamp behind it is the one in front.
  const SourceChoice::At other = choice.at(Vec3(0.f), Vec3(0, 0, -1));
  EXPECT_GT(other.probability(2), 0.5f);
  EXPECT_LT(other.probability(0), at.probability(2) + at.probability(0) / 10);
}

TEST(SourceChoice, UsesFluxWithoutArrivingLight) {
  Sources dark;
  dark.add(std::make_unique<Lamp>(Vec3(0, 0, -1), 1.f), 3);
  dark.add(std::make_unique<Lamp>(Vec3(0.f), 1.f), 1);  // at the shading point itself
  const SourceChoice of_dark = dark.choice(1);
  const SourceChoice::At at = of_dark.at(Vec3(0.f), Vec3(0, 0, 1));
  expect_picks_by_probability(at, 2);
  EXPECT_EQ(at.probability(0), 0.75f);

  Sources many;
  Random random(1);
  for (size_t s = 0; s <= SourceChoice::kMaxSampledEmitters; ++s) {
    many.add(std::make_unique<Lamp>(random.direction(), 1.f), random.between(0.1, 2));
  }
  const SourceChoice of_many = many.choice(1);
  const SourceChoice::At anywhere = of_many.at(Vec3(0.f), Vec3(0, 0, 1));
  expect_picks_by_probability(anywhere, static_cast<uint32_t>(many.shares.size()));
  for (size_t s = 0; s < many.shares.size(); ++s) {
    EXPECT_EQ(anywhere.probability(static_cast<uint32_t>(s)), many.shares[s]);
  }
}

/// A single source is always selected, without evaluating it.
TEST(SourceChoice, ChoosesTheOnlySource) {
  Sources one;
  one.add(std::make_unique<Lamp>(Vec3(0, 0, -1), 1.f), 3);
  const SourceChoice choice = one.choice(1);
  const SourceChoice::At at = choice.at(Vec3(0.f), Vec3(0, 0, 1));
  EXPECT_EQ(at.probability(0), 1);
  for (const float u : {0.f, 0.5f, kOneMinusEpsilon}) EXPECT_EQ(at.pick(u), 0u);
}

/// Probabilities sum to one for the smallest and largest intensities of single precision.
TEST(SourceChoice, StaysOneAtExtremes) {
  for (const float intensity : {1e-38f, 1e38f}) {
    Sources sources;
    sources.add(std::make_unique<Lamp>(Vec3(0, 0, 1e-6f), intensity), 1);
    sources.add(std::make_unique<Lamp>(Vec3(0, 0, 1), intensity), 1);
    const SourceChoice choice = sources.choice(1);
    expect_picks_by_probability(choice.at(Vec3(0.f), Vec3(0, 0, 1)), 2);
  }
}

}  // namespace
}  // namespace kinome::test::source_choice_test
