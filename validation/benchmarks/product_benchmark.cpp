// Time of the parts of learned product sampling, without rays: kernels over cells, kernels over
// candidates of glossy lobes, and the code around them. Rates are in items per second: cells,
// candidates, teeth, records or points.
#include <benchmark/benchmark.h>

#include <numeric>
#include <random>

#include "clustered/cells/light_cells.h"
#include "clustered/kernels/candidate_kernels.h"
#include "clustered/kernels/cell_kernels.h"
#include "clustered/product/rays/comb.h"
#include "clustered/product/tiles/visibility.h"
#include "kinome/clustered_light.h"
#include "kinome/render_context.h"
#include "kinome/sampler.h"

namespace kinome {
namespace {

constexpr uint32_t kCells = 512;
constexpr size_t kCandidates = 1024;
constexpr uint32_t kPoints = 64;  ///< surface points, to which the candidates belong

/// An environment map of noise with a sun, in the layout of the plugin envmap.
class Sky final : public Emitter, public ClusteredLight {
 public:
  explicit Sky(int columns) : columns_(columns), rows_(columns / 2) {
    std::mt19937 rng(1);
    texels_.resize(static_cast<size_t>(columns_) * (rows_ + 1));
    for (Rgb& texel : texels_) texel = Rgb(0.5f + 0.5f * to_unit_float(rng()));
    const size_t sun = texels_.size() / 3;
    for (int i = 0; i < columns_ / 128; ++i) texels_[sun + i] = Rgb(5000, 4000, 3000);
  }
  bool is_environment() const override { return true; }
  Rgb eval_environment(const Vec3& /*d*/) const override { return Rgb(1); }
  std::optional<DirectSample> sample_direct(const Vec3&, const Vec2&) const override { return {}; }
  float pdf_environment(const Vec3&) const override { return 0; }
  std::optional<EnvironmentGrid> cell_grid() const override {
    EnvironmentGrid grid;
    grid.columns = columns_;
    grid.rows = rows_;
    grid.smooth_quads = grid.bilinear_quads = true;
    return grid;
  }
  bool eval_grid_batch(std::span<const Vec2> places, std::span<Rgb> radiance) const override {
    for (size_t i = 0; i < places.size(); ++i) {
      const int x = std::min(static_cast<int>(places[i].x), columns_ - 1);
      radiance[i] = texel(x, std::min(static_cast<int>(places[i].y), rows_));
    }
    return true;
  }
  bool eval_grid_corners(int row, int first, std::span<Rgb> radiance) const override {
    for (size_t i = 0; i < radiance.size(); ++i) {
      radiance[i] = texel((first + static_cast<int>(i)) % columns_, row);
    }
    return true;
  }

 private:
  const Rgb& texel(int x, int y) const { return texels_[static_cast<size_t>(y) * columns_ + x]; }
  int columns_, rows_;
  std::vector<Rgb> texels_;
};

const Scheduler& scheduler() {
  static const RenderContext instance({.threads = 2});
  return instance.scheduler;
}
DistantCells make_cells(const Sky& sky) {
  return {sky, *sky.cell_grid(), kCells, scheduler()};
}

std::vector<float> random_floats(size_t count, unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<float> values(count);
  for (float& v : values) v = to_unit_float(rng());
  return values;
}

/// Cells of a map with random visibility, and a patch that sees about 200 of them.
struct CellFixture {
  Sky sky{1024};
  DistantCells cells = make_cells(sky);
  size_t padded = cells.padded_size();
  simd::CellColumns columns;
  std::vector<float> visibility = random_floats(padded, 2);
  std::vector<float> sigma = random_floats(padded, 3);
  std::vector<float> p, sums, mixed;
  simd::PatchCells patch;
  std::vector<uint32_t> blocks;

  CellFixture() : p(2 * padded), sums(padded), mixed(padded) {
    columns.count = padded;
    for (int k = 0; k < 8; ++k) columns.edges[k] = cells.edges()[k].data();
    for (int k = 0; k < 3; ++k) {
      columns.axis[k] = cells.axis()[k].data();
      columns.importance_flux[k] = cells.importance_flux()[k].data();
    }
    for (int k = 0; k < 9; ++k) columns.vector_flux[k] = cells.vector_flux()[k].data();
    columns.radius = cells.radius().data();
    columns.flux = cells.flux().data();
    classify();
  }
  void classify() {
    const float normal[3] = {0.28f, 0.8f, 0.53f};
    cells.blocks().find_facing(Vec3(normal[0], normal[1], normal[2]), 0.1f, blocks);
    simd::classify_cells(columns, blocks, normal, 0.1f,
                         {visibility.data(), sigma.data(), sigma.data()}, nullptr, patch);
  }
};
CellFixture& cell_fixture() {
  static CellFixture instance;
  return instance;
}

void BM_ClassifyCells(benchmark::State& state) {
  CellFixture& f = cell_fixture();
  for (auto _ : state) {
    f.classify();
    benchmark::DoNotOptimize(f.patch);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(f.padded));
}
BENCHMARK(BM_ClassifyCells);

void BM_DiffuseStrata(benchmark::State& state) {
  CellFixture& f = cell_fixture();
  const simd::GroupNormal normal{{0.28f, 0.8f, 0.53f}, {0.28f, 0.8f, 0.53f}, 0.05f};
  float control[9], straddling[3];
  for (auto _ : state) {
    benchmark::DoNotOptimize(simd::diffuse_strata(f.patch, normal, 0.2f, f.p.data(), f.sums.data(),
                                                  f.mixed.data(), control, straddling));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(f.patch.above + f.patch.mixed));
}
BENCHMARK(BM_DiffuseStrata);

void BM_GlossyImportance(benchmark::State& state) {
  CellFixture& f = cell_fixture();
  const simd::GlossyQuery query{{0.28f, 0.8f, 0.53f}, {0, 0.6f, 0.8f}, 0.04f, 0.01f};
  for (auto _ : state) {
    benchmark::DoNotOptimize(simd::glossy_importance(f.columns, query, f.p.data(), f.sums.data()));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(f.padded));
}
BENCHMARK(BM_GlossyImportance);

/// Candidates in a lobe at kPoints points.
struct LobeFixture {
  simd::PointFrames frames;
  simd::MicrofacetPoints points;
  simd::HalfVectorLobe lobe{0.1f, 0.1f};
  std::vector<uint32_t> group, member, u1, u2;
  std::vector<float> d[3], f[3], density;

  LobeFixture() : group(kPoints), member(kCandidates), density(kCandidates) {
    frames.resize(kPoints);
    points.resize(kPoints);
    for (uint32_t i = 0; i < kPoints; ++i) {
      const float angle = 0.01f * static_cast<float>(i);
      const Vec3 normal(std::sin(angle), std::cos(angle), 0), tangent(0, 0, 1);
      const Vec3 viewer = glm::normalize(Vec3(0.5f, 0.7f, 0.2f));
      for (int axis = 0; axis < 3; ++axis) {
        frames.normal[axis][i] = normal[axis];
        frames.tangent[axis][i] = tangent[axis];
        frames.viewer[axis][i] = viewer[axis];
        points.specular[axis][i] = 1;
      }
      points.alpha_u[i] = points.alpha_v[i] = 0.1f;
    }
    for (uint32_t i = 0; i < kPoints; ++i) group[i] = i;
    for (uint32_t i = 0; i < kCandidates; ++i) {
      member[i] = i * 7 % kPoints;
      u1.push_back(i * 2654435769u);
      u2.push_back(i * 3242174889u);
    }
    for (int axis = 0; axis < 3; ++axis) {
      d[axis].resize(kCandidates);
      f[axis].resize(kCandidates);
    }
    sample();
  }
  void sample() {
    simd::sample_lobe(lobe, points_of_group(kPoints), member.data(), {u1.data(), u2.data(), {0, 0}},
                      kCandidates, d[0].data(), d[1].data(), d[2].data());
  }
  simd::PointGroup points_of_group(size_t count) const { return {frames, group.data(), count}; }
};
LobeFixture& lobe_fixture() {
  static LobeFixture instance;
  return instance;
}
void count_candidates(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kCandidates));
}

void BM_SampleLobe(benchmark::State& state) {
  LobeFixture& f = lobe_fixture();
  for (auto _ : state) {
    f.sample();
    benchmark::ClobberMemory();
  }
  count_candidates(state);
}
BENCHMARK(BM_SampleLobe);

void BM_LobeDensity(benchmark::State& state) {
  LobeFixture& f = lobe_fixture();
  for (auto _ : state) {
    simd::lobe_density(f.lobe, f.points_of_group(kPoints), f.member.data(), f.d[0].data(),
                       f.d[1].data(), f.d[2].data(), kCandidates, f.density.data());
    benchmark::ClobberMemory();
  }
  count_candidates(state);
}
BENCHMARK(BM_LobeDensity);

void BM_EvaluateMicrofacets(benchmark::State& state, bool is_conductor, bool alike) {
  LobeFixture& f = lobe_fixture();
  simd::MicrofacetKind kind;
  kind.is_ggx = true;
  kind.is_conductor = is_conductor;
  for (int c = 0; c < 3; ++c) {
    kind.eta[c] = is_conductor ? 0.2f : 1.5f;
    kind.k[c] = is_conductor ? 3.9f : 0.f;
  }
  const simd::FirstMicrofacet first{0.1f, 0.1f, {1, 1, 1}};
  for (auto _ : state) {
    simd::evaluate_microfacets(kind, first, alike ? nullptr : &f.points, f.lobe,
                               f.points_of_group(kPoints), f.member.data(), f.d[0].data(),
                               f.d[1].data(), f.d[2].data(), kCandidates,
                               {{f.f[0].data(), f.f[1].data(), f.f[2].data()}, f.density.data()});
    benchmark::ClobberMemory();
  }
  count_candidates(state);
}
BENCHMARK_CAPTURE(BM_EvaluateMicrofacets, dielectric, false, true);
BENCHMARK_CAPTURE(BM_EvaluateMicrofacets, conductor, true, true);
BENCHMARK_CAPTURE(BM_EvaluateMicrofacets, textured_conductor, true, false);

void BM_WeighCandidates(benchmark::State& state) {
  CellFixture& f = cell_fixture();
  const std::vector<float> values = random_floats(4 * kCandidates, 6);
  std::vector<uint32_t> cell(kCandidates);
  for (size_t i = 0; i < kCandidates; ++i) cell[i] = static_cast<uint32_t>(i * 11 % kCells);
  std::vector<float> density, weight[3], uncertainty(kCandidates), sums(kCandidates);
  for (auto& w : weight) w.resize(kCandidates);
  const float* const v = values.data();
  const simd::CandidateQuery query{
      f.sigma.data(), 0.01f, 64, 256, 4, {f.visibility.data(), f.sigma.data()}};
  float control[3];
  for (auto _ : state) {
    density.assign(v, v + kCandidates);  // weigh_candidates() overwrites it
    simd::weigh_candidates({{{v, v, v},
                             v + kCandidates,
                             cell.data(),
                             {weight[0].data(), weight[1].data(), weight[2].data()},
                             uncertainty.data()},
                            density.data(),
                            v},
                           query, kCandidates, control, sums.data());
    benchmark::ClobberMemory();
  }
  count_candidates(state);
}
BENCHMARK(BM_WeighCandidates);

void BM_FindPlaces(benchmark::State& state) {
  LobeFixture& f = lobe_fixture();
  const simd::SphereGrid grid{{1, 0, 0, 0, 1, 0, 0, 0, 1}, 1024, 512, 0.5f};
  std::vector<float> places(2 * kCandidates);
  std::vector<uint32_t> quads(kCandidates);
  for (auto _ : state) {
    simd::find_places(grid, f.d[0].data(), f.d[1].data(), f.d[2].data(), kCandidates, places.data(),
                      quads.data());
    benchmark::ClobberMemory();
  }
  count_candidates(state);
}
BENCHMARK(BM_FindPlaces);

/// Cell, density and radiance of each candidate. The directions of a lobe are close together.
void BM_LookUp(benchmark::State& state) {
  LobeFixture& f = lobe_fixture();
  const DistantCells& cells = cell_fixture().cells;
  std::vector<uint32_t> cell(kCandidates);
  std::vector<float> density(kCandidates);
  std::vector<Rgb> radiance(kCandidates);
  for (auto _ : state) {
    cells.look_up(
        {f.d[0].data(), f.d[1].data(), f.d[2].data(), cell.data(), density.data(), radiance.data()},
        kCandidates);
    benchmark::ClobberMemory();
  }
  count_candidates(state);
}
BENCHMARK(BM_LookUp);

/// Teeth of a comb over the strata of one group.
void BM_Comb(benchmark::State& state) {
  CellFixture& f = cell_fixture();
  const auto teeth = static_cast<size_t>(state.range(0));
  float total = 0;
  for (size_t block = 0; block < f.padded / simd::kCellLanes; ++block) {
    const float* const first = f.sigma.data() + block * simd::kCellLanes;
    total += f.sums[block] = std::accumulate(first, first + simd::kCellLanes, 0.f);
  }
  std::vector<Comb::Hit> hits;
  for (auto _ : state) {
    hits.clear();
    Comb comb(total, teeth, 0.3);
    comb.pass(f.sigma.data(), f.sums.data(), f.padded, hits);
    benchmark::DoNotOptimize(hits.data());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_Comb)->Arg(16)->Arg(64)->Arg(256);

/// Visibility records of the 25 tiles from which a patch learns.
void BM_VisibilityLearner(benchmark::State& state) {
  constexpr size_t kRecords = 25 * 96;
  std::mt19937 rng(8);
  std::vector<VisibilityRecord> records;
  for (size_t i = 0; i < kRecords; ++i) records.emplace_back(rng() % kCells, rng() % 2 == 0);
  VisibilityLearner learner(padded(kCells));
  Visibility out(padded(kCells));
  for (auto _ : state) {
    learner.begin();
    learner.add(records, 16);
    learner.finish(out);
    benchmark::DoNotOptimize(out.v.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kRecords));
}
BENCHMARK(BM_VisibilityLearner);

/// Cells of a map, on two threads. The argument is the number of columns of the map.
void BM_BuildCells(benchmark::State& state) {
  const Sky sky(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(make_cells(sky).size());
}
BENCHMARK(BM_BuildCells)->Arg(1024)->Arg(8192)->Unit(benchmark::kMillisecond)->UseRealTime();

void BM_DrawPoints(benchmark::State& state) {
  const DistantCells& cells = cell_fixture().cells;
  uint64_t seed = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(cells.draw_points(1u << 15, ++seed, scheduler()).points.data());
  }
  state.SetItemsProcessed(state.iterations() << 15);
}
BENCHMARK(BM_DrawPoints)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace kinome
