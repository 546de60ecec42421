#include "clustered/media/fog_table.h"

#include <algorithm>
#include <cmath>

#include "clustered/media/hg_terms.h"
#include "clustered/media/segment_distances.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

using transport::MediumLeg;

/// Optical depth beyond which near sources have a single bin, and its probability.
constexpr float kReach = 12, kBeyondReach = 1e-3f;
/// Share of the probability that all bins have in common.
constexpr float kEvenShare = 0.1f;
/// Minimum importance of a near source, relative to the highest.
constexpr float kMinImportance = 1e-3f;
/// Number of candidates that the expectation counts as, for a bin and for a whole source.
constexpr float kPriorOfBin = 2, kPriorOfSource = 1;
/// Maximum ratio to the expectation that is learned from one candidate.
constexpr float kMaxRatio = 64;

/// Returns the bin that u selects, and makes u uniform again.
template <class Bins>
uint32_t select_bin(const Bins& probability, float& u) {
  uint32_t bin = 0;
  for (; bin + 1 < probability.size() && u >= probability[bin]; ++bin) u -= probability[bin];
  u = std::min(u / probability[bin], 1 - 0x1p-24f);
  return bin;
}

template <class Bins>
Bins probabilities_of(const Bins& importance) {
  float sum = 0;
  for (const float x : importance) sum += x;
  Bins result;
  for (size_t b = 0; b < result.size(); ++b) {
    const float even = 1.f / static_cast<float>(result.size());
    const float own = sum > 0 ? importance[b] / sum : even;
    result[b] = kEvenShare * even + (1 - kEvenShare) * own;
  }
  return result;
}

}  // namespace

FogTable::FogTable(const FogSources& sources, const transport::MediaTable& media)
    : sources_(sources),
      media_(media),
      arena_(std::max<size_t>(1, sources.near().size())),
      near_p_(arena_.three()),
      nearest_(arena_.floats()),
      near_weight_(arena_.floats()),
      near_importance_(arena_),
      expected_(sources.near().size()),
      near_bins_(sources.near().size()),
      distant_bins_(sources.groups()),
      near_records_(sources.near().size()),
      distant_records_(sources.groups()),
      expected_weight_(sources.near().size()),
      distant_expected_(sources.distant().size()),
      seen_(sources.groups()),
      distant_sum_(sources.distant().size()),
      sky_arena_(std::max<size_t>(1, sources.distant().size())),
      sky_d_(sky_arena_.three()),
      sky_mean_cosine_(sky_arena_.floats()),
      sky_flux_(sky_arena_.floats()),
      sky_weight_(sky_arena_),
      sun_importance_(sources.suns().size()),
      sun_parts_(sources.suns().size()) {
  std::fill_n(nearest_, arena_.capacity(), 1.f);
  for (size_t s = 0; s < sources.near().size(); ++s) {
    near_p_.set(s, sources.near()[s].p);
    nearest_[s] = std::max(0.5f * sources.near()[s].radius, 1e-12f);
  }
  for (size_t s = 0; s < sources.distant().size(); ++s) {
    sky_d_.set(s, sources.distant()[s].d);
    sky_mean_cosine_[s] = sources.distant()[s].mean_cosine;
  }
}

float FogTable::phase_toward(const MediumLeg& leg, const Vec3& d, float mean_cosine) const {
  float value = 0;
  for (const HgLobe& lobe : media_.medium(leg.medium)->phase().lobes()) {
    value += HgTerms<float>::of(lobe.g * mean_cosine, lobe.weight).at(glm::dot(leg.d, d));
  }
  return value / (4 * kPi);
}

void FogTable::begin(std::span<const MediumLeg> legs) {
  is_related_ = true;
  std::fill(near_records_.begin(), near_records_.end(), Record());
  std::fill(distant_records_.begin(), distant_records_.end(), Record());
  for (size_t s = 0; s < expected_.size(); ++s) expected_[s].fill(0);
  std::fill(distant_expected_.begin(), distant_expected_.end(), 0.f);
  // Many sources need fewer rays, since their importances are computed for each ray.
  const size_t rays = std::clamp<size_t>(64 / std::max<size_t>(1, expected_.size()), 1, 8);
  const size_t step = std::max<size_t>(1, legs.size() / rays);
  for (size_t i = step / 2; i < legs.size(); i += step) {
    for (uint32_t s = 0; s < expected_.size(); ++s) add_expected(legs[i], s);
  }
  const MediumLeg& middle = legs[legs.size() / 2];
  for (size_t s = 0; s < distant_expected_.size(); ++s) {
    const FogSources::Distant& distant = sources_.distant()[s];
    const float phase = phase_toward(middle, distant.d, distant.mean_cosine);
    distant_expected_[s] = s < sun_importance_.size() ? 0 : distant.flux * phase;
  }
  float highest = 0;
  for (size_t s = 0; s < expected_.size(); ++s) {
    float sum = 0;
    for (const float x : expected_[s]) sum += x;
    expected_weight_[s] = sum / static_cast<float>(rays);
    highest = std::max(highest, expected_weight_[s]);
    for (float& x : expected_[s]) x = sum > 0 ? x / sum : 1.f / kBins;
  }
  for (float& weight : expected_weight_) {
    weight = highest > 0 ? std::max(weight, kMinImportance * highest) : 1;
  }
  set_near_probabilities();
  set_distant_probabilities();
}

void FogTable::begin_unrelated(std::span<const float> visibility) {
  is_related_ = false;
  std::fill(near_records_.begin(), near_records_.end(), Record());
  float highest = 0;
  for (const auto& source : sources_.near()) highest = std::max(highest, source.intensity);
  for (size_t s = 0; s < expected_.size(); ++s) {
    expected_[s].fill(1.f / kBins);
    expected_weight_[s] =
        highest > 0 ? std::max(sources_.near()[s].intensity, kMinImportance * highest) : 1;
  }
  set_near_probabilities();
  std::fill(distant_records_.begin(), distant_records_.end(), Record());
  set_distant_probabilities();
  float lit = 0;
  for (const float v : visibility) lit = std::max(lit, v);
  for (size_t s = 0; s < sources_.distant().size(); ++s) {
    const FogSources::Distant& distant = sources_.distant()[s];
    const float seen = lit > 0 ? std::max(visibility[distant.group], kEvenShare * lit) : 1.f;
    sky_flux_[s] = s < sun_importance_.size() ? 0 : distant.flux * seen;
  }
}

/// Sets the importances of distant sources for the ray.
void FogTable::weigh_sky() {
  using namespace wide;
  const auto lobes = media_.medium(leg_.medium)->phase().lobes();
  sky_weight_.clear();
  sky_weight_.add(0, sources_.distant().size(), [&](size_t i) {
    const Float cosine = dot(wide::Vec3::load(sky_d_, i), wide::Vec3(leg_.d));
    Float phase(kEvenShare);
    for (const HgLobe& lobe : lobes) {
      if (!(lobe.weight > 0)) continue;
      const Float g = Float::load(sky_mean_cosine_ + i) * lobe.g;
      phase = phase + HgTerms<Float>::of(g, lobe.weight).at(cosine);
    }
    return Float::load(sky_flux_ + i) * phase;
  });
  distant_total_ = sky_weight_.total() * absorbed_ * albedo_ / (4 * kPi);
}

/// Adds the light of a near source that a ray's bins scatter, relative to the integral of 1/r².
void FogTable::add_expected(const MediumLeg& leg, uint32_t near) {
  const FogSources::Near& source = sources_.near()[near];
  const Rgb coefficients = media_.extinction().at(leg.medium);
  const float extinction = min_extinction(coefficients);
  const float reach = std::min(leg.length, kReach / extinction);
  const EquiangularDistances distances(leg.o, leg.d, reach, source.p, nearest_[near]);
  const float scattering = mean_of(coefficients * media_.albedo().at(leg.medium));
  for (uint32_t b = 0; b < kBins; ++b) {
    const float t = distances.at((static_cast<float>(b) + 0.5f) / kBins);
    const Vec3 p = leg.o + leg.d * t;
    const FogSources::Light light = sources_.sample(near, p, Vec2(0.5f), SkyDirections());
    const float distance = std::min(light.distance, glm::length(source.p - p));
    const float r2 = 1 / (distances.density(t) * distances.integral());
    expected_[near][b] += mean_of(light.weight) * phase_toward(leg, light.d, 1) * scattering *
                          std::exp(-extinction * (t + distance)) * r2 / kBins;
  }
}

void FogTable::set_near_probabilities() {
  for (size_t s = 0; s < expected_.size(); ++s) {
    const Record& record = near_records_[s];
    float squares = 0, count = 0;
    for (uint32_t b = 0; b < kBins; ++b) {
      // Relative to the expected light of the bin.
      const float expected = std::max(expected_[s][b], kEvenShare / kBins);
      squares += record.squares[b] / (expected * expected);
      count += record.counts[b];
    }
    const float seen2 = (kPriorOfSource + squares) / (kPriorOfSource + count);
    Bins importance;
    float sum = 0;
    for (uint32_t b = 0; b < kBins; ++b) {
      const float expected = expected_[s][b];
      importance[b] = std::sqrt((kPriorOfBin * expected * expected * seen2 + record.squares[b]) /
                                (kPriorOfBin + record.counts[b]));
      sum += importance[b];
    }
    near_weight_[s] = expected_weight_[s] * sum;
    near_bins_[s] = probabilities_of(importance);
  }
}

void FogTable::set_distant_probabilities() {
  for (size_t g = 0; g < distant_bins_.size(); ++g) {
    const Record& record = distant_records_[g];
    float squares = 0, count = 0;
    for (uint32_t b = 0; b < kBins; ++b) squares += record.squares[b], count += record.counts[b];
    const float seen2 = (kPriorOfSource + squares) / (kPriorOfSource + count);
    Bins importance;
    seen_[g] = 0;
    for (uint32_t b = 0; b < kBins; ++b) {
      importance[b] =
          std::sqrt((kPriorOfBin * seen2 + record.squares[b]) / (kPriorOfBin + record.counts[b]));
      seen_[g] += importance[b] / kBins;
    }
    distant_bins_[g] = probabilities_of(importance);
  }
  float sum = 0;
  for (size_t s = 0; s < distant_sum_.size(); ++s) {
    sum += distant_expected_[s] * seen_[sources_.distant()[s].group];
    distant_sum_[s] = sum;
  }
}

void FogTable::learn() {
  set_near_probabilities();
  set_distant_probabilities();
}

void FogTable::set_leg(const MediumLeg& leg) {
  using namespace wide;
  leg_ = leg;
  const kinome::Rgb extinction = media_.extinction().at(leg.medium);
  extinction_ = min_extinction(extinction);
  length_ = leg.length;
  reach_ = std::min(length_, kReach / extinction_);
  attenuated_ = AttenuatedDistances(extinction_, length_);
  absorbed_ = attenuated_.absorbed();
  albedo_ = mean_of(media_.albedo().at(leg.medium));
  near_total_ = 0, near_scale_ = 1;
  const size_t count = expected_.size();
  if (count > 0) {
    near_importance_.clear();
    near_importance_.add(0, count, [&](size_t i) {
      const wide::Vec3 to = wide::Vec3::load(near_p_, i) - wide::Vec3(leg.o), d(leg.d);
      const Float centre = dot(to, d);
      const wide::Vec3 beside = to - d * centre;
      const Float distance = max(sqrt(dot(beside, beside)), Float::load(nearest_ + i));
      const Float angle =
          atan2(distance * Float(reach_), distance * distance - centre * (Float(reach_) - centre));
      return Float::load(near_weight_ + i) * angle / distance;
    });
    near_total_ = near_importance_.total();
  }
  sun_total_ = 0;
  for (size_t s = 0; s < sun_importance_.size(); ++s) {
    const FogSources::Distant& sun = sources_.distant()[s];
    sources_.suns()[s]->divide(leg.o, leg.d, length_, extinction_, sun_parts_[s]);
    const float lit = sun_parts_[s].empty() ? 0 : sun_parts_[s].back().sum;
    sun_importance_[s] = sun.flux * phase_toward(leg, sun.d, 1) * lit * albedo_;
    sun_total_ += sun_importance_[s];
  }
  if (!is_related_) {
    // Near sources as if the medium were isotropic.
    near_scale_ = extinction_ * albedo_ / (4 * kPi);
    near_total_ *= near_scale_;
    return weigh_sky();
  }
  distant_total_ = distant_sum_.empty() ? 0 : distant_sum_.back() * absorbed_ * albedo_;
}

FogTable::Choice FogTable::choose(float u_source, float u_distance) const {
  const float total = near_total_ + sun_total_ + distant_total_;
  if (!(total > 0)) return {0, kNoBin, 0, 0, 0};
  float at = u_source * total;
  const bool has_distant = distant_total_ > 0;
  if (sun_total_ > 0 && at >= near_total_ && (at < near_total_ + sun_total_ || !has_distant)) {
    at -= near_total_;
    uint32_t s = 0;
    const auto last = static_cast<uint32_t>(sun_importance_.size()) - 1;
    for (; s < last && at >= sun_importance_[s]; ++s) at -= sun_importance_[s];
    return choose_sun(s, sun_importance_[s] / total, u_distance);
  }
  if (at < near_total_ || !has_distant) {
    const size_t s = near_importance_.at(at / near_scale_);
    const float importance = near_importance_[s] * near_scale_;
    return choose_near(static_cast<uint32_t>(s), importance / total, u_distance);
  }
  if (!is_related_) return choose_from_sky(at - near_total_ - sun_total_, total, u_distance);
  at = (at - near_total_ - sun_total_) / distant_total_ * distant_sum_.back();
  const auto found = std::upper_bound(distant_sum_.begin(), distant_sum_.end() - 1, at);
  const auto index = static_cast<uint32_t>(found - distant_sum_.begin());
  const float before = index > 0 ? distant_sum_[index - 1] : 0;
  const float share = (distant_sum_[index] - before) / distant_sum_.back();
  return choose_distant(index, share * (distant_total_ / total), u_distance);
}

FogTable::Choice FogTable::choose_from_sky(float at, float total, float u) const {
  const float scale = absorbed_ * albedo_ / (4 * kPi);
  const size_t chosen = sky_weight_.at(at / scale);
  return choose_distant(static_cast<uint32_t>(chosen), sky_weight_[chosen] * scale / total, u);
}

FogTable::Choice FogTable::choose_near(uint32_t source, float probability, float u) const {
  const float beyond = length_ > reach_ ? kBeyondReach : 0;
  if (u < beyond) {
    const AttenuatedDistances rest(extinction_, length_ - reach_);
    const float t = rest.at(u / beyond);
    return {source, kNoBin, reach_ + t, probability * beyond * rest.density(t), 0};
  }
  u = (u - beyond) / (1 - beyond);
  const EquiangularDistances distances(leg_.o, leg_.d, reach_, sources_.near()[source].p,
                                       nearest_[source]);
  const uint32_t bin = select_bin(near_bins_[source], u);
  const float t = distances.at((static_cast<float>(bin) + u) / kBins);
  const float of_bin = probability * (1 - beyond) * near_bins_[source][bin];
  const float expected = expected_weight_[source] * distances.integral();
  return {source, bin, t, of_bin * kBins * distances.density(t), of_bin / expected};
}

FogTable::Choice FogTable::choose_sun(uint32_t index, float probability, float u) const {
  const auto& parts = sun_parts_[index];
  const float all = parts.back().sum;
  size_t k = 0;
  while (k + 1 < parts.size() && u * all >= parts[k].sum) ++k;
  const SunGrid::Part& part = parts[k];
  const float before = k > 0 ? parts[k - 1].sum : 0, weight = part.sum - before;
  if (!(weight > 0)) return {0, kNoBin, 0, 0, 0};
  const float within = std::clamp((u * all - before) / weight, 0.f, 1 - 0x1p-24f);
  const AttenuatedDistances distances(extinction_, part.end - part.begin);
  const float t = distances.at(within);
  return {static_cast<uint32_t>(sources_.near().size()) + index, kNoBin, part.begin + t,
          probability * (weight / all) * distances.density(t), 0};
}

FogTable::Choice FogTable::choose_distant(uint32_t index, float probability, float u) const {
  const uint32_t group = sources_.distant()[index].group;
  const uint32_t bin = select_bin(distant_bins_[group], u);
  const AttenuatedDistances& distances = attenuated_;
  const float t = distances.at((static_cast<float>(bin) + u) / kBins);
  const float of_bin = probability * distant_bins_[group][bin];
  const float expected = distant_expected_[index] * absorbed_ * albedo_ / kBins;
  return {static_cast<uint32_t>(sources_.near().size()) + index, bin, t,
          of_bin * kBins * distances.density(t), expected > 0 ? of_bin / expected : 0};
}

void FogTable::record(const Choice& choice, float light) {
  if (choice.bin == kNoBin) return;
  const float ratio = std::min(light * choice.scale, kMaxRatio);
  const size_t near = sources_.near().size();
  Record& record = choice.source < near
                       ? near_records_[choice.source]
                       : distant_records_[sources_.distant()[choice.source - near].group];
  record.squares[choice.bin] += ratio * ratio;
  record.counts[choice.bin] += 1;
}

}  // namespace kinome
