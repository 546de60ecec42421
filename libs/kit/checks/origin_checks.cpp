// Checks the origins of emitted rays, and the distances of sampled light.

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "kit/scenes/light_paths.h"
#include "kit/scenes/rays.h"
#include "kit/subject.h"

namespace kinome::check {
namespace {

std::string text_of(const Vec3& v) {
  return fmt::format("({:.5g}, {:.5g}, {:.5g})", v.x, v.y, v.z);
}

/// Counts faults, and keeps the first one.
struct FaultCount {
  int checked = 0, wrong = 0;
  std::string first;  ///< description of the first fault
  void add(const std::string& fault) {
    ++checked;
    if (fault.empty()) return;
    if (wrong++ == 0) first = fault;
  }
  /// Accepts 1 % of faults, because rounding decides at edges and grazing angles.
  bool is_fault() const { return wrong * 100 > checked; }
};

/// Describes what is wrong with the position at which a ray leaves a surface; "" if it is right.
std::string fault_on_surface(const EmitterScene& at, const EmissionSample& ray) {
  if (std::abs(glm::length(ray.n) - 1) > 1e-3f) return "a normal that is not of unit length";
  const Vec3 extent = at.emitter().shape()->bounds().extent();
  const float off = 0.01f * max_component(extent);
  const RayHit hit = trace(at.scene(), ray.o + off * ray.n, -ray.n);
  const bool is_there = hit.hit.valid() &&
                        std::abs(hit.ray.tmax - off) < 0.01f * off + 4 * ray.o_error &&
                        at.scene().interaction(hit).shape == at.emitter().shape();
  if (!is_there) return "an origin that is not on its surface, " + text_of(ray.o);
  if (std::abs(glm::dot(at.scene().interaction(hit).n, ray.n)) < 0.999f) {
    return "a normal that is not the surface's, at " + text_of(ray.o);
  }
  return "";
}

/// The same for an emitter without extent: sample_direct() at points of a ray must return the ray's
/// origin.
std::string fault_of_point_light(const EmitterScene& at, const EmissionSample& ray, float t) {
  const auto seen = at.emitter().sample_direct(ray.o + t * ray.d, Vec2(0.5f));
  if (!seen || is_black(seen->radiance)) {
    return "a ray from " + text_of(ray.o) + " to a point where sample_direct() returns no light";
  }
  const Vec3 light = ray.o + t * ray.d + seen->distance * seen->d;
  const float rounding = 1e-4f * (1 + t + max_component(glm::abs(ray.o)));
  if (glm::length(light - ray.o) < rounding) return "";
  return fmt::format("a ray from {}, but sample_direct() returns an emitter at {}", text_of(ray.o),
                     text_of(light));
}

/// The same for light from infinitely far: the whole scene must be ahead of the ray.
std::string fault_from_afar(const Aabb& bounds, const EmissionSample& ray) {
  if (!(ray.pdf_position > 0)) return "no pdf_position, which light from infinitely far has";
  const float size = glm::length(bounds.extent());
  for (unsigned i = 0; i < 8; ++i) {
    if (glm::dot(bounds.corner(i) - ray.o, ray.d) < -1e-3f * size) {
      return "a ray that starts within the scene, or beyond it, at " + text_of(ray.o);
    }
  }
  return "";
}

/// Tests pdf_position on a disk around the scene's centre, perpendicular to each ray. The mean of
/// 1 / (pdf_position x area) over rays that hit a part of the disk is 1, whatever their directions.
/// There are four parts at two distances from the centre.
Verdict positions_test(const EmitterScene& at, int count, uint64_t seed, double alpha,
                       double& mass) {
  const Aabb bounds = at.scene().bounds();
  const Vec3 half = 0.5f * bounds.extent();
  const float radius = std::min({half.x, half.y, half.z});
  const double part = std::numbers::pi * double{radius} * double{radius} / 8;
  Random random(seed);
  Moments parts[8], all;
  int emitted = 0;
  for (int i = 0; i < count; ++i) {
    const auto ray = random_emission(at.emitter(), random);
    size_t hit = 8;
    double value = 0;
    if (ray && ray->pdf_position > 0) {
      ++emitted;
      const Frame frame = Frame::from_normal(ray->d);
      const Vec3 local = frame.to_local(ray->o - bounds.centre());
      const float r2 = sqr(local.x) + sqr(local.y);
      if (r2 < sqr(radius)) {
        hit = static_cast<size_t>((local.x > 0) + 2 * (local.y > 0) + 4 * (2 * r2 > sqr(radius)));
        value = 1 / (double{ray->pdf_position} * part);
      }
    }
    for (size_t k = 0; k < 8; ++k) parts[k].add(k == hit ? value : 0);
    all.add(value / 8);
  }
  std::vector<Estimate> found, expected;
  for (const Moments& m : parts) {
    found.push_back({m.mean(), m.variance_of_mean()});
    // Calls that return no ray stand for directions without light.
    expected.push_back({static_cast<double>(emitted) / count, 0});
  }
  found.push_back({all.mean(), all.variance_of_mean()});
  expected.push_back(expected[0]);
  mass = all.mean() > 0 ? expected[0].mean / all.mean() : std::numeric_limits<double>::infinity();
  return largest_z_test(found, expected, alpha);
}

FaultCount wrong_origins(const EmitterScene& at, const ProbeRays& probes, uint64_t seed) {
  Random random(seed);
  FaultCount origins;
  const Aabb bounds = at.scene().bounds();
  for (const EmissionSample& ray : probes.rays) {
    if (at.is_surface()) {
      origins.add(fault_on_surface(at, ray));
    } else if (probes.is_distant) {
      origins.add(fault_from_afar(bounds, ray));
    } else if (at.emitter().is_delta()) {
      origins.add(fault_of_point_light(at, ray, random.between(0.3f, 3)));
    }
  }
  return origins;
}

Outcome emitter_origins(const Subject& subject, double alpha) {
  Outcome outcome;
  const uint64_t seed = subject.request().seed + 80;
  int checked = 0;
  for (int i = 0; i < EmitterScene::count(subject) && outcome.passed; ++i) {
    const EmitterScene at(subject, i);
    const ProbeRays probes(at, subject.samples(4000), seed);
    const FaultCount origins = wrong_origins(at, probes, seed + 1);
    checked += origins.checked;
    if (origins.is_fault()) {
      outcome.measured = fmt::format("{} of {} rays", origins.wrong, origins.checked);
      outcome.fail("sample_emission() returns " + origins.first);
      return outcome;
    }
    outcome.measured = fmt::format("{} rays start at the emitter", checked);
    if (!probes.is_distant || probes.rays.empty()) continue;
    double mass = 0;
    const Verdict verdict =
        positions_test(at, subject.samples(60000), seed + 2, alpha, mass);
    outcome.measured = fmt::format(
        "{} rays start outside the scene; pdf_position integrates to "
        "{:.4g}, p {:.2g}, bound {:.0e}",
        checked, mass, verdict.p_value, alpha);
    if (verdict.passed) continue;
    outcome.fail(std::abs(mass - 1) < 0.03
                     ? std::string("origins of rays don't follow pdf_position")
                     : fmt::format("pdf_position is {:.2g} times what it must be", mass));
  }
  if (checked == 0) outcome.measured = "no rays to check";
  return outcome;
}

/// Returns true if the emitter's surface is at this distance from p.
bool has_surface_at(const EmitterScene& at, const Vec3& p, const Vec3& d, float distance) {
  const RayHit ray = trace(at.scene(), p, d, 0.99f * distance);
  return ray.hit.valid() && ray.ray.tmax < 1.01f * distance &&
         at.scene().interaction(ray).shape == at.emitter().shape();
}

/// Checks the distances of sample_direct(), at which shadow rays end.
Outcome emitter_distance(const Subject& subject) {
  Outcome outcome;
  const uint64_t seed = subject.request().seed + 90;
  FaultCount distances;
  for (int i = 0; i < EmitterScene::count(subject); ++i) {
    const EmitterScene at(subject, i);
    const float size = glm::length(at.scene().bounds().extent());
    Random random(seed);
    for (int k = 0; k < subject.samples(2000); ++k) {
      const Vec3 p = at.random_point(random);
      const auto sample = at.emitter().sample_direct(p, random.unit2());
      if (!sample || !(sample->pdf > 0)) continue;
      const std::string distance = fmt::format("a distance of {:.5g} ", sample->distance);
      if (at.emitter().is_environment()) {
        distances.add(sample->distance > size
                          ? ""
                          : distance + "to an environment, which is infinitely far away");
      } else if (at.is_surface()) {
        distances.add(has_surface_at(at, p, sample->d, sample->distance)
                          ? ""
                          : distance + "at which there is no surface of the emitter");
      }
    }
  }
  outcome.measured = distances.checked == 0
                         ? "no distances to check"
                         : fmt::format("{} of {} distances are wrong, bound 1 of 100",
                                       distances.wrong, distances.checked);
  if (distances.is_fault()) outcome.fail("sample_direct() returns " + distances.first);
  return outcome;
}

}  // namespace

void add_origin_checks(const Subject& subject, Plan& plan) {
  const bool has_positions = !subject.make<Emitter>()->is_surface();
  plan.add("origins", has_positions ? 1 : 0,
           [&](double alpha) { return emitter_origins(subject, alpha); });
  plan.add("distance", 0, [&](double) { return emitter_distance(subject); });
}

}  // namespace kinome::check
