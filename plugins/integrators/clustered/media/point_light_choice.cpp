#include "clustered/media/point_light_choice.h"

#include <algorithm>
#include <cmath>

#include "kinome/shape.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

/// Minimum intensity of a near source, relative to the highest.
constexpr float kMinIntensity = 1e-3f;
/// Cosines are at least this one, because sources have a size and some surfaces pass light.
constexpr float kMinCosine = 0.02f;
/// Part of the phase function that is treated as isotropic, because lobes are approximations.
constexpr float kIsotropicShare = 0.1f;
/// Minimum visibility of a distant source, relative to the highest.
constexpr float kMinVisibility = 0.1f;

}  // namespace

PointLightChoice::PointLightChoice(const FogSources& sources, const SkyDirections& directions,
                                   const transport::MediaTable& media)
    : sources_(sources),
      directions_(directions),
      arena_(padded(sources.near().size()) + padded(sources.distant().size())),
      place_(arena_.three()),
      intensity_(arena_.floats()),
      radius2_(arena_.floats()),
      weight_(arena_.floats()),
      lobes_(media.size()) {
  std::fill_n(radius2_, arena_.capacity(), 1.f);
  float highest = 0;
  for (const auto& near : sources.near()) highest = std::max(highest, near.intensity);
  for (size_t i = 0; i < sources.near().size(); ++i) {
    const FogSources::Near& near = sources.near()[i];
    place_.set(i, near.p);
    intensity_[i] = highest > 0 ? std::max(near.intensity, kMinIntensity * highest) : 1;
    radius2_[i] = std::max(near.radius * near.radius, 1e-20f);
  }
  const size_t first = padded(sources.near().size());
  for (size_t i = 0; i < sources.distant().size(); ++i) {
    place_.set(first + i, sources.distant()[i].d);
    intensity_[first + i] = sources.distant()[i].flux;
  }
  for (uint32_t m = 1; m < media.size(); ++m) {
    for (const HgLobe& lobe : media.medium(m)->phase().lobes()) {
      if (lobe.weight > 0) lobes_[m].push_back(lobe_columns(lobe));
    }
  }
}

/// Light from a cone of directions is scattered as by g times the mean cosine: see FogTable.
PointLightChoice::LobeColumns PointLightChoice::lobe_columns(const HgLobe& lobe) {
  const LobeColumns columns{arena_.floats(), arena_.floats(), arena_.floats()};
  const size_t first = padded(sources_.near().size());
  std::fill_n(columns.base, arena_.capacity(), 1.f);
  const auto set = [&](size_t i, float g) {
    columns.base[i] = 1 + g * g;
    columns.slope[i] = 2 * g;
    columns.weight[i] = lobe.weight * (1 - g * g);
  };
  for (size_t i = 0; i < sources_.near().size(); ++i) set(i, lobe.g);
  for (size_t i = 0; i < sources_.distant().size(); ++i) {
    set(first + i, lobe.g * sources_.distant()[i].mean_cosine);
  }
  return columns;
}

void PointLightChoice::set_visibility(std::span<const float> visibility) {
  float highest = 0;
  for (const float v : visibility) highest = std::max(highest, v);
  float* const intensity = intensity_ + padded(sources_.near().size());
  for (size_t i = sources_.suns().size(); i < sources_.distant().size(); ++i) {
    const FogSources::Distant& distant = sources_.distant()[i];
    const float seen = highest > 0 ? visibility[distant.group] : 1.f;
    intensity[i] = distant.flux * std::max(seen, kMinVisibility * highest);
  }
}

PointLightChoice::Chosen PointLightChoice::choose(const Vec3& p, const Vec3& d, uint32_t medium,
                                                  float u) const {
  using namespace wide;
  const size_t near = padded(sources_.near().size());
  for (size_t s = 0; s < sources_.suns().size(); ++s) {
    const float lit = std::max(sources_.suns()[s]->at(p), kMinVisibility);
    intensity_[near + s] = sources_.distant()[s].flux * lit;
  }
  const size_t end = near + padded(sources_.distant().size());
  const wide::Vec3 from(p), axis(d);
  const bool is_surface = medium == transport::MediaTable::kVacuum;
  Float sum(0.f);
  const auto weigh = [&](size_t i, const wide::Vec3& to, Float light) {
    const Float cosine = dot(axis, to);
    if (is_surface) {
      light = light * max(cosine, Float(kMinCosine));
    } else {
      Float phase(kIsotropicShare);
      for (const LobeColumns& lobe : lobes_[medium]) {
        const Float base =
            max(Float::load(lobe.base + i) - Float::load(lobe.slope + i) * cosine, Float(1e-6f));
        phase = phase + Float::load(lobe.weight + i) / (base * sqrt(base));
      }
      light = light * phase;
    }
    light.store(weight_ + i);
    sum = sum + light;
  };
  for (size_t i = 0; i < near; i += kLanes) {
    const wide::Vec3 to = wide::Vec3::load(place_, i) - from;
    const Float r2 = max(dot(to, to), Float::load(radius2_ + i));
    weigh(i, to / sqrt(r2), Float::load(intensity_ + i) / r2);
  }
  for (size_t i = near; i < end; i += kLanes) {
    weigh(i, wide::Vec3::load(place_, i), Float::load(intensity_ + i));
  }
  alignas(kColumnAlignment) float sums[kLanes];
  sum.store(sums);
  float total = 0;
  for (const float s : sums) total += s;
  if (!(total > 0) || !(total < kInfinity)) return {0, 0};
  // Chooses a lane, then a vector.
  float at = u * total;
  size_t lane = 0, last_lane = 0;
  for (; lane < kLanes && at >= sums[lane]; ++lane) {
    if (sums[lane] > 0) last_lane = lane;
    at -= sums[lane];
  }
  if (lane == kLanes) lane = last_lane, at = sums[lane];
  size_t source = lane;
  for (size_t i = lane; i < end; i += kLanes) {
    if (!(weight_[i] > 0)) continue;
    source = i;
    if (at < weight_[i]) break;
    at -= weight_[i];
  }
  const size_t index = source < near ? source : source - near + sources_.near().size();
  return {static_cast<uint32_t>(index), weight_[source] / total};
}

void PointLightChoice::sample(const Sampler& sampler, const PixelSamples& samples,
                              uint32_t dimension, const SurfaceBlock& points, uint32_t medium,
                              const uint32_t* owner, size_t count, transport::Numbers& numbers,
                              const DirectBlock& out, float* emitter_pdf) {
  // The results' columns hold the random numbers first.
  float* const which = out.pdf;
  const Columns2 u(out.d.x, out.d.y);
  const bool is_surface = medium == transport::MediaTable::kVacuum;
  numbers.fill_1d(sampler, samples, dimension, owner, count, which);
  numbers.fill_2d(sampler, samples, dimension + 1, owner, count, u);
  for (uint32_t i = 0; i < count; ++i) {
    const kinome::Vec3 p = points.p.at(i);
    const float side = points.wi.z[i] < 0 ? -1.f : 1.f;
    const kinome::Vec3 d = is_surface ? side * points.n.at(i) : -points.sn.at(i);
    const Chosen chosen = choose(p, d, medium, which[i]);
    FogSources::Light light;
    if (chosen.probability > 0) light = sources_.sample(chosen.source, p, u.at(i), directions_);
    out.d.set(i, light.d);
    out.distance[i] = light.distance;
    out.radiance.set(i, light.weight);
    out.pdf[i] = is_black(light.weight) ? 0 : chosen.probability;
    out.is_delta[i] = light.emitter_pdf < kInfinity ? 0 : 1;
    emitter_pdf[i] = light.emitter_pdf;
    if (chosen.source < sources_.near().size()) {
      transport::leave_out_own_rounding(*sources_.near()[chosen.source].emitter, points, &i, 1,
                                        out);
    }
  }
}

}  // namespace kinome
