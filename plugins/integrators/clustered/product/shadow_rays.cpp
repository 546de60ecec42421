// The part of Estimator that decides where shadow rays go, and sends them.
#include <algorithm>
#include <cmath>

#include "clustered/product/estimator.h"
#include "clustered/product/spread.h"

namespace kinome {
namespace {

/// Rounds in which candidates that weigh more than a ray are found, and what rounding may add up
/// to.
constexpr int kCapRounds = 6;
constexpr double kNegligible = 1e-6;
/// Points of cells, and surface points, don't all fit the nearest cache: what a ray takes is
/// fetched while those before it are made.
constexpr size_t kAhead = 8;

}  // namespace

/// Made in its place: to copy a ray takes longer than to make it.
void Estimator::push_ray(uint32_t primary, const Vec3& d, const Rgb& weight, uint32_t cell,
                         Rgb* sum) {
  if (is_black(weight)) {
    ++counters_->skipped_shadow_rays;
    return;
  }
  Ray& ray = rays_[waiting_];
  ray.o = primaries_->interaction(primary).ray_origin(d);
  ray.d = d;
  ray.tmin = 0;
  ray.tmax = kInfinity;
  note_pending(weight, cell, primaries_->patch[primary], sum);
}

void Estimator::push_shadow_ray(const Ray& ray, const Rgb& weight, uint32_t cell, int32_t patch,
                                Rgb* sum) {
  if (is_black(weight)) {
    ++counters_->skipped_shadow_rays;
    return;
  }
  rays_[waiting_] = ray;
  note_pending(weight, cell, patch, sum);
}

/// What the ray that comes next is for.
void Estimator::note_pending(const Rgb& weight, uint32_t cell, int32_t patch, Rgb* sum) {
  Pending& pending = pending_[waiting_];
  pending.weight = weight;
  pending.cell = cell;
  if (is_probing_) {
    pending.records = &records_[patch];
  } else {
    pending.sum = sum;
  }
  if (++waiting_ == rays_.size()) trace_shadow_rays();
}

/// The ray to a lamp that was made last says what its point sees of it.
void Estimator::note_lamp(size_t candidate, uint32_t primary) {
  PointPlan& point = probed_[primary];
  const float radiance = mean_of(candidates_.weight_of(candidate));
  point.lamps -= radiance;
  lit_[waiting_] = {point.lit, radiance};
}

void Estimator::flush() {
  trace_eye_rays();
  trace_shadow_rays();
}

void Estimator::trace_shadow_rays() {
  if (waiting_ == 0) return;
  const StageScope timer(innermost_stage_, *stages_.shadow);
  scene_->occluded({rays_.data(), waiting_}, Coherence::kIncoherent, *counters_);
  (*counters_)[RayKind::kShadow] += waiting_;
  for (size_t i = 0; i < waiting_; ++i) {
    const bool visible = !rays_[i].is_occluded();
    const Pending& p = pending_[i];
    if (is_probing_) {
      p.records->push_back(VisibilityRecord(p.cell, visible));
      if (visible && lit_[i].sum) *lit_[i].sum += lit_[i].radiance;
      lit_[i] = {};
    } else if (visible) {
      *p.sum += p.weight;
    }
  }
  waiting_ = 0;
}

float Estimator::turned_factor(uint32_t primary, const Vec3& d) const {
  const simd::TurnedPoints& turned = primaries_->turned;
  const float cosine = turned.normal[0][primary] * d.x + turned.normal[1][primary] * d.y +
                       turned.normal[2][primary] * d.z;
  return cosine > 0 ? bump_shadowing(cosine, turned.bump_alpha2[primary]) : 0.f;
}

void Estimator::shoot_diffuse(const Segment& segment, float scale, uint32_t offset,
                              size_t first_hit, Rgb* sum) {
  const Group& group = groups_[segment.group];
  const Patch& patch = (*patches_)[group.patch];
  const Prepared& prepared = prepared_[group.patch];
  const Visibility& visibility = visibility_[group.patch];
  const float* const table = patch.form.transmittance;
  const auto count = static_cast<float>(group.count);
  const uint32_t* const ids = prepared.cells.ids();
  const auto point_of = [&](size_t j) -> const CellPoint& {
    return light_.points.pick(ids[hits_[j].stratum], hits_[j].remainder);
  };
  const auto member_at = [&](size_t j) {
    return pick(group, offset + static_cast<uint32_t>(first_hit + j) * kPlastic);
  };
  shots_.clear();
  for (size_t j = 0; j < hits_.size(); ++j) {
    if (j + kAhead < hits_.size()) {
      __builtin_prefetch(&point_of(j + kAhead));
      __builtin_prefetch(&primaries_->interaction(member_of(group, member_at(j + kAhead))));
    }
    const uint32_t stratum = hits_[j].stratum;
    const uint32_t cell = ids[stratum];
    const CellPoint& point = point_of(j);
    const uint32_t member = member_at(j);
    const uint32_t primary = member_of(group, member);
    const float factor = count * scale / weights_[segment.begin + stratum];
    float v = visibility.v[cell];
    if (!prepared.transmittance.empty()) v *= prepared.transmittance[cell];
    if (stratum >= prepared.cells.above) {
      v = mixed_visibility_[segment.other + stratum - prepared.cells.above];
    }
    const float cosine = glm::dot(primaries_->normal[primary], point.d);
    const Rgb lambert = primaries_->diffuse[primary] * (kInvPi * cosine * factor) * point.weight;
    if (sum) *sum -= v * lambert;
    if (patch.is_described) {
      float t = table ? interpolate_transmittance(table, cosine) : 1.f;
      if (patch.form.is_turned) t *= turned_factor(primary, point.d);
      if (cosine > 0) push_ray(primary, point.d, lambert * t, cell, sum);
    } else {
      shots_.push_back(member, cell, point.d, point.weight * factor);
    }
  }
  if (patch.is_described) return;
  ask(group, Lobe::kDiffuse, shots_.asked());
  for (size_t j = 0; j < shots_.member.size(); ++j) {
    push_ray(member_of(group, shots_.member[j]), {shots_.dx[j], shots_.dy[j], shots_.dz[j]},
             shots_.weight[j] * Rgb(shots_.f[0][j], shots_.f[1][j], shots_.f[2][j]), shots_.cell[j],
             sum);
  }
}

void Estimator::shoot_glossy(const Segment& segment, float scale, Rgb* sum) {
  const Group& group = groups_[segment.group];
  const Visibility& visibility = visibility_[group.patch];
  const auto primary_of = [&](size_t i) { return member_of(group, candidates_.member[i]); };
  for (size_t j = 0; j < hits_.size(); ++j) {
    if (j + kAhead < hits_.size()) {
      const size_t later = segment.other + hits_[j + kAhead].stratum;
      __builtin_prefetch(&primaries_->interaction(primary_of(later)));
    }
    const uint32_t stratum = hits_[j].stratum;
    const size_t i = segment.other + stratum;
    const uint32_t cell = candidates_.cell[i];
    const Rgb weight = candidates_.weight_of(i) * (scale / weights_[segment.begin + stratum]);
    if (sum) *sum -= visibility.v[cell] * weight;
    push_ray(primary_of(i), candidates_.direction(i), weight, cell, sum);
  }
}

/// A candidate is one direction: a second ray along it would tell nothing new. Weights of
/// candidates above the comb's step are lowered to it, so that each gets one ray, and the others
/// get more. Strata of cells, which hold many directions, stay. Returns the step.
double Estimator::cap_candidates(size_t rays) {
  double total = 0;
  for (const float block : block_sums_) total += block;
  if (!(total > 0)) return 0;
  double step = total / static_cast<double>(rays);
  size_t capped = 0;
  for (int i = 0; i < kCapRounds; ++i) {
    const auto [count, sum] = heavier_candidates(step);
    if (count == capped) break;
    capped = count;
    const double left = total - sum;
    // Nothing but candidates, and a ray for each of them.
    if (capped >= rays || !(left > kNegligible * total)) break;
    step = left / static_cast<double>(rays - capped);
  }
  if (capped == 0) return step;
  const auto cap = static_cast<float>(step);
  for_heavy_blocks(step, [&](size_t block) {
    float* const w = &weights_[block * simd::kCellLanes];
    float sum = 0;
    for (size_t i = 0; i < simd::kCellLanes; ++i) sum += w[i] = std::min(w[i], cap);
    block_sums_[block] = sum;
  });
  // The rest may have a ray more or fewer than was asked for, so that each of these has its one.
  return cap;
}

/// Calls fn(block) for blocks of candidates that may hold one heavier than `weight`.
template <class Function>
void Estimator::for_heavy_blocks(double weight, const Function& fn) const {
  for (const Segment& segment : segments_) {
    if (segment.strata == Strata::kDiffuse) continue;
    const size_t end = (segment.begin + segment.size) / simd::kCellLanes;
    for (size_t block = segment.begin / simd::kCellLanes; block < end; ++block) {
      if (block_sums_[block] > weight) fn(block);
    }
  }
}

/// Number of candidates heavier than `weight`, and the sum of what they weigh.
std::pair<size_t, double> Estimator::heavier_candidates(double weight) const {
  const auto limit = static_cast<float>(weight);
  size_t count = 0;
  double total = 0;
  for_heavy_blocks(weight, [&](size_t block) {
    const float* const w = &weights_[block * simd::kCellLanes];
    float sum = 0;
    int heavier = 0;
    for (size_t i = 0; i < simd::kCellLanes; ++i) {
      sum += w[i] > limit ? w[i] : 0.f;
      heavier += w[i] > limit;
    }
    count += static_cast<size_t>(heavier);
    total += sum;
  });
  return {count, total};
}

void Estimator::comb_unit(const Unit& unit, Rgb* sum) {
  if (unit.rays == 0) return;
  const StageScope timer(innermost_stage_, *stages_.comb);
  const double step = cap_candidates(unit.rays);
  if (!(step > 0)) return;
  Comb comb = Comb::by_step(step, random_float(unit.seed, 1));
  const uint32_t offset = random_bits(unit.seed, 2);
  const auto scale = static_cast<float>(step);
  size_t before = 0;
  for (const Segment& segment : segments_) {
    hits_.clear();
    comb.pass(&weights_[segment.begin], &block_sums_[segment.begin / simd::kCellLanes],
              segment.size, hits_);
    switch (segment.strata) {
      case Strata::kDiffuse:
        shoot_diffuse(segment, scale, offset, before, sum);
        break;
      case Strata::kGlossy:
        shoot_glossy(segment, scale, sum);
        break;
      case Strata::kLocal:
        shoot_local(segment, scale, sum);
        break;
    }
    before += hits_.size();
  }
}

}  // namespace kinome
