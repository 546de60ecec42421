#include "transport/light_paths/emission.h"

#include <algorithm>
#include <numeric>

#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

size_t Emission::max_rays(const SceneTable& scene, size_t samples) {
  return padded(samples) + kBlockLanes * std::min(scene.scene().emitters().size(), samples);
}

Emission::Emission(const SceneTable& scene, size_t samples)
    : emitters_(scene.scene().emitters()),
      per_sample_(samples),
      all_(per_sample_.indices()),
      pick_(per_sample_.indices()),
      u_pick_(per_sample_.floats()),
      per_ray_(max_rays(scene, samples)),
      owner_(per_ray_.indices()),
      live_(per_ray_.floats()),
      place_(per_ray_.two()),
      direction_(per_ray_.two()),
      rays_{per_ray_.three(), per_ray_.three(), per_ray_.three()},
      next_(emitters_.size()) {
  std::iota(all_, all_ + samples, 0u);
}

void Emission::pick(const Sampler& sampler, const PixelSamples& samples, Numbers& numbers) {
  const size_t count = samples.count();
  numbers.fill_1d(sampler, samples, 0, all_, count, u_pick_);
  const float scale = emitters();
  const auto last = static_cast<int32_t>(emitters_.size()) - 1;
  for_lanes(count, [&](size_t i) {
    clamp(to_int(Float::load(u_pick_ + i) * scale), Int(0), Int(last)).store(pick_ + i);
  });
  sort(count);
  numbers.fill_2d(sampler, samples, 1, owner_, count_, place_);
}

/// Counting sort, as in Surfaces.
void Emission::sort(size_t samples) {
  next_.clear();
  for (size_t i = 0; i < samples; ++i) next_.add(pick_[i]);
  ranges_.clear();
  uint32_t at = 0;
  for (const uint32_t e : next_.used()) {
    const uint32_t of_emitter = next_[e];
    next_[e] = at;
    ranges_.push_back({emitters_[e], at, of_emitter});
    at += static_cast<uint32_t>(padded(of_emitter));
  }
  count_ = at;
  for (uint32_t i = 0; i < samples; ++i) owner_[next_[pick_[i]]++] = i;
  for (const Range& range : ranges_) {
    const size_t end = range.first + range.count, last = range.first + padded(range.count);
    std::fill(owner_ + end, owner_ + last, owner_[end - 1]);
    std::fill(live_ + range.first, live_ + end, 1.f);
    std::fill(live_ + end, live_ + last, 0.f);
  }
}

void Emission::sample(const Sampler& sampler, const PixelSamples& samples, Numbers& numbers) {
  numbers.fill_2d(sampler, samples, 3, owner_, count_, direction_);
  for (const Range& range : ranges_) {
    range.emitter->sample_emission_block(place_.from(range.first), direction_.from(range.first),
                                         range.count, rays_.from(range.first));
  }
}

}  // namespace kinome::transport
