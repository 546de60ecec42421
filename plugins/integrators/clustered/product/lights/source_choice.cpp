#include "clustered/product/lights/source_choice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "clustered/product/tiles/spread.h"

namespace kinome {
namespace {

/// Fraction of the choice that depends on flux alone.
constexpr float kFluxShare = 0.25f;
/// Margin that is added to cosines, because other parts of a source may be higher above the surface
/// than the sampled one.
constexpr float kCosineMargin = 0.05f;

}  // namespace

SourceChoice::SourceChoice(std::vector<const Emitter*> sources, const std::vector<double>& fluxes,
                           float radius)
    : sources_(std::move(sources)) {
  const double all = std::accumulate(fluxes.begin(), fluxes.end(), 0.);
  double end = 0;
  for (size_t s = 0; s < sources_.size(); ++s) {
    shares_.push_back(static_cast<float>(fluxes[s] / all));
    ends_.push_back(end += static_cast<double>(shares_[s]));
    // Mean irradiance: the flux through the scene's disc from all directions, over the area of its
    // sphere.
    const double sphere = 4. * static_cast<double>(kPi) * static_cast<double>(sqr(radius));
    skies_.push_back(sources_[s]->is_environment() && sphere > 0
                         ? static_cast<float>(fluxes[s] / sphere)
                         : 0.f);
  }
}

/// Approximate irradiance without occlusion.
float SourceChoice::light_at(uint32_t source, const Vec3& place, const Vec3& normal) const {
  if (sources_[source]->is_environment()) return skies_[source];
  const auto lit = sources_[source]->sample_direct(place, Vec2(0.5f));
  if (!lit || !(lit->pdf > 0)) return 0;
  const float cosine = std::clamp(glm::dot(normal, lit->d) + kCosineMargin, 0.f, 1.f);
  const float light = mean_of(glm::abs(lit->radiance)) * cosine / lit->pdf;
  return std::isfinite(light) ? light : 0;
}

SourceChoice::At SourceChoice::at(const Vec3& place, const Vec3& normal) const {
  At at(*this);
  if (!samples_sources()) return at;
  float sum = 0;
  for (uint32_t s = 0; s < sources_.size(); ++s) {
    at.probabilities_[s] = light_at(s, place, normal);
    sum += at.probabilities_[s];
  }
  const bool any = sum > 0 && std::isfinite(sum);
  for (uint32_t s = 0; s < sources_.size(); ++s) {
    at.probabilities_[s] =
        any ? std::lerp(at.probabilities_[s] / sum, shares_[s], kFluxShare) : shares_[s];
  }
  return at;
}

uint32_t SourceChoice::At::pick(float u) const {
  const auto last = static_cast<uint32_t>(choice_.sources_.size() - 1);
  if (!choice_.samples_sources()) {
    const auto& ends = choice_.ends_;
    const double place = static_cast<double>(u) * ends.back();
    const auto after = std::upper_bound(ends.begin(), ends.end(), place);
    return std::min(static_cast<uint32_t>(after - ends.begin()), last);
  }
  float end = 0;
  for (uint32_t s = 0; s < last; ++s) {
    end += probabilities_[s];
    if (u < end) return s;
  }
  return last;
}

}  // namespace kinome
