#include "clustered/media/fog_light.h"

#include <algorithm>
#include <cmath>

#include "kinome/wide/vectors.h"
#include "transport/shadows/rays.h"

namespace kinome {
namespace {

using transport::MediumLeg;

/// One of this number of samples is used for learning.
constexpr uint32_t kPilotStep = 8;
/// Ratio of the probability of a candidate on a later edge to its expected light, which is relative
/// to the mean of camera rays; and the minimum probability, since light may be unexpected.
constexpr float kCandidateGain = 2, kMinCandidates = 0.1f;
/// Number of camera rays of a block from which the expected light is averaged.
constexpr size_t kReferenceRays = 32;
/// Uses of random numbers of the pilot (RandomSeeds), and of the transmittance of shadow rays.
constexpr uint32_t kPilotUse = 0x666f6770, kShadowUse = 0x666f6773;

}  // namespace

FogLight::FogLight(const transport::SceneTable& scene, const transport::MediaTable& media,
                   const FogSources& sources, const SkyDirections& directions,
                   const Sampler& sampler, float share, size_t rays)
    : media_(media),
      sources_(sources),
      directions_(directions),
      sampler_(sampler),
      share_(share),
      table_(sources, media),
      later_table_(sources, media),
      numbers_(rays),
      shadows_(scene, media, rays, rays),
      choices_(rays),
      arena_(rays),
      d_(arena_.three()),
      light_(arena_.three()),
      distance_(arena_.floats()),
      on_(arena_.floats()),
      u_source_(arena_.floats()),
      u_distance_(arena_.floats()),
      u_(arena_.two()),
      owner_(arena_.indices()),
      medium_(arena_.indices()),
      rays_(arena_.untraced_rays()) {
  points_.p = arena_.three();
  points_.n = arena_.three();
  points_.p_error = arena_.floats();
  later_table_.begin_unrelated({});
}

void FogLight::add(const PixelSamples& samples, std::span<const MediumLeg> legs, uint32_t dimension,
                   uint32_t candidates, const Columns3& radiance, RenderCounters& counters) {
  current_ = &table_;
  owners_ = nullptr;
  list_lit(legs, kPilotStep);
  visibility_ = {};
  if (pilot_.empty() && rest_.empty()) return later_table_.begin_unrelated({});
  std::vector<MediumLeg> typical;
  for (const uint32_t i : pilot_.empty() ? rest_ : pilot_) typical.push_back(legs[i]);
  table_.begin(typical);
  weight_ = 1 / static_cast<float>(candidates);
  for (uint32_t k = 0; k < candidates; ++k) {
    render(samples, pilot_, k, Numbers::kOwn, radiance, counters);
  }
  table_.learn();
  visibility_ = table_.visibility();
  later_table_.begin_unrelated(visibility_);
  // Expected light of the camera rays, for the roulette of later candidates.
  float sum = 0;
  const size_t step = std::max<size_t>(1, legs.size() / kReferenceRays);
  size_t count = 0;
  for (size_t k = step / 2; k < legs.size(); k += step, ++count) {
    later_table_.set_leg(legs[k]);
    sum += later_table_.expected_light() * mean_of(legs[k].throughput);
  }
  reference_ = std::max(count > 0 ? sum / static_cast<float>(count) : 0.f, 1e-30f);
  for (uint32_t k = 0; k < candidates; ++k) {
    render(samples, rest_, dimension + k * kDimensions, Numbers::kSampler, radiance, counters);
  }
}

void FogLight::add_later(const PixelSamples& samples, std::span<const MediumLeg> legs,
                         const uint32_t* owner, uint32_t dimension, const Columns3& radiance,
                         RenderCounters& counters) {
  current_ = &later_table_;
  owners_ = owner;
  list_lit(legs, 0);
  weight_ = 1;
  render(samples, rest_, dimension, Numbers::kOwn, radiance, counters);
}

/// Divides the legs from which light may be scattered into those of the pilot, every `step`th path,
/// and the rest. 0: no pilot.
void FogLight::list_lit(std::span<const MediumLeg> legs, uint32_t step) {
  legs_ = legs;
  pilot_.clear(), rest_.clear();
  for (uint32_t i = 0; i < legs.size(); ++i) {
    const Rgb scattering = media_.extinction().at(legs[i].medium) *
                           media_.albedo().at(legs[i].medium) * legs[i].throughput;
    if (media_.emitter_weight(legs[i].medium) != 1) continue;
    if (is_black(scattering) || !(legs[i].length > 0)) continue;
    (step > 0 && legs[i].path % step == 0 ? pilot_ : rest_).push_back(i);
  }
}

void FogLight::render(const PixelSamples& samples, std::span<const uint32_t> legs,
                      uint32_t dimension, Numbers numbers, const Columns3& radiance,
                      RenderCounters& counters) {
  using namespace wide;
  const size_t most = arena_.capacity();
  for (size_t first = 0; first < legs.size(); first += most) {
    const size_t count = std::min(most, legs.size() - first);
    const auto part = legs.subspan(first, count);
    for (size_t i = 0; i < count; ++i) {
      const uint32_t path = legs_[part[i]].path;
      owner_[i] = owners_ ? owners_[path] : path;
    }
    for (size_t i = count; i < padded(count); ++i) owner_[i] = owner_[count - 1];
    make_numbers(samples, count, dimension, numbers);
    for (size_t i = 0; i < count; ++i) make_candidate(i, legs_[part[i]]);
    for (size_t i = count; i < padded(count); ++i) on_[i] = 0, medium_[i] = 0;
    for_lanes(count, [&](size_t i) {
      transport::write_shadow_rays(points_, i, wide::Vec3::load(d_, i), Float::load(distance_ + i),
                                   Float::load(on_ + i) > 0.f, true, rays_);
    });
    const transport::RandomSeeds seeds(samples, kShadowUse + dimension);
    shadows_.trace(rays_, count, medium_, distance_, owner_, seeds, counters);
    const bool learns = numbers == Numbers::kOwn && !owners_;
    for (size_t i = 0; i < count; ++i) {
      kinome::Rgb light(0.f);
      if (on_[i] > 0) light = light_.at(i) * shadows_.transmittance().at(i);
      if (learns) {
        table_.record(choices_[i], mean_of(light) / mean_of(legs_[part[i]].throughput));
      }
      if (is_black(light)) continue;
      radiance.set(owner_[i], radiance.at(owner_[i]) + weight_ * light);
    }
  }
}

void FogLight::make_numbers(const PixelSamples& samples, size_t count, uint32_t dimension,
                            Numbers numbers) {
  if (numbers == Numbers::kSampler) {
    numbers_.fill_1d(sampler_, samples, dimension, owner_, count, u_source_);
    numbers_.fill_1d(sampler_, samples, dimension + 1, owner_, count, u_distance_);
    numbers_.fill_2d(sampler_, samples, dimension + 2, owner_, count, u_);
    return;
  }
  const transport::RandomSeeds seeds(samples, kPilotUse + dimension);
  for (size_t i = 0; i < count; ++i) {
    const uint64_t seed = seeds.of(owner_[i]);
    const uint64_t a = hash_words(seed, i, 1), b = hash_words(seed, i, 2);
    u_source_[i] = to_unit_float(static_cast<uint32_t>(a));
    u_distance_[i] = to_unit_float(static_cast<uint32_t>(a >> 32));
    u_.set(i, {to_unit_float(static_cast<uint32_t>(b)),
               to_unit_float(static_cast<uint32_t>(b >> 32))});
  }
}

void FogLight::make_candidate(size_t i, const MediumLeg& leg) {
  on_[i] = 0;
  medium_[i] = leg.medium;
  current_->set_leg(leg);
  float kept = 1;
  if (owners_) {
    const float expected = current_->expected_light() * mean_of(leg.throughput);
    kept = std::clamp(kCandidateGain * expected / reference_, kMinCandidates, 1.f);
    if (!(u_source_[i] < kept)) return;
    u_source_[i] /= kept;
  }
  choices_[i] = current_->choose(u_source_[i], u_distance_[i]);
  choices_[i].density *= kept;
  const FogTable::Choice& choice = choices_[i];
  if (!(choice.density > 0)) return;
  const kinome::Vec3 p = leg.o + leg.d * choice.t;
  const FogSources::Light light = sources_.sample(choice.source, p, u_.at(i), directions_);
  if (is_black(light.weight)) return;
  const MediumPoint point{p, Frame::from_normal(-leg.d)};
  const float phase = media_.medium(leg.medium)->phase().eval(point, point.frame.to_local(light.d));
  const float ratio = phase / (share_ * light.emitter_pdf);
  const float factor = phase / (choice.density * (1 + ratio * ratio));
  const kinome::Rgb extinction = media_.extinction().at(leg.medium);
  const kinome::Rgb scattering = extinction * media_.albedo().at(leg.medium);
  const kinome::Rgb transmittance = media_.is_coloured()
                                        ? glm::exp(-extinction * choice.t)
                                        : kinome::Rgb(std::exp(-extinction.x * choice.t));
  const kinome::Rgb value = leg.throughput * transmittance * scattering * light.weight * factor;
  if (is_black(value)) return;
  on_[i] = 1;
  points_.p.set(i, p);
  d_.set(i, light.d);
  distance_[i] = light.distance;
  light_.set(i, value);
}

}  // namespace kinome
