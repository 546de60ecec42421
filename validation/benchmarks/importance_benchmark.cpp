// Time of clustered importance sampling per shading point and per render, without rays.
#include <benchmark/benchmark.h>

#include "clustered/points/cluster_importance.h"
#include "kinome/sampler.h"
#include "kinome/sphere_partition.h"

namespace kinome {
namespace {

/// Light points of a smooth sky with about a hundred bright points.
LightPoints make_sky(uint32_t count) {
  const SpherePartition sphere(count);
  LightPoints points;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3 d = sphere.centre(i);
    const float light = std::exp(4 * d.x * d.y) + (i % 311 == 0 ? 100.f : 0.f);
    points.position.push_back(d);
    points.power.push_back(Rgb(light) * sphere.cell_solid_angle());
    points.extent.push_back(sphere.cell_solid_angle());
  }
  return points;
}

/// Light points of one bounce in a closed room, on its walls. They are brightest around one
/// position.
LightPoints make_room(uint32_t count) {
  LightPoints points;
  points.kind = LightPoints::Kind::kLocal;
  for (uint32_t i = 0; i < count; ++i) {
    const uint64_t bits = hash_words(i);
    const float u = 2 * to_unit_float(static_cast<uint32_t>(bits)) - 1;
    const float v = 2 * to_unit_float(static_cast<uint32_t>(bits >> 32)) - 1;
    const int axis = static_cast<int>(i % 3);
    const float side = i % 2 == 0 ? 1.f : -1.f;
    Vec3 p(0.f), n(0.f);
    p[axis] = side;
    p[(axis + 1) % 3] = u;
    p[(axis + 2) % 3] = v;
    n[axis] = -side;
    points.position.push_back(p);
    points.normal.push_back(n);
    points.power.push_back(Rgb(std::exp(-4 * glm::length(p - Vec3(1, 0.3f, 0.2f)))));
    points.extent.push_back(24.f / static_cast<float>(count));
  }
  return points;
}

struct Fixture {
  LightTree tree;
  LightCut cut{tree, 512, CutCriterion::kVariance};
  std::vector<float> x, y, z;  ///< 32 directions in a glossy lobe
  explicit Fixture(LightPoints points) : tree(std::move(points)) {
    for (int i = 0; i < 32; ++i) {
      const float a = static_cast<float>(i);
      const Vec3 d =
          glm::normalize(Vec3(0.3f + 0.1f * std::sin(7 * a), 0.6f, 0.6f + 0.1f * std::cos(3 * a)));
      x.push_back(d.x);
      y.push_back(d.y);
      z.push_back(d.z);
    }
  }
  LightCut::Point point(bool glossy) const {
    LightCut::Point p;
    p.position = Vec3(-0.2f, -0.95f, 0.1f);
    p.normal = glm::normalize(Vec3(0.1f, 0.9f, 0.3f));
    p.diffuse = 0.5f;
    if (glossy) {
      p.glossy = 0.3f;
      p.lobe = {x.data(), y.data(), z.data(), x.size()};
    }
    return p;
  }
};

const Fixture& fixture(LightPoints::Kind kind = LightPoints::Kind::kDistant) {
  static const Fixture sky(make_sky(1 << 15));
  static const Fixture room(make_room(1 << 15));
  return kind == LightPoints::Kind::kDistant ? sky : room;
}

void BM_Importance512(benchmark::State& state, LightPoints::Kind kind, bool glossy) {
  const Fixture& f = fixture(kind);
  const auto importance = make_joint_importance();
  importance->prepare(f.cut);
  ClusterPmf pmf;
  const LightCut::Point point = f.point(glossy);
  for (auto _ : state) {
    benchmark::DoNotOptimize(importance->weigh(point, pmf));
  }
}
constexpr auto kDistant = LightPoints::Kind::kDistant;
constexpr auto kLocal = LightPoints::Kind::kLocal;
BENCHMARK_CAPTURE(BM_Importance512, without_lobe_rays, kDistant, false);
BENCHMARK_CAPTURE(BM_Importance512, with_32_lobe_rays, kDistant, true);
BENCHMARK_CAPTURE(BM_Importance512, local_without_lobe_rays, kLocal, false);
BENCHMARK_CAPTURE(BM_Importance512, local_with_32_lobe_rays, kLocal, true);

void BM_SamplePoints128(benchmark::State& state) {
  const Fixture& f = fixture();
  const auto importance = make_joint_importance();
  importance->prepare(f.cut);
  ClusterPmf pmf;
  importance->weigh(f.point(false), pmf);
  std::vector<Vec2> u;
  for (uint64_t i = 1; i <= 128; ++i) {
    const uint64_t bits = mix_bits(i);
    u.emplace_back(to_unit_float(static_cast<uint32_t>(bits)),
                   to_unit_float(static_cast<uint32_t>(bits >> 32)));
  }
  PointSelection selection;
  for (auto _ : state) {
    selection.clear();
    f.cut.sample_points(pmf, u, selection);
    benchmark::DoNotOptimize(selection);
  }
}
BENCHMARK(BM_SamplePoints128);

void BM_BuildTree(benchmark::State& state) {
  const LightPoints points = make_sky(static_cast<uint32_t>(state.range(0)));
  for (auto _ : state) {
    const LightTree tree(points);
    benchmark::DoNotOptimize(tree.cells().data());
  }
}
BENCHMARK(BM_BuildTree)->Arg(1 << 15)->Arg(1 << 18)->Unit(benchmark::kMillisecond);

void BM_SelectCut512(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(select_cut(fixture().tree, 512, CutCriterion::kVariance));
  }
}
BENCHMARK(BM_SelectCut512)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kinome
