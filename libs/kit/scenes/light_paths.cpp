#include "kit/scenes/light_paths.h"

#include <algorithm>
#include <cmath>

namespace kinome::check {
namespace {

/// Returns true if any of the emitter's functions shows that its light comes from infinitely far.
bool is_from_afar(const EmitterScene& at, const std::vector<EmissionSample>& rays, Random& random) {
  if (at.emitter().is_environment()) return true;
  if (at.emitter().is_surface()) return false;
  for (int i = 0; i < 64; ++i) {
    const auto sample = at.emitter().sample_direct(at.random_point(random), random.unit2());
    if (sample) return !(sample->distance < kInfinity);
  }
  return !rays.empty() && rays[0].pdf_position > 0;
}

}  // namespace

ProbeRays::ProbeRays(const EmitterScene& at, int count, uint64_t seed) : tries(count) {
  Random random(seed);
  Vec3 sum_of_directions(0.f);
  glm::dvec3 sum_of_origins(0.);
  for (int i = 0; i < count; ++i) {
    const auto ray = random_emission(at.emitter(), random);
    if (!ray || is_black(ray->power) || !is_finite(ray->o) || !is_finite(ray->d)) continue;
    rays.push_back(*ray);
    sum_of_directions += ray->d;
    sum_of_origins += glm::dvec3(ray->o);
  }
  is_distant = is_from_afar(at, rays, random);
  if (rays.empty()) return;
  const auto n = static_cast<float>(rays.size());
  origin = Vec3(sum_of_origins / static_cast<double>(n));
  for (const EmissionSample& ray : rays) spread = std::max(spread, glm::length(ray.o - origin));
  // Light that leaves in all directions has no mean direction; use an arbitrary one.
  direction = glm::length(sum_of_directions) > 0.1f * n ? glm::normalize(sum_of_directions)
                                                        : rays[0].d;
}

namespace {

/// Returns the extent of a local emitter, or 1 if it has none.
float size_of(const ProbeRays& probes) {
  const float rounding = 1e-5f * (1 + max_component(glm::abs(probes.origin)));
  return probes.spread > rounding ? probes.spread : 1;
}

}  // namespace

Receiver plane_in_the_way(const ProbeRays& probes, const Aabb& bounds) {
  const Vec3& d = probes.direction;
  if (!probes.is_distant) {
    const float distance = 2 * size_of(probes);
    return Receiver::plane(probes.origin + distance * d, Frame::from_normal(-d), Vec2(distance));
  }
  // The face of the scene's bounds that is most perpendicular to the light.
  const Vec3 size = glm::abs(d);
  const int axis = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
  const Vec3 half = 0.5f * bounds.extent();
  Vec3 centre = bounds.centre();
  centre[axis] = bounds.lo[axis];
  Frame frame;
  frame.s = frame.t = frame.n = Vec3(0.f);
  frame.s[(axis + 1) % 3] = frame.t[(axis + 2) % 3] = frame.n[axis] = 1;
  return Receiver::plane(centre, frame, {half[(axis + 1) % 3], half[(axis + 2) % 3]});
}

Receiver sphere_in_the_way(const ProbeRays& probes, const Aabb& bounds) {
  if (probes.is_distant) {
    const Vec3 half = 0.5f * bounds.extent();
    return Receiver::sphere(bounds.centre(), std::min({half.x, half.y, half.z}));
  }
  const float radius = 2 * size_of(probes);
  // The emitter isn't at the centre, so that symmetry doesn't hide faults.
  return Receiver::sphere(probes.origin + 0.2f * radius * Vec3(0.6f, -0.64f, 0.48f), radius);
}

namespace {

std::vector<ReceiverCells::Hit> hits_of(const Receiver& receiver, const ProbeRays& probes) {
  std::vector<ReceiverCells::Hit> hits;
  for (const EmissionSample& ray : probes.rays) {
    receiver.for_each_crossing(ray.o, ray.d, [&](const Vec2& uv, bool is_front) {
      hits.push_back({uv, is_front});
    });
  }
  return hits;
}

std::vector<Vec2> points_of(const std::vector<ReceiverCells::Hit>& hits) {
  std::vector<Vec2> points;
  for (const ReceiverCells::Hit& hit : hits) points.push_back(hit.uv);
  return points;
}

double expected_of(const Receiver& receiver, const ProbeRays& probes, int count) {
  return static_cast<double>(hits_of(receiver, probes).size()) * count / probes.tries;
}

}  // namespace

ReceiverPlan::ReceiverPlan(const Receiver& receiver, const ProbeRays& probes, int count)
    : cells(hits_of(receiver, probes), expected_of(receiver, probes, count)),
      density(points_of(hits_of(receiver, probes))),
      expected_hits(expected_of(receiver, probes, count)) {}

CellFlux flux_by_emission(const Emitter& emitter, const Receiver& receiver,
                          const ReceiverCells& cells, int count, uint64_t seed) {
  Random random(seed);
  CellFlux flux(cells.count());
  for (int i = 0; i < count; ++i) {
    const auto ray = random_emission(emitter, random);
    if (ray && is_finite(ray->power)) {
      receiver.for_each_crossing(ray->o, ray->d, [&](const Vec2& uv, bool is_front) {
        flux.add(cells.cell_of(uv, is_front), ray->power);
      });
    }
    flux.end_sample();
  }
  return flux;
}

CellFlux flux_by_sample_direct(const Emitter& emitter, const Receiver& receiver,
                               const ReceiverPlan& plan, int count, uint64_t seed,
                               const Emitter* minus) {
  Random random(seed);
  CellFlux flux(plan.cells.count());
  for (int i = 0; i < count; ++i) {
    const ProbeGrid::Sample sampled = plan.density.sample(random);
    const Vec2 u = random.unit2();
    const Receiver::Point point = receiver.at(sampled.uv);
    const auto scale = static_cast<float>(receiver.area() / sampled.pdf);
    const auto add = [&](const Emitter& from, float sign) {
      const auto sample = from.sample_direct(point.p, u);
      if (!sample || !(sample->pdf > 0) || !is_finite(sample->radiance)) return;
      const float cosine = glm::dot(point.n, sample->d);
      const Rgb irradiance = sample->radiance * (std::abs(cosine) / sample->pdf);
      flux.add(plan.cells.cell_of(sampled.uv, cosine > 0), irradiance * (sign * scale));
    };
    add(emitter, 1);
    if (minus) add(*minus, -1);
    flux.end_sample();
  }
  return flux;
}

}  // namespace kinome::check
