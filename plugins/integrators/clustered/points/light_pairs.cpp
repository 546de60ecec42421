#include "clustered/points/light_pairs.h"

#include <algorithm>

#include "kinome/wide/surface_point.h"
#include "transport/shadows/rays.h"
#include "transport/surfaces/shading.h"

namespace kinome {

using namespace wide;

namespace {

/// Returns vectors index[0], index[1] ... of an array.
KINOME_WIDE wide::Vec3 gather(const std::vector<kinome::Vec3>& from, Int index) {
  constexpr int32_t kStride = sizeof(kinome::Vec3) / sizeof(float);
  const float* const first = &from[0].x;
  const Int at = index * kStride;
  return {wide::gather(first, at), wide::gather(first + 1, at), wide::gather(first + 2, at)};
}

}  // namespace

LightPairs::LightPairs(const Scene& scene, float max_geometry_term)
    : scene_(scene),
      max_geometry_term_(max_geometry_term),
      arena_(kCapacity),
      points_(arena_),
      owner_(arena_.indices()),
      light_(arena_.indices()),
      share_(arena_.floats()),
      live_(arena_.floats()),
      d_(arena_.three()),
      distance_(arena_.floats()),
      arriving_(arena_.three()),
      wo_(arena_.three()),
      answer_(transport::make_answer(arena_)),
      rays_(arena_.rays()),
      occlusion_(kCapacity) {}

void LightPairs::add(const SurfaceBlock& points, size_t i, const Bsdf& bsdf, uint32_t owner,
                     const kinome::Rgb& weight, const LightPoints& lights,
                     const PointSelection& chosen, const Columns3& radiance,
                     RenderCounters& counters) {
  for (size_t done = 0; done < chosen.points.size();) {
    if (points_.room() == 0) finish(radiance, counters);
    const StageTimer timer(counters.stage_seconds["evaluate"]);
    const size_t count = std::min(chosen.points.size() - done, points_.room());
    const size_t first = points_.add(points, i, bsdf, count), length = padded(count);
    std::fill_n(owner_ + first, length, owner);
    std::copy_n(chosen.points.data() + done, count, light_ + first);
    std::fill(light_ + first + count, light_ + first + length, light_[first]);
    std::copy_n(chosen.weights.data() + done, count, share_ + first);
    std::fill_n(live_ + first, count, 1.f);
    std::fill(live_ + first + count, live_ + first + length, 0.f);
    see(lights, weight, first, length);
    done += count;
  }
}

void LightPairs::see(const LightPoints& lights, const kinome::Rgb& weight, size_t first,
                     size_t count) {
  if (lights.kind == LightPoints::Kind::kLocal) {
    see_local(lights, weight, first, count);
  } else {
    see_distant(lights, weight, first, count);
  }
  const SurfaceBlock& points = points_.points();
  for (size_t k = first; k < first + count; k += kLanes) {
    frame_at(points, k).to_local(wide::Vec3::load(d_, k)).store(wo_, k);
  }
}

void LightPairs::see_distant(const LightPoints& lights, const kinome::Rgb& weight, size_t first,
                             size_t count) {
  for (size_t k = first; k < first + count; k += kLanes) {
    const Int at = Int::load(light_ + k);
    gather(lights.position, at).store(d_, k);
    Float(kInfinity).store(distance_ + k);
    (gather(lights.power, at) * wide::Rgb(weight) * Float::load(share_ + k)).store(arriving_, k);
  }
}

/// Computes eq. 2.2 of the thesis without the cosine at the shading point, which is part of f cos.
void LightPairs::see_local(const LightPoints& lights, const kinome::Rgb& weight, size_t first,
                           size_t count) {
  const SurfaceBlock& points = points_.points();
  const bool all_lambertian = lights.emission_id.empty();
  const auto cosine_of = [&](size_t k, wide::Vec3 d) {
    return -dot(gather(lights.normal, Int::load(light_ + k)), d);
  };
  for (size_t k = first; k < first + count; k += kLanes) {
    const Int at = Int::load(light_ + k);
    const wide::Vec3 to = gather(lights.position, at) - wide::Vec3::load(points.p, k);
    const Float distance2 = dot(to, to);
    const Float height = abs(dot(wide::Vec3::load(points.n, k), to));
    // A light point in the plane of the surface sends nothing to it. Due to rounding, light points
    // within the error can't be distinguished from that. Division by their squared distance would
    // amplify the error.
    const Mask is_seen = height > Float::load(points.p_error + k) && distance2 > 0.f;
    const Float distance = select(is_seen, sqrt(distance2), 1.f);
    const wide::Vec3 d = select(is_seen, to / distance, wide::Vec3::load(points.sn, k));
    select(is_seen, Float::load(share_ + k)).store(share_ + k);
    d.store(d_, k);
    distance.store(distance_ + k);
    (gather(lights.power, at) * max(cosine_of(k, d), 0.f)).store(arriving_, k);
  }
  if (!all_lambertian) find_intensities(lights, first, count);
  for (size_t k = first; k < first + count; k += kLanes) {
    const wide::Vec3 d = wide::Vec3::load(d_, k);
    const Float distance = Float::load(distance_ + k);
    Float factor = Float::load(share_ + k) / (distance * distance);
    if (max_geometry_term_ > 0) {
      const Float receiving = abs(dot(wide::Vec3::load(points.sn, k), d));
      const Float term = receiving * cosine_of(k, d) / (distance * distance);
      factor = factor * select(term > max_geometry_term_, max_geometry_term_ / term, 1.f);
    }
    (wide::Rgb::load(arriving_, k) * wide::Rgb(weight) * factor).store(arriving_, k);
  }
  if (!all_lambertian) find_origins(lights, first, count);
}

/// Sets the arriving light of light points with their own emission.
void LightPairs::find_intensities(const LightPoints& lights, size_t first, size_t count) {
  for (size_t k = first; k < first + count; ++k) {
    const uint32_t i = light_[k];
    if (lights.is_lambertian(i)) continue;
    const kinome::Vec3 d = d_.at(k);
    if (!(glm::dot(lights.normal[i], d) < 0)) continue;
    arriving_.set(k, lights.emission->intensity(lights.emission_id[i], -d));
  }
}

/// Sets the directions and distances to the origins of such points' light, which may be off the
/// surface.
void LightPairs::find_origins(const LightPoints& lights, size_t first, size_t count) {
  for (size_t k = first; k < first + count; ++k) {
    const uint32_t i = light_[k];
    if (lights.is_lambertian(i) || is_black(arriving_.at(k))) continue;
    const kinome::Vec3 way = lights.origin(i, -d_.at(k)) - points_.points().p.at(k);
    const float length = glm::length(way);
    if (length > 0) distance_[k] = length, d_.set(k, way / length);
  }
}

void LightPairs::finish(const Columns3& radiance, RenderCounters& counters) {
  const SurfaceBlock& points = points_.points();
  const size_t count = points.count;
  if (count == 0) return;
  {
    const StageTimer timer(counters.stage_seconds["evaluate"]);
    points_.shade({.wo = wo_, .lobes = Lobe::kDiffuse | Lobe::kGlossy}, answer_);
    size_t live = 0, rays = 0;
    for_lanes(count, [&](size_t k) {
      const Mask is_live = Float::load(live_ + k) > 0.f;
      const wide::Rgb reflected = wide::Rgb::load(answer_.f, k) * wide::Rgb::load(arriving_, k);
      const Mask on = is_live && !is_black(reflected);
      live += wide::count(is_live);
      rays += wide::count(on);
      reflected.store(arriving_, k);
      transport::write_shadow_rays(points, k, wide::Vec3::load(d_, k), Float::load(distance_ + k),
                                   on, true, rays_);
    });
    counters[RayKind::kShadow] += rays;
    counters.skipped_shadow_rays += live - rays;
  }
  const StageTimer timer(counters.stage_seconds["shadow"]);
  occlusion_.trace(scene_, rays_, count, counters);
  for (size_t k = 0; k < count; ++k) {
    // Inactive and occluded rays have a negative tmax.
    if (!(rays_[k / kBlockLanes].tmax[k % kBlockLanes] >= 0)) continue;
    radiance.set(owner_[k], radiance.at(owner_[k]) + arriving_.at(k));
  }
  points_.clear();
}

}  // namespace kinome
