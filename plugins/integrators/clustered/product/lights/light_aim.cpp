#include "clustered/product/lights/light_aim.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/tiles/spread.h"
#include "kinome/scene.h"
#include "kinome/warp.h"

namespace kinome {
namespace {

/// Fractions of the weight that the spheres enclose.
constexpr std::array<double, kMaxAimSpheres> kEnclosed = {0.5, 0.8, 0.95, 0.995};
/// A sphere is used if its radius is below this ratio of that of the next larger one.
constexpr float kMaxRadiusRatio = 0.6f;
/// Factor of the radii of spheres, so that rounding doesn't exclude positions.
constexpr float kRadiusMargin = 1.001f;
/// Minimum distance from a sphere's centre at which cones are used, in radii.
constexpr float kMinDistance = 1.25f;
/// Maximum density of a disk relative to that of the emitter's own disk: 1 / 3000 of its radius.
/// Rays start about as far away as the own disk is large, and would miss smaller spheres because of
/// rounding.
constexpr float kMaxGainOfDisk = 1e7f;
constexpr uint32_t kRaysOfPlace = 2;
enum ProbeNumber : uint32_t { kProbeLobe, kProbeDirection, kNumbersOfRay = kProbeDirection + 2 };

/// Returns the smallest value up to which the values have the given share of the weight. Each pair
/// is (value, weight).
double quantile(std::vector<std::pair<double, double>>& values, double share) {
  std::sort(values.begin(), values.end());
  double all = 0, sum = 0;
  for (const auto& value : values) all += value.second;
  for (const auto& value : values) {
    sum += value.second;
    if (sum >= share * all) return value.first;
  }
  return values.back().first;
}

/// Sends rays from all points, sampled by their BSDFs. Returns the points that they hit.
std::vector<EyePoint> next_points(const Scene& scene, std::span<const EyePoint> points,
                                  uint32_t rays_of_each, RenderCounters& counters) {
  std::vector<EyePoint> next;
  std::vector<RayHit> rays;
  for (const EyePoint& point : points) {
    for (uint32_t k = 0; k < rays_of_each; ++k) {
      const uint32_t first = k * kNumbersOfRay;
      const auto sample = point.si.shape->bsdf().sample(
          point.si, Lobe::kAll, random_float(point.seed, first + kProbeLobe),
          {random_float(point.seed, first + kProbeDirection),
           random_float(point.seed, first + kProbeDirection + 1)});
      if (!sample) continue;
      const float weight = point.weight * mean_of(glm::abs(sample->weight));
      if (!(weight > 0) || !std::isfinite(weight)) continue;
      rays.push_back({point.si.spawn_ray(point.si.frame.to_world(sample->wo)), Hit{}});
      next.push_back({point.si, weight, hash_words(point.seed, k)});
    }
  }
  scene.intersect(rays, Coherence::kIncoherent, counters);
  counters[RayKind::kBsdf] += rays.size();
  size_t count = 0;
  for (size_t i = 0; i < rays.size(); ++i) {
    if (!rays[i].hit.valid()) continue;
    next[count] = next[i];
    next[count++].si = scene.interaction(rays[i]);
  }
  next.resize(count);
  return next;
}

}  // namespace

std::vector<AimSphere> aim_spheres(std::vector<WeightedPosition> positions) {
  std::erase_if(positions, [](const WeightedPosition& p) {
    return !(p.weight > 0) || !std::isfinite(p.position.x + p.position.y + p.position.z);
  });
  if (positions.empty()) return {};
  std::vector<std::pair<double, double>> values(positions.size());
  const auto quantile_of = [&](const auto& value, double share) {
    for (size_t i = 0; i < positions.size(); ++i) {
      values[i] = {static_cast<double>(value(positions[i].position)),
                   static_cast<double>(positions[i].weight)};
    }
    return static_cast<float>(quantile(values, share));
  };
  Vec3 centre;
  for (int axis = 0; axis < 3; ++axis) {
    centre[axis] = quantile_of([&](const Vec3& p) { return p[axis]; }, 0.5);
  }
  std::vector<AimSphere> spheres;
  for (size_t k = kEnclosed.size(); k-- > 0;) {
    const float radius =
        kRadiusMargin *
        quantile_of([&](const Vec3& p) { return glm::length(p - centre); }, kEnclosed[k]);
    if (!(radius > 0)) break;
    if (spheres.empty() || radius < kMaxRadiusRatio * spheres.back().radius) {
      spheres.push_back({centre, radius});
    }
  }
  std::reverse(spheres.begin(), spheres.end());
  return spheres;
}

std::vector<EyePoint> points_around(const Scene& scene, std::span<const SurfaceInteraction> seen,
                                    size_t first, uint64_t seed, RenderCounters& counters) {
  std::vector<EyePoint> points(seen.size()), all;
  for (size_t i = 0; i < seen.size(); ++i) points[i] = {seen[i], 1, hash_words(seed, first + i)};
  for (const uint32_t rays_of_each : {kRaysOfPlace, 1u}) {
    points = next_points(scene, points, rays_of_each, counters);
    all.insert(all.end(), points.begin(), points.end());
  }
  return all;
}

int pick_aim(int count, float& u) {
  if (count == 0) return -1;
  if (u >= kAimedShare) {
    u = std::min((u - kAimedShare) / (1 - kAimedShare), kOneMinusEpsilon);
    return -1;
  }
  const float scaled = u / kAimedShare * static_cast<float>(count);
  const int picked = std::min(static_cast<int>(scaled), count - 1);
  u = std::clamp(scaled - static_cast<float>(picked), 0.f, kOneMinusEpsilon);
  return picked;
}

bool AimCones::make_cone(const Vec3& from, const AimSphere& sphere, Cone& cone) {
  const Vec3 to = sphere.centre - from;
  cone.distance = glm::length(to);
  if (!(cone.distance > kMinDistance * sphere.radius) || !std::isfinite(cone.distance)) {
    return false;
  }
  cone.axis = to / cone.distance;
  cone.sine = sphere.radius / cone.distance;
  cone.height = sqr(cone.sine) / (1 + std::sqrt(1 - sqr(cone.sine)));
  cone.density = 1 / (2 * kPi * cone.height);
  return std::isfinite(cone.density);
}

Vec3 AimCones::sample(int cone, const Vec2& u) const {
  const Cone& c = cones_[static_cast<size_t>(cone)];
  const Vec2 disk = square_to_disk_concentric(u);
  const float height = c.height * glm::dot(disk, disk);
  const Vec2 across = disk * std::sqrt(c.height * (2 - height));
  return glm::normalize(Frame::from_normal(c.axis).to_world({across.x, across.y, 1 - height}));
}

float AimCones::pdf(const Vec3& d, float plain, int drawn) const {
  if (count_ == 0) return plain;
  float sum = 0;
  for (int k = 0; k < count_; ++k) {
    const Cone& cone = cones_[static_cast<size_t>(k)];
    const Vec3 off = d - cone.axis;  // length² = 2 (1 - cosine), precise for thin cones
    if (k == drawn || glm::dot(off, off) < 2 * cone.height) sum += cone.density;
  }
  return (1 - kAimedShare) * plain + kAimedShare * sum / static_cast<float>(count_);
}

AimDisks::AimDisks(std::span<const AimSphere> spheres, float plain) : plain_(plain) {
  for (const AimSphere& sphere : spheres) {
    const float density = 1 / (kPi * sqr(sphere.radius));
    if (density > AimCones::kMinGain * plain && density < kMaxGainOfDisk * plain) {
      spheres_[static_cast<size_t>(count_++)] = sphere;
    }
  }
}

Vec3 AimDisks::sample(int disk, const Vec2& u, const Vec3& d, const Vec3& plane) const {
  const AimSphere& sphere = spheres_[static_cast<size_t>(disk)];
  const Vec2 at = sphere.radius * square_to_disk_concentric(u);
  const Frame frame = Frame::from_normal(d);
  const Vec3 p = sphere.centre + frame.s * at.x + frame.t * at.y;
  return p + d * glm::dot(plane - p, d);
}

float AimDisks::pdf(const Vec3& p, const Vec3& d, int drawn) const {
  if (count_ == 0) return plain_;
  float sum = 0;
  for (int k = 0; k < count_; ++k) {
    const AimSphere& sphere = spheres_[static_cast<size_t>(k)];
    const Vec3 to = p - sphere.centre;
    const Vec3 off = to - d * glm::dot(to, d);
    if (k == drawn || glm::dot(off, off) < sqr(sphere.radius))
      sum += 1 / (kPi * sqr(sphere.radius));
  }
  return (1 - kAimedShare) * plain_ + kAimedShare * sum / static_cast<float>(count_);
}

}  // namespace kinome
