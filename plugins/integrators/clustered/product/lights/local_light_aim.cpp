// The part of LocalLight that aims light walks at the region whose light contributes to the image.
#include <algorithm>
#include <cmath>

#include "clustered/product/lights/light_point_draw.h"
#include "clustered/product/lights/local_light.h"
#include "clustered/product/tiles/spread.h"
#include "kinome/render_context.h"

namespace kinome {
namespace {

/// Share of the probability of sources that depends on their total flux. The rest depends on the
/// part that is emitted toward the spheres.
constexpr double kTotalFluxShare = 0.5;
/// Lower limit of estimates of this part.
constexpr double kMinPart = 1e-12;
/// Minimum number of lit points for weights to depend on light.
constexpr size_t kMinLit = 16;
/// Number of seen positions whose surroundings a thread explores together.
constexpr size_t kPositionsOfPart = 64;
/// Random numbers of an eye point, after those of its rays.
enum AimNumber : uint32_t { kSource = 16, kPlace };
enum AimSeed : uint64_t { kSeedOfRegion = 0x72656769, kSeedOfAimedFlux = 0x61696d66 };

bool meets(const AimSphere& sphere, const Vec3& o, const Vec3& d) {
  const Vec3 to = sphere.centre - o;
  const float along = glm::dot(to, d);
  const Vec3 off = to - d * along;
  return along > -sphere.radius && glm::dot(off, off) < sqr(sphere.radius);
}

}  // namespace

void LocalLight::aim_sources(std::span<const SurfaceInteraction> seen, uint64_t seed,
                             RenderContext& context) {
  aims_ = aim_spheres(lit_positions(seen, hash_words(seed, kSeedOfRegion), context));
  for (Source& source : sources_) {
    const Emitter& emitter = *source.emitter;
    if (source.kind == Kind::kSurface) continue;
    const auto some = emitter.sample_emission(Vec2(0.5f), Vec2(0.5f));
    if (!some) continue;
    const auto density = emitter.emission_density(some->d);
    if (density && density->position > 0) {
      source.disks = AimDisks(aims_, density->position);
    } else if (emitter.is_delta()) {
      for (const AimSphere& sphere : aims_) {
        source.cones.add(some->o, sphere, [&](const Vec3& axis, float /*sine*/) {
          const auto plain = emitter.emission_density(axis);
          return plain ? plain->direction : 0.f;
        });
      }
    }
  }
  if (aims_.empty()) return;
  double all = 0, all_aimed = 0;
  std::vector<double> aimed;
  for (const Source& source : sources_) {
    all += source.flux;
    all_aimed +=
        aimed.emplace_back(flux_to_aims(source, hash_words(seed, kSeedOfAimedFlux, aimed.size())));
  }
  if (!(all > 0) || !std::isfinite(all_aimed)) return;
  aimed_share_ = std::min(1., all_aimed / all);
  if (!(all_aimed > 0)) return;
  double end = 0;
  for (size_t s = 0; s < sources_.size(); ++s) {
    const double plain = sources_[s].flux / all;
    const double share = std::lerp(aimed[s] / all_aimed, plain, kTotalFluxShare);
    sources_[s].bounce_share = static_cast<float>(share);
    sources_[s].aimed_part =
        static_cast<float>(std::clamp(aimed[s] / sources_[s].flux, kMinPart, 1.));
    bounce_ends_[s] = end += static_cast<double>(sources_[s].bounce_share);
  }
}

std::vector<WeightedPosition> LocalLight::lit_positions(std::span<const SurfaceInteraction> seen,
                                                        uint64_t seed,
                                                        RenderContext& context) const {
  struct Part {
    std::vector<WeightedPosition> positions;
    std::vector<float> light;
    RenderCounters counters;
  };
  std::vector<Part> parts((seen.size() + kPositionsOfPart - 1) / kPositionsOfPart);
  context.scheduler.parallel_for(parts.size(), [&](size_t k) {
    const size_t first = k * kPositionsOfPart;
    const auto own = seen.subspan(first, std::min(kPositionsOfPart, seen.size() - first));
    Part& part = parts[k];
    const std::vector<EyePoint> points = points_around(scene_, own, first, seed, part.counters);
    for (const EyePoint& point : points) part.positions.push_back({point.si.p, point.weight});
    part.light = light_at(points, part.counters);
  });
  std::vector<WeightedPosition> positions;
  std::vector<float> light;
  for (const Part& part : parts) {
    positions.insert(positions.end(), part.positions.begin(), part.positions.end());
    light.insert(light.end(), part.light.begin(), part.light.end());
    context.job.stats().counters.add(part.counters);
  }
  double sum = 0;
  size_t count = 0;
  for (const float value : light) {
    sum += static_cast<double>(value);
    count += value > 0 ? 1 : 0;
  }
  if (count < kMinLit) return positions;
  // Points that are brighter than the average lit point count little more than this.
  const auto mean = static_cast<float>(sum / static_cast<double>(count));
  for (size_t i = 0; i < light.size(); ++i) positions[i].weight *= light[i] / (light[i] + mean);
  return positions;
}

std::vector<float> LocalLight::light_at(std::span<const EyePoint> points,
                                        RenderCounters& counters) const {
  std::vector<Ray> rays(points.size());
  std::vector<float> light(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfaceInteraction& si = points[i].si;
    const uint64_t seed = points[i].seed;
    const SourceChoice::At asked = asked_at(si, si.wi.z >= 0 ? 1.f : -1.f);
    const uint32_t source = asked.pick(random_float(seed, kSource));
    const auto direct = sources_[source].emitter->sample_direct(
        si.p, {random_float(seed, kPlace), random_float(seed, kPlace + 1)});
    rays[i].tmax = -1;
    if (!direct || !(direct->pdf > 0)) continue;
    const Rgb f = si.shape->bsdf()
                      .eval_pdf(si, Lobe::kDiffuse | Lobe::kGlossy, si.frame.to_local(direct->d))
                      .f;
    const float found =
        mean_of(glm::abs(f * direct->radiance)) / (direct->pdf * asked.probability(source));
    if (!(found > 0) || !std::isfinite(found)) continue;
    light[i] = found;
    rays[i] = si.shadow_ray(direct->d, direct->distance);
  }
  const std::vector<float> shares = arriving_shares(scene_, passing(), rays, counters);
  for (size_t i = 0; i < points.size(); ++i) light[i] *= shares[i];
  return light;
}

AimCones LocalLight::surface_cones(const SurfaceInteraction& x) const {
  AimCones cones;
  for (const AimSphere& sphere : aims_) {
    cones.add(x.p, sphere, [&](const Vec3& axis, float sine) {
      // Cones that the surface itself cuts off are not used.
      return glm::dot(axis, x.frame.n) > sine ? surface_emission_pdf(x, axis) : 0.f;
    });
  }
  return cones;
}

int LocalLight::pick(const Source& source, Vec2& position, Vec2& direction) {
  return source.disks.count() > 0 ? pick_aim(source.disks.count(), position.x)
                                  : pick_aim(source.cones.count(), direction.x);
}

float LocalLight::aim(const Source& source, int aimed, const Vec2& position, const Vec2& direction,
                      EmissionSample& ray) {
  const Emitter& emitter = *source.emitter;
  if (source.disks.count() > 0) {
    if (aimed >= 0) ray.o = source.disks.sample(aimed, position, ray.d, ray.o);
    const float gain = source.disks.pdf(ray.o, ray.d, aimed) / source.disks.plain();
    ray.power /= gain;
    return gain;
  }
  if (source.cones.count() == 0) return 1;
  if (aimed >= 0) {
    ray.o = source.cones.from();
    ray.d = source.cones.sample(aimed, direction);
  }
  const auto density = emitter.emission_density(ray.d);
  const float plain = density ? density->direction : 0.f;
  const float pdf = source.cones.pdf(ray.d, plain, aimed);
  // Rounding may put a ray at the rim of the emitter's own cone outside.
  const float gain = plain > 0 ? pdf / plain : 1 - kAimedShare;
  if (aimed < 0) {
    ray.power /= gain;
    return gain;
  }
  const float distance = source.cones.distance(aimed);
  const auto light = emitter.sample_direct(ray.o + distance * ray.d, Vec2(0.5f));
  ray.power = light ? light->radiance * (sqr(light->distance) / pdf) : Rgb(0.f);
  return gain;
}

/// Estimates the flux that is emitted toward the largest sphere, from a few draws.
double LocalLight::flux_to_aims(const Source& source, uint64_t seed) const {
  const uint32_t draws = draws_of_flux();
  const LightNumbers numbers(seed);
  double flux = 0;
  for (uint32_t i = 0; i < draws; ++i) {
    Vec2 position = numbers.position(i), direction = numbers.direction(i);
    std::optional<EmissionSample> ray;
    if (source.kind == Kind::kSurface) {
      SurfaceInteraction x = source.emitter->shape()->sample_surface(position);
      x.shape = source.emitter->shape();
      ray = leave_surface(*source.emitter, x, direction, surface_cones(x));
    } else {
      const int aimed = pick(source, position, direction);
      ray = source.emitter->sample_emission(position, direction).value_or(EmissionSample{});
      aim(source, aimed, position, direction, *ray);
    }
    if (ray && meets(aims_.back(), ray->o, ray->d)) flux += mean_of(glm::abs(ray->power)) / draws;
  }
  return flux;
}

}  // namespace kinome
