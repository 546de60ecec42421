// The glossy part of Estimator: unshadowed candidates.
#include <algorithm>
#include <cmath>

#include "clustered/cells/hilbert_points.h"
#include "clustered/product/estimator.h"
#include "clustered/product/spread.h"

namespace kinome {
namespace {

constexpr uint32_t kMinLobeLog2 = 4;
constexpr uint32_t kMinFromCells = 4;
constexpr uint32_t kMaxFromCells = 1024;
/// Of a pilot's group: enough to tell variances. Sharp lobes have many groups.
constexpr uint32_t kProbeLobeLog2 = 7;
constexpr uint32_t kProbeFromCells = 64;
constexpr uint32_t kProbeSharpLobeLog2 = 5;
constexpr uint32_t kProbeSharpFromCells = 16;
/// Shares of candidates from the cells that the pilot chooses among.
constexpr float kCellShares[] = {0.05f, 0.2f, 0.4f, 0.6f, 0.8f, 0.93f};

}  // namespace

void Estimator::Candidates::resize(size_t size) {
  size_ = size;
  if (size <= member.size()) return;
  size = std::max(size, 2 * member.size());
  member.resize(size);
  cell.resize(size);
  point.resize(size);
  for (auto* const v : {&dx, &dy, &dz, &cell_density, &lobe_density, &distance, &eye_ratio, &f[0],
                        &f[1], &f[2], &weight[0], &weight[1], &weight[2]}) {
    v->resize(size);
  }
  radiance.resize(size);
}

void Estimator::Shots::clear() {
  member.clear();
  cell.clear();
  weight.clear();
  for (auto* const v : {&dx, &dy, &dz}) v->clear();
}

void Estimator::Shots::push_back(uint32_t to_member, uint32_t to_cell, const Vec3& d,
                                 const Rgb& weight_of_f) {
  member.push_back(to_member);
  cell.push_back(to_cell);
  dx.push_back(d.x);
  dy.push_back(d.y);
  dz.push_back(d.z);
  weight.push_back(weight_of_f);
}

Estimator::AskedDirections Estimator::Shots::asked() {
  for (auto& v : f) v.resize(member.size());
  return {member.data(), dx.data(), dy.data(), dz.data(), {f[0].data(), f[1].data(), f[2].data()},
          member.size()};
}

/// Half vectors as of GGX, whatever the BSDF: its tails are heavy, so that none of the BSDF's light
/// is rare.
void Estimator::draw_from_lobe(const Group& group, size_t first, uint32_t lobe_log2,
                               uint64_t seed) {
  const uint32_t count = 1u << lobe_log2;
  const auto points = HilbertPoints::get().power_of_two(lobe_log2);
  const uint64_t shift = hash_words(seed, 1);
  const uint32_t start = random_bits(seed, 0);
  for (uint32_t j = 0; j < count; ++j) {
    candidates_.member[first + j] = pick(group, start + j * kGolden);
  }
  float* const dx = &candidates_.dx[first];
  float* const dy = &candidates_.dy[first];
  float* const dz = &candidates_.dz[first];
  simd::sample_lobe((*patches_)[group.patch].lobe, points_of(group), &candidates_.member[first],
                    {points.x.data(),
                     points.y.data(),
                     {static_cast<uint32_t>(shift), static_cast<uint32_t>(shift >> 32)}},
                    count, dx, dy, dz);
  light_.cells.look_up({dx, dy, dz, &candidates_.cell[first], &candidates_.cell_density[first],
                        &candidates_.radiance[first]},
                       count);
}

/// Of importance_, by a comb.
void Estimator::draw_from_cells(const Group& group, size_t first, uint32_t count, uint64_t seed) {
  double total = 0;
  for (const float sum : importance_blocks_) total += sum;
  Comb comb(total, count, random_float(seed, 2));
  hits_.clear();
  comb.pass(importance_.data(), importance_blocks_.data(), importance_.size(), hits_);
  const uint32_t start = random_bits(seed, 3);
  for (const Comb::Hit& hit : hits_) {
    __builtin_prefetch(&light_.points.pick(hit.stratum, hit.remainder));
  }
  for (size_t j = 0; j < simd::pad_lanes(count); ++j) {
    const size_t i = first + j;
    candidates_.member[i] = pick(group, start + static_cast<uint32_t>(j) * kPlastic);
    if (j >= hits_.size()) {  // padding
      const Vec3& n = primaries_->normal[member_of(group, candidates_.member[i])];
      candidates_.dx[i] = n.x;
      candidates_.dy[i] = n.y;
      candidates_.dz[i] = n.z;
      candidates_.cell[i] = 0;
      candidates_.cell_density[i] = 0;
      candidates_.radiance[i] = Rgb(0.f);
      continue;
    }
    const uint32_t cell = hits_[j].stratum;
    const CellPoint& point = light_.points.pick(cell, hits_[j].remainder);
    candidates_.dx[i] = point.d.x;
    candidates_.dy[i] = point.d.y;
    candidates_.dz[i] = point.d.z;
    candidates_.cell[i] = cell;
    candidates_.cell_density[i] = point.density;
    candidates_.radiance[i] = point.weight * point.density;
  }
}

/// Draws the group's candidates, and returns the first one's index.
size_t Estimator::draw_candidates(const Group& group, uint32_t lobe_log2, uint32_t from_cells,
                                  uint64_t seed) {
  const size_t first = candidates_.size();
  const Patch& patch = (*patches_)[group.patch];
  simd::GlossyQuery query;
  for (int axis = 0; axis < 3; ++axis) {
    query.normal[axis] = group.normal[axis];
    query.viewer[axis] = group.viewer[axis];
  }
  // Wider than the lobe: its tails matter where the light is bright.
  query.alpha2 = patch.alpha2() * 4;
  query.spread = std::clamp(1 - group.cosine, 0.f, 2.f);
  importance_total_ =
      simd::glossy_importance(light_.columns, query, importance_.data(), importance_blocks_.data());
  const uint32_t lobe = 1u << lobe_log2;
  const uint32_t cells = importance_total_ > 0 ? from_cells : 0;
  candidates_.resize(first + lobe + simd::pad_lanes(cells));
  draw_from_lobe(group, first, lobe_log2, seed);
  if (cells > 0) draw_from_cells(group, first + lobe, cells, seed);
  evaluate_candidates(group, first);
  return first;
}

/// Each point's directions together: its parameters are read once.
void Estimator::ask(const Group& group, Lobe mask, const AskedDirections& asked) {
  evaluation_first_.assign(group.count + 1, 0);
  for (size_t j = 0; j < asked.count; ++j) ++evaluation_first_[asked.member[j] + 1];
  for (size_t k = 0; k < group.count; ++k) evaluation_first_[k + 1] += evaluation_first_[k];
  evaluation_order_.resize(asked.count);
  for (auto* const v : {&x_, &y_, &z_, &r_, &g_, &b_}) {
    if (v->size() < asked.count) v->resize(asked.count);
  }
  for (size_t j = 0; j < asked.count; ++j) {
    const uint32_t at = evaluation_first_[asked.member[j]]++;
    evaluation_order_[at] = static_cast<uint32_t>(j);
    const Vec3 d = primaries_->interaction(member_of(group, asked.member[j]))
                       .frame.to_local({asked.dx[j], asked.dy[j], asked.dz[j]});
    x_[at] = d.x;
    y_[at] = d.y;
    z_[at] = d.z;
  }
  size_t begin = 0;
  for (uint32_t k = 0; k < group.count; ++k) {
    const size_t end = evaluation_first_[k];
    if (end == begin) continue;
    const SurfaceInteraction& si = primaries_->interaction(member_of(group, k));
    si.shape->bsdf().eval_pdf(si, mask, {&x_[begin], &y_[begin], &z_[begin], end - begin},
                              {&r_[begin], &g_[begin], &b_[begin], nullptr});
    begin = end;
  }
  for (size_t at = 0; at < asked.count; ++at) {
    const uint32_t j = evaluation_order_[at];
    asked.f[0][j] = r_[at];
    asked.f[1][j] = g_[at];
    asked.f[2][j] = b_[at];
  }
}

/// Candidates from `first` on, by their BSDFs, with the density of the patch's lobe.
void Estimator::ask_for_candidates(const Group& group, Lobe mask, size_t first) {
  Candidates& c = candidates_;
  const size_t count = c.size() - first;
  simd::lobe_density((*patches_)[group.patch].lobe, points_of(group), &c.member[first],
                     &c.dx[first], &c.dy[first], &c.dz[first], count, &c.lobe_density[first]);
  ask(group, mask,
      {&c.member[first],
       &c.dx[first],
       &c.dy[first],
       &c.dz[first],
       {&c.f[0][first], &c.f[1][first], &c.f[2][first]},
       count});
}

void Estimator::evaluate_candidates(const Group& group, size_t first) {
  const Patch& patch = (*patches_)[group.patch];
  Candidates& c = candidates_;
  const size_t count = c.size() - first;
  if (!patch.is_described || !is_microfacet(patch.form)) {
    ask_for_candidates(group, Lobe::kGlossy, first);
    return;
  }
  const BsdfForm& form = patch.form;
  simd::evaluate_microfacets(
      kind_of(form), microfacet_of(form), patch.is_uniform ? nullptr : &primaries_->microfacets,
      patch.lobe, points_of(group), &c.member[first], &c.dx[first], &c.dy[first], &c.dz[first],
      count, {{&c.f[0][first], &c.f[1][first], &c.f[2][first]}, &c.lobe_density[first]});
  if (form.is_turned) {
    float* const f[3] = {&c.f[0][first], &c.f[1][first], &c.f[2][first]};
    simd::multiply_turned_factors(primaries_->turned, points_of(group), &c.member[first],
                                  &c.dx[first], &c.dy[first], &c.dz[first], count, f);
  }
}

/// Strata of the group's candidates; returns their control terms.
Rgb Estimator::add_glossy_segment(uint32_t index, size_t first, uint32_t lobe,
                                  uint32_t from_cells) {
  const Group& group = groups_[index];
  const Visibility& visibility = visibility_[group.patch];
  Candidates& c = candidates_;
  const Segment segment{Strata::kGlossy, index, weights_.size(), c.size() - first, first};
  weights_.resize(segment.begin + segment.size);
  block_sums_.resize(weights_.size() / simd::kCellLanes);
  const bool has_cells = importance_total_ > 0;
  const simd::CandidateQuery query{importance_.data(),
                                   has_cells ? 1 / importance_total_ : 0.f,
                                   has_cells ? static_cast<float>(from_cells) : 0.f,
                                   static_cast<float>(lobe),
                                   static_cast<float>(group.count),
                                   {visibility.v.data(), visibility.sigma.data()}};
  const simd::CandidateColumns columns{c.weight_columns(first, &weights_[segment.begin]),
                                       &c.cell_density[first], &c.lobe_density[first]};
  float control[3];
  simd::weigh_candidates(columns, query, segment.size, control,
                         &block_sums_[segment.begin / simd::kCellLanes]);
  segments_.push_back(segment);
  return {control[0], control[1], control[2]};
}

void Estimator::add_glossy(uint32_t index, const Unit& unit, Rgb& control) {
  const Group& group = groups_[index];
  const Patch& patch = (*patches_)[group.patch];
  if (light_.columns.count == 0 || !any(patch.bsdf->lobes() & Lobe::kGlossy)) return;
  const StageScope timer(innermost_stage_, *stages_.candidates);
  const float wanted =
      unit.candidates * static_cast<float>(group.count) / static_cast<float>(order_.size());
  uint32_t lobe_log2 = kMinLobeLog2;
  const float from_lobe = wanted * (1 - patch.cell_share);
  while (lobe_log2 < HilbertPoints::kMaxLog2 &&
         static_cast<float>(1u << lobe_log2) * 1.4142f < from_lobe) {
    ++lobe_log2;
  }
  const auto from_cells =
      std::clamp(static_cast<uint32_t>(wanted * patch.cell_share), kMinFromCells, kMaxFromCells);
  const size_t first =
      draw_candidates(group, lobe_log2, from_cells, hash_words(unit.seed, 4, index));
  control += add_glossy_segment(index, first, 1u << lobe_log2, from_cells);
}

void Estimator::probe_glossy(uint32_t index, const Unit& unit, std::span<PointPlan> points) {
  const Group& group = groups_[index];
  Patch& patch = (*patches_)[group.patch];
  if (light_.columns.count == 0 || !any(patch.bsdf->lobes() & Lobe::kGlossy)) return;
  const StageScope timer(innermost_stage_, *stages_.candidates);
  const uint32_t lobe_log2 = is_sharp(patch) ? kProbeSharpLobeLog2 : kProbeLobeLog2;
  const uint32_t from_cells = is_sharp(patch) ? kProbeSharpFromCells : kProbeFromCells;
  const size_t first =
      draw_candidates(group, lobe_log2, from_cells, hash_words(unit.seed, 4, index));
  add_glossy_segment(index, first, 1u << lobe_log2, from_cells);
  plan_glossy(group, first, 1u << lobe_log2, from_cells, points);
}

/// Mean and variance of the unshadowed glossy light, and the share of candidates from the cells
/// that would have had the least second moment.
void Estimator::plan_glossy(const Group& group, size_t first, uint32_t lobe, uint32_t from_cells,
                            std::span<PointPlan> points) {
  Patch& patch = (*patches_)[group.patch];
  const auto n_lobe = static_cast<double>(lobe);
  const double n_cells = importance_total_ > 0 ? from_cells : 0;
  const double n = n_lobe + n_cells;
  double sum = 0, squares = 0;
  double moments[std::size(kCellShares)] = {};
  for (size_t i = first; i < candidates_.size(); ++i) {
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
  const double count = group.count;
  const auto mean = static_cast<float>(sum / count);
  const double variance = std::max(0., squares * n - sum * sum) / (count * count);
  const float share = static_cast<float>(group.count) / static_cast<float>(patch.count);
  patch.glossy += mean * share;
  patch.cell_share += (kCellShares[best] - 0.5f) * share;
  for (uint32_t j = 0; j < group.count; ++j) {
    PointPlan& point = points[order_[group.first + j]];
    point.glossy = mean;
    point.glossy_variance = variance;
  }
}

}  // namespace kinome
