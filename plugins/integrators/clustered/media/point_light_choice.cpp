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

}  // namespace

PointLightChoice::PointLightChoice(const FogSources& sources, const SkyDirections& directions)
    : sources_(sources),
      directions_(directions),
      arena_(padded(sources.near().size()) + padded(sources.distant().size())),
      place_(arena_.three()),
      intensity_(arena_.floats()),
      radius2_(arena_.floats()),
      weight_(arena_.floats()) {
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
}

PointLightChoice::Chosen PointLightChoice::choose(const Vec3& p, const Vec3& n, float u) const {
  using namespace wide;
  const size_t near = padded(sources_.near().size());
  const size_t end = near + padded(sources_.distant().size());
  const wide::Vec3 from(p), normal(n);
  const bool is_surface = n != kinome::Vec3(0.f);
  Float sum(0.f);
  const auto weigh = [&](size_t i, const wide::Vec3& d, Float light) {
    if (is_surface) light = light * max(dot(normal, d), Float(kMinCosine));
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
                              uint32_t dimension, const SurfaceBlock& points, const uint32_t* owner,
                              size_t count, transport::Numbers& numbers, const DirectBlock& out,
                              float* emitter_pdf) {
  // The results' columns hold the random numbers first.
  float* const which = out.pdf;
  const Columns2 u(out.d.x, out.d.y);
  numbers.fill_1d(sampler, samples, dimension, owner, count, which);
  numbers.fill_2d(sampler, samples, dimension + 1, owner, count, u);
  for (uint32_t i = 0; i < count; ++i) {
    const kinome::Vec3 p = points.p.at(i);
    const float side = points.wi.z[i] < 0 ? -1.f : 1.f;
    const Chosen chosen = choose(p, side * points.n.at(i), which[i]);
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
