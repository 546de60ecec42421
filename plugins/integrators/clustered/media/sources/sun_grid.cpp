#include "clustered/media/sources/sun_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "kinome/sampler.h"
#include "kinome/stats.h"
#include "kinome/wide/vectors.h"
#include "transport/media/tracking/medium_shadows.h"
#include "transport/shadows/rays.h"

namespace kinome {
namespace {

/// Minimum weight of a cell, and of a cell beside a lit one, relative to a lit cell.
constexpr float kMinLit = 0.02f, kBesideLit = 0.25f;
/// Weight outside of the grid.
constexpr float kLitOutside = 0.5f;
/// Approximation of exp(-x) for x >= 0.
float falloff(float x) {
  return 1 / (1 + x * (1 + x * (0.5f + x * (1 / 6.f))));
}

/// Use of random numbers (RandomSeeds).
constexpr uint32_t kSunUse = 0x73756e;

}  // namespace

SunGrid::SunGrid(const transport::SceneTable& scene, const transport::MediaTable& media,
                 const Vec3& d, uint32_t resolution, RenderContext& context)
    : resolution_(resolution),
      box_(scene.scene().bounds()),
      transmittance_(size_t{resolution} * resolution * resolution) {
  if (box_.empty()) box_ = Aabb(Vec3(-1), Vec3(1));
  context.scheduler.parallel_for(
      resolution, [&](size_t z) { trace_slab(scene, media, d, static_cast<uint32_t>(z)); });
  spread();
}

/// Traces the shadow rays of the cells of one z. They begin in vacuum, because the medium at a
/// point isn't known; so attenuation is left out up to the first boundary.
void SunGrid::trace_slab(const transport::SceneTable& scene, const transport::MediaTable& media,
                         const Vec3& d, uint32_t z) {
  const size_t count = size_t{resolution_} * resolution_ * kRays;
  transport::Arena arena(count);
  transport::MediumShadows shadows(scene, media, count, count);
  SurfaceBlock points;
  points.p = arena.three(), points.n = arena.three(), points.p_error = arena.floats();
  float* const distance = arena.floats();
  uint32_t* const medium = arena.indices();
  uint32_t* const owner = arena.indices();
  Ray16* const rays = arena.untraced_rays();
  const Vec3 size = box_.extent() / static_cast<float>(resolution_);
  for (size_t i = 0; i < count; ++i) {
    const size_t cell = i / kRays;
    const uint64_t bits = hash_words(z, i, kSunUse), more = hash_words(z, i, kSunUse + 1);
    const Vec3 at(static_cast<float>(cell % resolution_), static_cast<float>(cell / resolution_),
                  static_cast<float>(z));
    const Vec3 u(to_unit_float(static_cast<uint32_t>(bits)),
                 to_unit_float(static_cast<uint32_t>(bits >> 32)),
                 to_unit_float(static_cast<uint32_t>(more)));
    points.p.set(i, box_.lo + size * (at + u));
  }
  std::fill_n(distance, arena.capacity(), kInfinity);
  using namespace wide;
  for_lanes(count, [&](size_t i) {
    transport::write_shadow_rays(points, i, wide::Vec3(d), Float(kInfinity), first_lanes(count - i),
                                 true, rays);
  });
  const uint32_t pixel = 0;
  const PixelSamples sample{&pixel, &pixel, 1, 0, 1, z};
  RenderCounters counters;
  shadows.trace(rays, count, medium, distance, owner, transport::RandomSeeds(sample, kSunUse),
                counters);
  for (size_t i = 0; i < count; ++i) {
    const kinome::Rgb t = shadows.transmittance().at(i);
    transmittance_[index(0, 0, z) + i / kRays] += (t.x + t.y + t.z) / (3 * kRays);
  }
}

/// Raises cells that the few rays may have missed.
void SunGrid::spread() {
  const std::vector<float> from = transmittance_;
  const float highest = *std::max_element(from.begin(), from.end());
  const auto at = [&](int64_t x, int64_t y, int64_t z) {
    const int64_t last = resolution_ - 1;
    const auto in = [last](int64_t i) {
      return static_cast<uint32_t>(std::clamp<int64_t>(i, 0, last));
    };
    return from[index(in(x), in(y), in(z))];
  };
  for (int64_t z = 0; z < resolution_; ++z) {
    for (int64_t y = 0; y < resolution_; ++y) {
      for (int64_t x = 0; x < resolution_; ++x) {
        const float beside = std::max({at(x - 1, y, z), at(x + 1, y, z), at(x, y - 1, z),
                                       at(x, y + 1, z), at(x, y, z - 1), at(x, y, z + 1)});
        float& cell = transmittance_[index(static_cast<uint32_t>(x), static_cast<uint32_t>(y),
                                           static_cast<uint32_t>(z))];
        cell = std::max({cell, kBesideLit * beside, highest > 0 ? kMinLit * highest : 1.f});
      }
    }
  }
}

float SunGrid::at(const Vec3& p) const {
  const Vec3 cell =
      (p - box_.lo) / glm::max(box_.extent(), Vec3(1e-20f)) * static_cast<float>(resolution_);
  const auto last = static_cast<float>(resolution_);
  for (int k = 0; k < 3; ++k) {
    if (!(cell[k] >= 0 && cell[k] < last)) return 1;
  }
  return transmittance_[index(static_cast<uint32_t>(cell.x), static_cast<uint32_t>(cell.y),
                              static_cast<uint32_t>(cell.z))];
}

void SunGrid::divide(const Vec3& o, const Vec3& d, float length, float extinction,
                     std::vector<Part>& parts) const {
  parts.clear();
  float t = 0, before = 1, sum = 0;  // `before`: that of t
  const auto add = [&](float end, float transmittance) {
    if (!(end > t)) return;
    const float after = falloff(extinction * end);
    sum += transmittance * std::max(before - after, 1e-30f);
    parts.push_back({t, end, sum});
    t = end, before = after;
  };
  float enter = 0, leave = length;
  for (int k = 0; k < 3; ++k) {
    const float inverse = 1 / (d[k] == 0 ? 1e-20f : d[k]);
    const float a = (box_.lo[k] - o[k]) * inverse, b = (box_.hi[k] - o[k]) * inverse;
    enter = std::max(enter, std::min(a, b)), leave = std::min(leave, std::max(a, b));
  }
  if (leave > enter) {
    add(enter, kLitOutside);
    const Vec3 size = glm::max(box_.extent(), Vec3(1e-20f)) / static_cast<float>(resolution_);
    const Vec3 p = (o + d * enter - box_.lo) / size;
    std::array<int, 3> cell, step;
    Vec3 next, delta;
    for (int k = 0; k < 3; ++k) {
      const int last = static_cast<int>(resolution_) - 1;
      cell[k] = static_cast<int>(std::clamp(p[k], 0.f, static_cast<float>(last)));
      step[k] = d[k] > 0 ? 1 : -1;
      delta[k] = d[k] == 0 ? kInfinity : size[k] / std::abs(d[k]);
      const float way =
          d[k] > 0 ? static_cast<float>(cell[k]) + 1 - p[k] : p[k] - static_cast<float>(cell[k]);
      next[k] = d[k] == 0 ? kInfinity : enter + std::max(way, 0.f) * delta[k];
    }
    for (;;) {
      const int k = next.x < next.y ? (next.x < next.z ? 0 : 2) : (next.y < next.z ? 1 : 2);
      add(std::min(next[k], leave),
          transmittance_[index(static_cast<uint32_t>(cell[0]), static_cast<uint32_t>(cell[1]),
                               static_cast<uint32_t>(cell[2]))]);
      if (!(next[k] < leave)) break;
      cell[k] += step[k];
      next[k] += delta[k];
      if (cell[k] < 0 || cell[k] >= static_cast<int>(resolution_)) break;
    }
  }
  add(length, kLitOutside);
}

}  // namespace kinome
