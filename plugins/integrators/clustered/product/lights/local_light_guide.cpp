// The part of LocalLight that learns the guides: which light contributes to the image.
#include <algorithm>
#include <cmath>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/spread.h"
#include "clustered/product/lights/tried_points.h"
#include "kinome/film.h"
#include "kinome/render_context.h"
#include "kinome/sensor.h"

namespace kinome {
namespace {

/// Effective sample size of a round from which its draws are used: the minimum number of points
/// that a tile uses.
constexpr double kMinEffectiveDrawsOfRound = kMinPointBlocks * kPointBlockSize;
/// Minimum effective sample size from which a guide is learned. Fewer draws may miss most of the
/// light.
constexpr double kMinEffectiveDraws = 64;
/// Effective sample size from which on a guide isn't improved any more.
constexpr double kMaxEffectiveDraws = 1024;
/// Maximum number of rounds that learn. Each uses the guide of the previous rounds, and so finds
/// more useful light.
constexpr uint64_t kMaxRounds = 5;
/// Number of points that each seen position evaluates, and number of rays that it sends to them.
constexpr uint32_t kEvaluatedPoints = 64, kRaysPerPosition = 4;
constexpr size_t kViewsOfChunk = 64;
constexpr uint32_t kViewsOfPart = 256;
enum GuideSeed : uint64_t {
  kSeedOfPositions = 0x7365656e,
  kSeedOfRounds = 0x726f756e,
  kSeedOfUses = 0x6c6f6f6b
};

struct FlatPoint {
  const LightPoint* point;
  const Reflection* reflection;  ///< nullptr if the surface is Lambertian
};

/// Sends rays from seen positions to light points, and finds the contribution of each point.
class UsePilot {
 public:
  UsePilot(const Scene& scene, const transport::SceneTable* passing,
           std::span<const FlatPoint> points, uint64_t seed)
      : scene_(scene), passing_(passing), points_(points), seed_(seed) {}

  struct Found {
    uint32_t point;
    float use;
  };

  /// Appends the points that the positions `views` see, with their shares of the light there.
  void look(std::span<const SurfaceInteraction> views, size_t first_view, RenderCounters& counters,
            std::vector<Found>& out) {
    shots_.clear();
    rays_.clear();
    for (size_t v = 0; v < views.size(); ++v) {
      aim(views[v], hash_words(seed_, first_view + v), static_cast<uint32_t>(v));
    }
    const std::vector<float> shares = arriving_shares(scene_, passing_, rays_, counters);
    // Dark positions have the same weight as bright ones.
    for (size_t begin = 0, end = 0; begin < shots_.size(); begin = end) {
      float sum = 0;
      for (; end < shots_.size() && shots_[end].view == shots_[begin].view; ++end) {
        shots_[end].light *= shares[end];
        sum += shots_[end].light;
      }
      if (!(sum > 0) || !std::isfinite(sum)) continue;
      for (size_t i = begin; i < end; ++i) {
        if (shots_[i].light > 0) out.push_back({shots_[i].point, shots_[i].light / sum});
      }
    }
  }

 private:
  struct Shot {
    uint32_t view, point;
    float light;
  };

  /// Returns the approximate unshadowed light of a point that arrives at a surface, times cosine.
  float light_of(const SurfaceInteraction& si, const FlatPoint& at) const {
    const Vec3 to = at.point->position - si.p;
    const float squared = glm::dot(to, to);
    if (!(squared > 0)) return 0;
    const Vec3 d = to / std::sqrt(squared);
    const float side = si.wi.z >= 0 ? 1.f : -1.f;
    const float cosine = side * glm::dot(si.frame.n, d);
    if (!(cosine > 0) || !(glm::dot(at.point->normal, d) < 0)) return 0;
    const Rgb power = at.reflection ? at.reflection->incident : at.point->power;
    const Vec3 back = -d;
    const float sent = at.reflection ? simd::sent_fraction(at.reflection->lobe, &back.x, 0) : 1.f;
    const float light = mean_of(glm::abs(power)) * sent * cosine *
                        std::abs(glm::dot(at.point->geometric, d)) / squared;
    return std::isfinite(light) ? light : 0;
  }

  /// Makes rays from one position to points, selected by light_of().
  void aim(const SurfaceInteraction& si, uint64_t seed, uint32_t view) {
    const auto count = static_cast<uint32_t>(points_.size());
    const uint32_t evaluated = std::min(kEvaluatedPoints, count);
    const float offset = random_float(seed, 0);
    float lights[kEvaluatedPoints], sum = 0;
    uint32_t which[kEvaluatedPoints];
    for (uint32_t k = 0; k < evaluated; ++k) {
      const float at = (static_cast<float>(k) + offset) / static_cast<float>(evaluated);
      which[k] = std::min(static_cast<uint32_t>(at * static_cast<float>(count)), count - 1);
      lights[k] = light_of(si, points_[which[k]]);
      sum += lights[k];
    }
    const float step = sum / kRaysPerPosition;
    if (!(step > 0) || !std::isfinite(step)) return;
    const Bsdf& bsdf = si.shape->bsdf();
    float next = step * random_float(seed, 1), so_far = 0;
    for (uint32_t k = 0; k < evaluated; ++k) {
      so_far += lights[k];
      if (!(next < so_far)) continue;
      float parts = 0;
      for (; next < so_far; next += step) ++parts;
      const Vec3 to = points_[which[k]].point->position - si.p;
      const Vec3 d = to / glm::length(to);
      const Vec3 wo = si.frame.to_local(d);
      const Rgb f = bsdf.eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy, wo).f;
      const float light = parts * step * mean_of(f) / std::max(std::abs(wo.z), 1e-6f);
      if (!(light > 0)) continue;
      rays_.push_back(si.shadow_ray_to(points_[which[k]].point->end_of_ray(d)));
      shots_.push_back({view, which[k], light});
    }
  }

  const Scene& scene_;
  const transport::SceneTable* const passing_;
  const std::span<const FlatPoint> points_;
  const uint64_t seed_;
  std::vector<Shot> shots_;
  std::vector<Ray> rays_;
};

/// Returns the effective sample size: the number of draws of equal use whose sum would be as
/// uncertain.
double effective_number(std::span<const LightGuide::Use> uses) {
  double sum = 0, squares = 0;
  for (const LightGuide::Use& use : uses) {
    sum += use.use;
    squares += static_cast<double>(use.use) * use.use;
  }
  return squares > 0 ? sum * sum / squares : 0;
}

}  // namespace

std::vector<SurfaceInteraction> places_seen(const Scene& scene, const Sensor& sensor,
                                            uint32_t count, uint64_t seed, RenderContext& context) {
  const Rect& crop = sensor.film().crop();
  const uint64_t x = hash_words(seed, kSeedOfPositions, 1),
                 y = hash_words(seed, kSeedOfPositions, 2);
  struct Part {
    std::vector<SurfaceInteraction> places;
    RenderCounters counters;
  };
  std::vector<Part> parts((count + kViewsOfPart - 1) / kViewsOfPart);
  context.scheduler.parallel_for(parts.size(), [&](size_t k) {
    Part& part = parts[k];
    const auto first = static_cast<uint32_t>(k) * kViewsOfPart;
    std::vector<RayHit> rays(std::min(kViewsOfPart, count - first));
    for (uint32_t i = 0; i < rays.size(); ++i) {
      const Vec2 u = owen_sobol_point(first + i, x, y);
      const Vec2 place(static_cast<float>(crop.x0) + u.x * static_cast<float>(crop.width()),
                       static_cast<float>(crop.y0) + u.y * static_cast<float>(crop.height()));
      rays[i].ray = sensor.sample_ray(place, Vec2(0.5f));
    }
    scene.intersect(rays, Coherence::kIncoherent, part.counters);
    part.counters[RayKind::kCamera] += rays.size();
    for (const RayHit& ray : rays) {
      if (!ray.hit.valid()) continue;
      const SurfaceInteraction si = scene.interaction(ray);
      if (any(si.shape->bsdf().lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) {
        part.places.push_back(si);
      }
    }
  });
  std::vector<SurfaceInteraction> places;
  for (const Part& part : parts) {
    places.insert(places.end(), part.places.begin(), part.places.end());
    context.job.stats().counters.add(part.counters);
  }
  return places;
}

/// Returns the contributions of the draws to the seen positions.
std::vector<LightGuide::Use> LocalLight::find_uses(const std::vector<Drawn>& chunks,
                                                   std::span<const SurfaceInteraction> seen,
                                                   uint64_t seed, RenderContext& context) const {
  std::vector<FlatPoint> points;
  std::vector<LightGuide::Use> uses;
  for (const Drawn& chunk : chunks) {
    for (size_t i = 0; i < chunk.points.size(); ++i) {
      const LightPoint& p = chunk.points[i];
      const bool lambertian = p.reflection == LightPoint::kLambertian;
      points.push_back({&p, lambertian ? nullptr : &chunk.reflections[p.reflection]});
      uses.push_back({chunk.origins[i].source, chunk.origins[i].numbers, 0.f});
    }
  }
  if (points.empty()) return uses;
  const size_t parts = (seen.size() + kViewsOfChunk - 1) / kViewsOfChunk;
  std::vector<std::vector<UsePilot::Found>> found(parts);
  std::vector<RenderCounters> counters(parts);
  context.scheduler.parallel_for(parts, [&](size_t part) {
    const size_t begin = part * kViewsOfChunk;
    UsePilot pilot(scene_, passing(), points, seed);
    pilot.look(seen.subspan(begin, std::min(kViewsOfChunk, seen.size() - begin)), begin,
               counters[part], found[part]);
  });
  for (size_t part = 0; part < parts; ++part) {
    for (const UsePilot::Found& f : found[part]) uses[f.point].use += f.use;
    context.job.stats().counters.add(counters[part]);
  }
  return uses;
}

std::vector<LocalLight::Drawn> LocalLight::learn_guide(bool bounce, uint32_t count,
                                                       std::span<const SurfaceInteraction> seen,
                                                       uint64_t seed, RenderContext& context) {
  LightGuide& guide = bounce ? bounce_guide_ : surface_guide_;
  std::vector<float> shares;
  for (const Source& source : sources_) {
    shares.push_back(bounce ? source.bounce_share : source.surface_share);
  }
  std::vector<LightGuide::Use> all;
  double known = 0;
  uint32_t draws = 0;
  for (uint64_t round = 0;; ++round) {
    const uint64_t own = hash_words(seed, kSeedOfRounds, round);
    std::vector<Drawn> drawn;
    draw_part(bounce, count, own, context, drawn);
    // Checked in all rounds, because guided rounds avoid light that only mirrors reflect.
    for (const Drawn& chunk : drawn) {
      needs_eye_rays_ = needs_eye_rays_ || chunk.meets_mirroring;
      has_glossy_caustics_ = has_glossy_caustics_ || chunk.lamp_meets_mirroring;
    }
    if (seen.empty() || round == kMaxRounds) return drawn;
    auto uses = find_uses(drawn, seen, hash_words(own, kSeedOfUses), context);
    const double number = effective_number(uses);
    if (guide.empty() ? number >= kMaxEffectiveDraws
                      : number >= kMinEffectiveDrawsOfRound && known >= kMaxEffectiveDraws) {
      return drawn;
    }
    // The weight of each round is its effective sample size.
    double sum = 0;
    for (const LightGuide::Use& use : uses) sum += static_cast<double>(use.use);
    for (LightGuide::Use& use : uses) {
      if (!(use.use > 0)) continue;
      use.use = static_cast<float>(static_cast<double>(use.use) * (number / sum));
      all.push_back(use);
    }
    known += number;
    draws += count;
    if (known >= kMinEffectiveDraws) guide = LightGuide(shares, all, draws);
  }
}

}  // namespace kinome
