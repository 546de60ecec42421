#include "clustered/product/strata/glossy_strata.h"

#include <algorithm>
#include <iterator>

#include "clustered/cells/hilbert_points.h"

namespace kinome {
namespace {

constexpr uint32_t kMinFromCells = 4;
constexpr uint32_t kMaxFromCells = 1024;
/// Numbers of candidates of a pilot's group. Sharp lobes get fewer, because they have many groups.
constexpr GlossyStrata::Counts kPilotCounts = {7, 64}, kPilotSharpCounts = {5, 16};
/// Shares of candidates from the cells among which the pilot selects.
constexpr float kCellShares[] = {0.05f, 0.2f, 0.4f, 0.6f, 0.8f, 0.93f};
/// Distance of prefetching, in rays. Surface points don't all fit into the nearest cache.
constexpr size_t kPrefetchDistance = 8;

}  // namespace

GlossyStrata::GlossyStrata(const CellLight& light)
    : light_(light), shared_(light), importance_(light) {}

GlossyStrata::Counts GlossyStrata::counts(const Patch& patch, float candidates) {
  return {HilbertPoints::nearest_log2(candidates * (1 - patch.cell_share)),
          std::clamp(static_cast<uint32_t>(candidates * patch.cell_share), kMinFromCells,
                     kMaxFromCells)};
}

GlossyStrata::Counts GlossyStrata::pilot_counts(const Patch& patch) {
  return is_sharp(patch) ? kPilotSharpCounts : kPilotCounts;
}

/// Draws half vectors of a GGX distribution for any BSDF. Its tails are heavy, so that no light of
/// the BSDF is sampled rarely.
void GlossyStrata::draw_from_lobe(const GroupView& group, uint32_t lobe_log2, uint64_t seed) {
  const size_t first = first_;
  const uint32_t count = 1u << lobe_log2;
  const auto points = HilbertPoints::get().power_of_two(lobe_log2);
  const uint64_t shift = hash_words(seed, 1);
  const uint32_t start = random_bits(seed, 0);
  for (uint32_t j = 0; j < count; ++j) {
    candidates_.member[first + j] = group.pick(start + j * kGolden);
  }
  float* const dx = &candidates_.dx[first];
  float* const dy = &candidates_.dy[first];
  float* const dz = &candidates_.dz[first];
  simd::sample_lobe(group.patch.lobe, group.points(), &candidates_.member[first],
                    {points.x.data(),
                     points.y.data(),
                     {static_cast<uint32_t>(shift), static_cast<uint32_t>(shift >> 32)}},
                    count, dx, dy, dz);
  light_.cells.look_up({dx, dy, dz, &candidates_.cell[first], &candidates_.cell_density[first],
                        &candidates_.radiance[first]},
                       count);
}

/// Draws cells in proportion to their importance, with a comb.
void GlossyStrata::draw_from_cells(const GroupView& group, size_t first, uint32_t count,
                                   uint64_t seed) {
  const auto hits = importance_.draw(count, random_float(seed, 2));
  const uint32_t start = random_bits(seed, 3);
  for (size_t j = 0; j < padded(count); ++j) {
    const size_t i = first + j;
    candidates_.member[i] = group.pick(start + static_cast<uint32_t>(j) * kPlastic);
    if (j < hits.size()) {
      candidates_.put_point(i, light_.points.pick(hits[j].stratum, hits[j].remainder));
    } else {
      candidates_.put_nothing(i, group.normal(candidates_.member[i]));
    }
  }
}

Rgb GlossyStrata::add(const GroupView& group, float candidates, uint64_t seed, Strata& strata) {
  if (const SharedCandidates::Set* const set = shared_.find(group)) {
    return take(group, *set, SharedCandidates::blocks_for(*set, candidates), seed, strata);
  }
  return add(group, counts(group.patch, candidates), seed, strata);
}

/// Adds `blocks` blocks of the shared candidates, starting at a random one.
Rgb GlossyStrata::take(const GroupView& group, const SharedCandidates::Set& set, uint32_t blocks,
                       uint64_t seed, Strata& strata) {
  DistantCandidates& c = candidates_;
  const size_t first = c.size(), size = blocks * set.size;
  first_ = first;
  c.resize(first + size);
  const uint32_t begin = scaled(random_bits(seed, 4), set.blocks);
  const auto block_of = [&](uint32_t k) { return (begin + k) % set.blocks; };
  for (uint32_t k = 0; k < blocks; ++k) {
    const Directions from = shared_.directions(set, block_of(k));
    const size_t to = first + k * set.size;
    std::copy_n(from.dx, set.size, &c.dx[to]);
    std::copy_n(from.dy, set.size, &c.dy[to]);
    std::copy_n(from.dz, set.size, &c.dz[to]);
    std::copy_n(shared_.cells(set, block_of(k)), set.size, &c.cell[to]);
  }
  const uint32_t start = random_bits(seed, 0);
  for (size_t j = 0; j < size; ++j) {
    c.member[first + j] = group.pick(start + static_cast<uint32_t>(j) * kGolden);
  }
  values_.glossy(group, c.directions(first), c.lobe_columns(first));
  const Strata::Columns columns = strata.append(Strata::Kind::kGlossy, group.index, size, first);
  const Rgb variate = shared_.variate(group), mean = variate * set.mean;
  const auto share = 1 / static_cast<float>(blocks);
  const simd::TakenQuery query{static_cast<float>(group.group.count) * share,
                               {variate.x * share, variate.y * share, variate.z * share}};
  float control[3] = {mean.x, mean.y, mean.z};
  for (uint32_t k = 0; k < blocks; ++k) {
    const size_t i = first + k * set.size, stratum = k * set.size;
    simd::weigh_taken({{&c.f[0][i], &c.f[1][i], &c.f[2][i]},
                       shared_.values(set, block_of(k)),
                       {&c.weight[0][i], &c.weight[1][i], &c.weight[2][i]},
                       columns.weights + stratum},
                      query, set.size, control, columns.block_sums + stratum / simd::kCellLanes);
  }
  return {control[0], control[1], control[2]};
}

Rgb GlossyStrata::add(const GroupView& group, const Counts& counts, uint64_t seed, Strata& strata) {
  DistantCandidates& c = candidates_;
  const Group& points = group.group;
  importance_.find({points.normal, points.viewer, points.cosine, group.patch.alpha2()});
  drawn_ = {1u << counts.lobe_log2, importance_.total() > 0 ? counts.from_cells : 0};
  const size_t first = first_ = c.size();
  const size_t size = drawn_.from_lobe + padded(drawn_.from_cells);
  c.resize(first + size);
  draw_from_lobe(group, counts.lobe_log2, seed);
  if (drawn_.from_cells > 0) {
    draw_from_cells(group, first + drawn_.from_lobe, drawn_.from_cells, seed);
  }
  values_.glossy(group, c.directions(first), c.lobe_columns(first));
  const Strata::Columns columns = strata.append(Strata::Kind::kGlossy, group.index, size, first);
  const simd::CandidateQuery query{importance_.values(),
                                   importance_.inverse_total(),
                                   static_cast<float>(drawn_.from_cells),
                                   static_cast<float>(drawn_.from_lobe),
                                   static_cast<float>(group.group.count),
                                   {group.visibility.v.data(), group.visibility.sigma.data()}};
  float control[3];
  simd::weigh_candidates(
      {c.weight_columns(first, columns.weights), &c.cell_density[first], &c.lobe_density[first]},
      query, size, control, columns.block_sums);
  return {control[0], control[1], control[2]};
}

void GlossyStrata::plan(const GroupView& group, Patch& patch, std::span<PointPlan> points) const {
  const double n_lobe = drawn_.from_lobe, n_cells = drawn_.from_cells;
  const double n = n_lobe + n_cells;
  double sum = 0, squares = 0;
  double moments[std::size(kCellShares)] = {};
  for (size_t i = first_; i < candidates_.size(); ++i) {
    const double w = mean_of(candidates_.weight_of(i));
    const double from_cell = candidates_.cell_density[i], from_lobe = candidates_.lobe_density[i];
    sum += w;
    squares += w * w;
    const double density = n_cells * from_cell + n_lobe * from_lobe;
    if (!(w != 0 && density > 0)) continue;
    for (size_t k = 0; k < std::size(kCellShares); ++k) {
      const double mixed = n * (kCellShares[k] * from_cell + (1 - kCellShares[k]) * from_lobe);
      if (mixed > 0) moments[k] += w * w * density / mixed;
    }
  }
  const size_t best = std::min_element(std::begin(moments), std::end(moments)) - moments;
  if (squares > 0) squares = std::min(squares, moments[best]);
  const uint32_t members = group.group.count;
  const double count = members;
  const auto mean = static_cast<float>(sum / count);
  const double variance = std::max(0., squares * n - sum * sum) / (count * count);
  const float share = static_cast<float>(members) / static_cast<float>(patch.count);
  patch.glossy += mean * share;
  patch.cell_share += (kCellShares[best] - 0.5f) * share;
  for (uint32_t j = 0; j < members; ++j) {
    PointPlan& point = points[group.primary(j)];
    point.glossy = mean;
    point.glossy_variance = variance;
  }
}

void GlossyStrata::shoot(const GroupView& group, const SegmentHits& segment, const Answers& answers,
                         ShadowRays& rays) const {
  const std::span<const Comb::Hit> hits = segment.hits;
  const size_t first = segment.segment.first;
  for (size_t j = 0; j < hits.size(); ++j) {
    if (j + kPrefetchDistance < hits.size()) {
      const size_t later = first + hits[j + kPrefetchDistance].stratum;
      group.primaries.prefetch(group.primary(candidates_.member[later]));
    }
    const uint32_t stratum = hits[j].stratum;
    const size_t i = first + stratum;
    const uint32_t cell = candidates_.cell[i];
    const Rgb weight = candidates_.weight_of(i) * (segment.step / segment.weights[stratum]);
    const uint32_t primary = group.primary(candidates_.member[i]);
    if (answers.sums) answers.sums.of(primary) -= group.visibility.v[cell] * weight;
    rays.push(group.primaries.place(primary), candidates_.direction(i),
              {weight, cell, group.group.patch, primary}, answers);
  }
}

}  // namespace kinome
