#include "clustered/media/point_light_choice.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "clustered/media/hg_terms.h"
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
/// Factor of the weights of light points. Emitters are occluded more often: a sunbeam is in a room.
constexpr float kPointGain = 2;
/// Use of random numbers for sets of light points.
constexpr uint32_t kSetUse = 0x73657473;

}  // namespace

PointLightChoice::PointLightChoice(const FogSources& sources, const SkyDirections& directions,
                                   const transport::MediaTable& media, const SunPoints* points,
                                   float max_depth, size_t emitters)
    : sources_(sources),
      directions_(directions),
      media_(media),
      sun_points_(points),
      max_depth_(max_depth),
      emitters_(static_cast<float>(emitters)),
      guide_(sources),
      arena_(padded(sources.near().size()) + padded(sources.distant().size()) +
             (points ? SunPoints::kPointsPerSet : 0)),
      place_(arena_.three()),
      intensity_(arena_.floats()),
      radius2_(arena_.floats()),
      weight_(arena_),
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
    const auto terms = HgTerms<float>::of(g, lobe.weight);
    columns.base[i] = terms.base, columns.slope[i] = terms.slope, columns.weight[i] = terms.weight;
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
                                                  float u, bool emitters, size_t set) {
  const size_t near = padded(sources_.near().size());
  const size_t first_point = near + padded(sources_.distant().size());
  weight_.clear();
  if (emitters) add_emitters(p, d, medium);
  if (set != kNoSet) add_points(p, d, medium, set);
  const float total = weight_.total();
  if (!(total > 0) || !(total < kInfinity)) return {0, 0};
  const size_t source = weight_.at(u * total);
  if (source >= first_point) {
    const size_t point = set * SunPoints::kPointsPerSet + source - first_point;
    return {kFirstPoint + static_cast<uint32_t>(point), weight_[source] / total};
  }
  const size_t index = source < near ? source : source - near + sources_.near().size();
  return {static_cast<uint32_t>(index), weight_[source] / total};
}

/// Adds the weights of the sources.
void PointLightChoice::add_emitters(const Vec3& p, const Vec3& d, uint32_t medium) {
  using namespace wide;
  const size_t near = padded(sources_.near().size());
  for (size_t s = 0; s < sources_.suns().size(); ++s) {
    const float lit = std::max(sources_.suns()[s]->at(p), kMinVisibility);
    intensity_[near + s] = sources_.distant()[s].flux * lit;
  }
  const wide::Vec3 from(p), axis(d);
  const bool is_surface = medium == transport::MediaTable::kVacuum;
  const auto weight_of = [&](size_t i, const wide::Vec3& to, Float light) -> Float {
    const Float cosine = dot(axis, to);
    if (is_surface) {
      return light * max(cosine, Float(kMinCosine));
    }
    Float phase(kIsotropicShare);
    for (const LobeColumns& lobe : lobes_[medium]) {
      const HgTerms<Float> terms{Float::load(lobe.base + i), Float::load(lobe.slope + i),
                                 Float::load(lobe.weight + i)};
      phase = phase + terms.at(cosine);
    }
    return light * phase;
  };
  weight_.add(0, sources_.near().size(), [&](size_t i) {
    const wide::Vec3 to = wide::Vec3::load(place_, i) - from;
    const Float r2 = max(dot(to, to), Float::load(radius2_ + i));
    return weight_of(i, to / sqrt(r2), Float::load(intensity_ + i) / r2);
  });
  weight_.add(near, sources_.distant().size(), [&](size_t i) {
    return weight_of(i, wide::Vec3::load(place_, i), Float::load(intensity_ + i));
  });
}

/// Adds the weights of a set of light points.
void PointLightChoice::add_points(const Vec3& p, const Vec3& d, uint32_t medium, size_t set) {
  using namespace wide;
  const wide::Vec3 at(p), axis(d);
  const bool is_surface = medium == transport::MediaTable::kVacuum;
  const auto lobes = is_surface ? std::array<HgLobe, 2>() : media_.medium(medium)->phase().lobes();
  const auto scattered = [&](const wide::Vec3& to) -> Float {
    const Float cosine = dot(axis, to);
    if (is_surface) return max(cosine, Float(kMinCosine));
    Float phase(kIsotropicShare);
    for (const HgLobe& lobe : lobes) {
      if (!(lobe.weight > 0)) continue;
      phase = phase + HgTerms<Float>::of(lobe.g, lobe.weight).at(cosine);
    }
    return phase;
  };
  const size_t first = padded(sources_.near().size()) + padded(sources_.distant().size());
  const SunPoints& points = *sun_points_;
  const size_t begin = set * SunPoints::kPointsPerSet;
  weight_.add(first, points.on_surfaces(set), [&](size_t i) {
    wide::Vec3 to;
    const Float light = points.irradiance_of_surfaces(begin + i - first, at, to);
    return light * scattered(to) * kPointGain;
  });
  weight_.add(first + SunPoints::kRaysPerSet, points.in_media(set), [&](size_t i) {
    wide::Vec3 to;
    const Float light = points.irradiance_of_media(begin + i - first, at, to);
    return light * scattered(to) * kPointGain;
  });
}

/// Returns the set of light points for a sample. The samples of a pixel use all sets in turn.
size_t PointLightChoice::set_of(const PixelSamples& samples, uint32_t dimension, uint32_t medium,
                                uint32_t owner) const {
  const SampleKey key = transport::key_of(samples, owner);
  const uint64_t offset = hash_words(key.seed, uint64_t{key.x} << 32 | key.y,
                                     uint64_t{dimension} << 32 | medium, kSetUse);
  return (key.sample + (offset >> 32)) % sun_points_->sets();
}

/// Share of the sun's light at a point that paths find. Light points at the point before find the
/// rest. `edge`: between both; `pdf`: that of LightChoice::Paths.
float PointLightChoice::share_of_paths(const kinome::Vec3& edge, float pdf) const {
  if (!(pdf < kInfinity)) return 1;
  const float ratio = sun_points_->pdf(glm::dot(edge, edge)) / (pdf * emitters_);
  return 1 / (1 + ratio * ratio);
}

void PointLightChoice::sample(const Sampler& sampler, const PixelSamples& samples,
                              uint32_t dimension, const SurfaceBlock& points, uint32_t medium,
                              const uint32_t* owner, size_t count, const Paths& paths,
                              transport::Numbers& numbers, const DirectBlock& out,
                              float* emitter_pdf) {
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
    const bool scattered = sun_points_ && paths.scatterings[i] + 2 < max_depth_;
    const size_t set = scattered ? set_of(samples, dimension, medium, owner[i]) : kNoSet;
    const Chosen chosen = choose(p, d, medium, which[i], paths.needs_emitters, set);
    const bool is_point = chosen.source >= kFirstPoint;
    FogSources::Light light;
    if (is_point) {
      light = sun_points_->light(chosen.source - kFirstPoint, p);
    } else if (chosen.probability > 0) {
      light = sources_.sample(chosen.source, p, u.at(i), directions_);
      if (sun_points_ && chosen.source == sources_.beam_source()) {
        light.weight *= share_of_paths(p - paths.from.at(i), paths.pdf[i]);
      }
    }
    out.d.set(i, light.d);
    out.distance[i] = light.distance;
    out.radiance.set(i, light.weight);
    out.pdf[i] = is_black(light.weight) ? 0 : chosen.probability;
    out.is_delta[i] = light.emitter_pdf < kInfinity ? 0 : 1;
    emitter_pdf[i] = light.emitter_pdf;
    if (chosen.source < sources_.near().size()) {
      transport::drop_self_occlusion(*sources_.near()[chosen.source].emitter, points, &i, 1, out);
    }
  }
}

void PointLightChoice::redirect(const Sampler& sampler, const PixelSamples& samples,
                                uint32_t dimension, const SurfaceBlock& points, uint32_t medium,
                                const uint32_t* owner, size_t count, transport::Numbers& numbers,
                                float* u1, const Columns2& u2, const BsdfAnswer& answer) {
  if (guide_.is_empty()) return;
  const Phase& phase = media_.medium(medium)->phase();
  numbers.fill_1d(sampler, samples, dimension, owner, count, u1);
  for (size_t i = 0; i < count; ++i) {
    const MediumPoint point{points.p.at(i), {points.s.at(i), points.t.at(i), points.sn.at(i)}};
    kinome::Vec3 wo = answer.wo.at(i);
    const float ratio = guide_.redirect(phase, point, u1[i], u2.at(i), wo, answer.sample_pdf[i]);
    answer.wo.set(i, wo);
    answer.weight.set(i, kinome::Vec3(ratio));
  }
}

}  // namespace kinome
