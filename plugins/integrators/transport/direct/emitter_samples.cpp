#include "transport/direct/emitter_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "kinome/wide/vectors.h"

namespace kinome::transport {

using namespace wide;

namespace {

/// Maximum number of emitters for which one random number selects the emitter and, stretched, the
/// position on it. Positions on each emitter are then well distributed. With more emitters, too few
/// digits of the number would be left.
constexpr uint32_t kMaxStretchedEmitters = 64;

DirectBlock make_direct(Arena& a) {
  return {a.three(), a.floats(), a.floats(), a.three(), a.floats()};
}

/// True if no BSDF ray can hit the emitter, so that emitter samples must find all of its light.
bool is_sampled_alone(const Emitter& emitter) {
  return !emitter.shape() && !emitter.is_environment();
}

}  // namespace

void drop_self_occlusion(const Emitter& emitter, const SurfaceBlock& points, const uint32_t* which,
                         size_t count, const DirectBlock& samples) {
  if (!emitter.shape()) return;
  for (size_t i = 0; i < count; ++i) {
    const uint32_t k = which[i];
    if (points.shape[k] != emitter.shape()) continue;
    const float off = std::abs(glm::dot(points.n.at(k), samples.d.at(k))) * samples.distance[k];
    if (!(off > points.p_error[k])) samples.pdf[k] = 0;
  }
}

EmitterSamples::EmitterSamples(const SceneTable& scene, size_t points)
    : emitters_(scene.scene().emitters()),
      pick_pdf_(1 / static_cast<float>(std::max<size_t>(1, emitters_.size()))),
      arena_(points),
      light_(make_direct(arena_)),
      u_(arena_.two()),
      u_pick_(arena_.floats()),
      pick_(arena_.indices()),
      order_(arena_.indices()),
      next_(emitters_.size()),
      part_p_(arena_.three()),
      part_u_(arena_.two()),
      part_(make_direct(arena_)) {}

void EmitterSamples::sample(const Sampler& sampler, const PixelSamples& samples, uint32_t dimension,
                            const SurfaceBlock& points, const uint32_t* owner, size_t count,
                            Numbers& numbers) {
  if (!have_common_origin()) {
    numbers.fill_2d(sampler, samples, dimension + 1, owner, count, u_);
  }
  if (emitters_.size() == 1) {
    emitters_[0]->sample_direct_block(points.p, u_, count, light_);
    if (is_sampled_alone(*emitters_[0])) std::fill_n(light_.is_delta, count, 1.f);
    if (emitters_[0]->shape()) {
      std::iota(order_, order_ + count, 0u);
      drop_self_occlusion(*emitters_[0], points, order_, count, light_);
    }
    return;
  }
  const bool stretched = emitters_.size() <= kMaxStretchedEmitters;
  if (!stretched) numbers.fill_1d(sampler, samples, dimension, owner, count, u_pick_);
  pick(stretched ? u_.x : u_pick_, count);
  if (stretched) {
    const float scale = static_cast<float>(emitters_.size());
    for_lanes(count, [&](size_t i) {
      const Float offset = Float::load(u_.x + i) * scale - to_float(Int::load(pick_ + i));
      min(offset, kOneMinusEpsilon).store(u_.x + i);
    });
  }
  sample_picked(points);
}

/// Also sorts the points by emitter: next_[e] is the end of the points of emitter e, if it is used.
void EmitterSamples::pick(const float* u, size_t count) {
  const float scale = static_cast<float>(emitters_.size());
  const auto last = static_cast<int32_t>(emitters_.size()) - 1;
  for_lanes(count, [&](size_t i) {
    clamp(to_int(Float::load(u + i) * scale), Int(0), Int(last)).store(pick_ + i);
  });
  next_.clear();
  for (size_t i = 0; i < count; ++i) next_.add(pick_[i]);
  uint32_t first = 0;
  for (const uint32_t e : next_.used()) first += std::exchange(next_[e], first);
  for (size_t i = 0; i < count; ++i) order_[next_[pick_[i]]++] = static_cast<uint32_t>(i);
}

void EmitterSamples::sample_picked(const SurfaceBlock& points) {
  size_t first = 0;
  for (const uint32_t e : next_.used()) {
    const size_t end = next_[e], n = end - first;
    const uint32_t* const indices = order_ + first;
    // The last vector reaches into the next emitter's points, or into the padding, which holds
    // valid indices of earlier points.
    for_lanes(n, [&](size_t i) {
      const Int k = Int::load(indices + i);
      gather(points.p, k).store(part_p_, i);
      gather(u_, k).store(part_u_, i);
    });
    emitters_[e]->sample_direct_block(part_p_, part_u_, n, part_);
    if (is_sampled_alone(*emitters_[e])) std::fill_n(part_.is_delta, n, 1.f);
    for (size_t i = 0; i < n; ++i) {
      const uint32_t k = indices[i];
      light_.d.set(k, part_.d.at(i));
      light_.radiance.set(k, part_.radiance.at(i));
      light_.distance[k] = part_.distance[i];
      light_.pdf[k] = part_.pdf[i];
      light_.is_delta[k] = part_.is_delta[i];
    }
    drop_self_occlusion(*emitters_[e], points, indices, n, light_);
    first = end;
  }
}

}  // namespace kinome::transport
