// The part of Estimator that is about local light: candidates are light points and lamps.
#include <algorithm>
#include <cmath>

#include "clustered/product/estimator.h"

namespace kinome {
namespace {

/// Eye rays of a primary: in proportion to the share of the light that they would account for if
/// every primary sent one, within these bounds. The least of them bounds what a light point that is
/// very near can weigh.
constexpr float kEyeRayFactor = 12, kLeastEyeRays = 1 / 8.f;
/// Below this roughness, all primaries whose lobe is glossy send one.
constexpr float kSharpAlpha = 0.1f;
/// Where there is a diffuse and a glossy lobe, each gets at least this share of the eye rays.
constexpr float kLeastLobeShare = 0.2f;
/// Numbers of a unit's seed: see Estimator::estimate for the others.
enum UnitSeed : uint32_t { kFirstBlock = 6, kLampNumbers = 7 };

}  // namespace

/// Candidates toward a block of the tile's points for each member. Returns the end of them.
size_t Estimator::connect_points(const Group& group, const Unit& unit) {
  Candidates& c = candidates_;
  const uint32_t start = random_bits(unit.seed, kFirstBlock);
  for (uint32_t j = 0; j < group.count; ++j) {
    const uint32_t primary = member_of(group, j);
    const LocalChoice::Block block = choice_.block(start + primary - unit.first);
    const size_t first = c.size();
    c.resize(first + block.size);
    if (block.size == 0) continue;
    const SurfaceInteraction& si = primaries_->interaction(primary);
    simd::connect_points(
        block.columns, {{si.p.x, si.p.y, si.p.z}, {si.n.x, si.n.y, si.n.z}, si.p_error}, block.size,
        {&c.dx[first], &c.dy[first], &c.dz[first], &c.distance[first], &c.radiance[first].x,
         &c.eye_ratio[first]});
    for (uint32_t i = 0; i < block.size; ++i) {
      c.member[first + i] = j;
      c.cell[first + i] = light_.first_local() + block.cell[i];
      c.point[first + i] = block.point[i];
    }
    if (!light_.local_points.reflections.empty()) add_reflections(first);
  }
  return c.size();
}

/// Radiance / (power / rate of its cell), by which a candidate sees a light point.
float Estimator::geometry_of(const LightPoint& point, size_t i) const {
  return std::abs(glm::dot(point.geometric, candidates_.direction(i))) /
         (sqr(candidates_.distance[i]) * choice_.rates()[point.cell]);
}

/// Of candidates from `first` on, those toward points that aren't Lambertian.
void Estimator::add_reflections(size_t first) {
  Candidates& c = candidates_;
  for (size_t i = first; i < c.size(); ++i) {
    const LightPoint& point = light_.local_points.points[c.point[i]];
    if (point.reflection == LightPoint::kLambertian || is_black(c.radiance[i])) continue;
    const Reflection& reflection = light_.local_points.reflections[point.reflection];
    const Reflection::Sent sent = reflection.about(-c.direction(i));
    c.radiance[i] = sent.radiance * geometry_of(point, i);
    c.eye_ratio[i] *= 1 + sent.follow_ratio;
  }
}

/// Candidates toward the lamps that the tile looks at, padded at the end.
void Estimator::connect_lamps(const Group& group, const Unit& unit) {
  Candidates& c = candidates_;
  const uint32_t start = random_bits(unit.seed, kFirstBlock);
  const uint64_t seed = hash_words(unit.seed, kLampNumbers);
  for (uint32_t j = 0; j < group.count; ++j) {
    const uint32_t primary = member_of(group, j);
    const SurfaceInteraction& si = primaries_->interaction(primary);
    uint32_t number = 0;
    for (const LocalChoice::Lamp& lamp : choice_.lamps(start + primary - unit.first)) {
      number += 2;
      const Vec2 u(random_float(hash_words(seed, primary), number),
                   random_float(hash_words(seed, primary), number + 1));
      const auto light = lamp.emitter->sample_direct(si.p, u);
      if (!light || !(light->pdf > 0) || is_black(light->radiance)) continue;
      const size_t i = c.size();
      c.resize(i + 1);
      c.member[i] = j;
      c.cell[i] = light_.first_local() + lamp.cell;
      c.point[i] = LightPoint::kLambertian;
      c.dx[i] = light->d.x;
      c.dy[i] = light->d.y;
      c.dz[i] = light->d.z;
      c.distance[i] = light->distance;
      c.radiance[i] = light->radiance * (lamp.weight / light->pdf);
      c.eye_ratio[i] = 0;
    }
  }
  const Vec3& n = primaries_->normal[member_of(group, 0)];
  while (c.size() % simd::kLobeLanes != 0) {
    const size_t i = c.size();
    c.resize(i + 1);
    c.member[i] = 0;
    c.cell[i] = light_.first_local();
    c.point[i] = LightPoint::kLambertian;
    c.dx[i] = n.x;
    c.dy[i] = n.y;
    c.dz[i] = n.z;
    c.distance[i] = 1;
    c.radiance[i] = Rgb(0.f);
    c.eye_ratio[i] = 0;
  }
}

/// Of the eye rays, that go by the cosine rather than by the glossy lobe.
float Estimator::diffuse_share(const Patch& patch) {
  const bool is_glossy = any(patch.bsdf->lobes() & Lobe::kGlossy);
  const float diffuse = any(patch.bsdf->lobes() & Lobe::kDiffuse) ? mean_of(patch.diffuse) : 0.f;
  if (!is_glossy) return 1;
  if (!(diffuse > 0)) return 0;
  return std::clamp(diffuse / (diffuse + patch.glossy_reflectance), kLeastLobeShare,
                    1 - kLeastLobeShare);
}

/// f cos of candidates from `first` on, of all lobes but delta, and the density of eye rays, for
/// each that is sent.
void Estimator::evaluate_all_lobes(const Group& group, size_t first) {
  const Patch& patch = (*patches_)[group.patch];
  Candidates& c = candidates_;
  const size_t count = c.size() - first;
  const float share = diffuse_share(patch);
  const bool is_glossy = any(patch.bsdf->lobes() & Lobe::kGlossy);
  if (patch.is_described) {
    if (is_glossy && patch.form.glossy != BsdfForm::Glossy::kNone) {
      evaluate_candidates(group, first);
    } else {
      for (auto* const v : {&c.f[0], &c.f[1], &c.f[2], &c.lobe_density}) {
        std::fill_n(v->begin() + static_cast<ptrdiff_t>(first), count, 0.f);
      }
    }
    if (any(patch.bsdf->lobes() & Lobe::kDiffuse)) add_diffuse_values(group, first);
  } else {
    ask_for_candidates(group, Lobe::kDiffuse | Lobe::kGlossy, first);
  }
  for (size_t i = first; i < c.size(); ++i) {
    const Vec3& n = primaries_->normal[member_of(group, c.member[i])];
    const float cosine = std::max(0.f, n.x * c.dx[i] + n.y * c.dy[i] + n.z * c.dz[i]);
    c.lobe_density[i] = share * kInvPi * cosine + (1 - share) * c.lobe_density[i];
  }
}

void Estimator::add_diffuse_values(const Group& group, size_t first) {
  const Patch& patch = (*patches_)[group.patch];
  Candidates& c = candidates_;
  const float* const table = patch.form.transmittance;
  for (size_t i = first; i < c.size(); ++i) {
    const uint32_t primary = member_of(group, c.member[i]);
    const Vec3 d = c.direction(i);
    const float cosine = glm::dot(primaries_->normal[primary], d);
    if (!(cosine > 0)) continue;
    float factor = kInvPi * cosine;
    if (table) factor *= interpolate_transmittance(table, cosine);
    if (patch.form.is_turned) factor *= turned_factor(primary, d);
    for (int k = 0; k < 3; ++k) c.f[k][i] += factor * primaries_->diffuse[primary][k];
  }
}

void Estimator::add_local(uint32_t index, const Unit& unit, Rgb& control,
                          std::span<PointPlan> points) {
  const Group& group = groups_[index];
  const Patch& patch = (*patches_)[group.patch];
  if (!any(patch.bsdf->lobes() & (Lobe::kDiffuse | Lobe::kGlossy))) return;
  const StageScope timer(innermost_stage_, *stages_.candidates);
  Candidates& c = candidates_;
  const size_t first = c.size();
  const size_t end_points = connect_points(group, unit);
  connect_lamps(group, unit);
  if (c.size() == first) return;
  evaluate_all_lobes(group, first);
  const Segment segment{Strata::kLocal, index, weights_.size(), c.size() - first, first};
  weights_.resize(segment.begin + segment.size);
  block_sums_.resize(weights_.size() / simd::kCellLanes);
  const Visibility& visibility = visibility_[group.patch];
  float sums[3];
  simd::weigh_connections({c.weight_columns(first, &weights_[segment.begin]),
                           &c.lobe_density[first], &c.eye_ratio[first]},
                          {eye_rays_of(patch), {visibility.v.data(), visibility.sigma.data()}},
                          segment.size, sums, &block_sums_[segment.begin / simd::kCellLanes]);
  control += Rgb(sums[0], sums[1], sums[2]);
  segments_.push_back(segment);
  if (!points.empty()) plan_local(group, first, end_points, points);
}

/// What a pilot says of sharp lobes can't be trusted: light points hardly ever lie where these
/// look.
float Estimator::expected_eye_rays(const Patch& patch, const LocalLight& light) {
  if (light.needs_eye_rays()) return 1;
  const float sharpness = std::min(1.f, kSharpAlpha / std::sqrt(patch.alpha2()));
  return std::max(patch.eye_rays, sharpness * (1 - diffuse_share(patch)));
}

/// A pilot reckons with one for each primary, and sends none.
float Estimator::eye_rays_of(const Patch& patch) const {
  return is_probing_ ? 1 : expected_eye_rays(patch, *light_.local);
}

/// Mean and variance of the unshadowed light, and how many eye rays are called for.
void Estimator::plan_local(const Group& group, size_t first, size_t end_points,
                           std::span<PointPlan> points) {
  Candidates& c = candidates_;
  double sum = 0, of_lamps = 0, all = 0, variance = 0;
  double row_sum = 0, row_squares = 0, row = 0;
  for (size_t i = first; i < c.size(); ++i) {
    const double w = mean_of(c.weight_of(i));
    sum += w;
    all += w * (1. + c.lobe_density[i] * c.eye_ratio[i]);
    if (i >= end_points) {
      of_lamps += w;
      points[member_of(group, c.member[i])].lamps += static_cast<float>(w);
      continue;
    }
    row_sum += w;
    row_squares += w * w;
    row += 1;
    if (i + 1 == end_points || c.member[i + 1] != c.member[i]) {
      variance += std::max(0., row * row_squares - row_sum * row_sum);
      row_sum = row_squares = row = 0;
    }
  }
  Patch& patch = (*patches_)[group.patch];
  const double count = group.count;
  const float share = static_cast<float>(group.count) / static_cast<float>(patch.count);
  const auto mean = static_cast<float>(sum / count);
  const auto extended = static_cast<float>((sum - of_lamps) / count);
  const double spread = variance / count;
  const float by_eye = all > 0 ? static_cast<float>(1 - sum / all) : 1.f;
  patch.eye_rays += share * std::clamp(kEyeRayFactor * by_eye, kLeastEyeRays, 1.f);
  patch.glossy += mean * share;
  for (uint32_t j = 0; j < group.count; ++j) {
    PointPlan& point = points[order_[group.first + j]];
    point.glossy += extended;
    point.glossy_variance += spread;
  }
}

void Estimator::shoot_local(const Segment& segment, float scale, Rgb* sum) {
  const Group& group = groups_[segment.group];
  const Patch& patch = (*patches_)[group.patch];
  const Visibility& visibility = visibility_[group.patch];
  const Candidates& c = candidates_;
  const bool all_lambertian = light_.local_points.reflections.empty();
  const bool has_bent_normals = light_.local_points.has_bent_normals;
  for (const Comb::Hit& hit : hits_) {
    const size_t i = segment.other + hit.stratum;
    const float factor = scale / weights_[segment.begin + hit.stratum];
    Rgb weight = c.weight_of(i) * factor;
    if (sum) *sum -= visibility.v[c.cell[i]] * weight;
    const bool lambertian = all_lambertian || c.point[i] == LightPoint::kLambertian;
    const LightPoint* const point = lambertian ? nullptr : &light_.local_points.points[c.point[i]];
    if (point && point->reflection != LightPoint::kLambertian) {
      // Candidates know about what it sends; the ray has it exactly.
      const Reflection& reflection = light_.local_points.reflections[point->reflection];
      const Reflection::Sent sent = reflection.toward(-c.direction(i));
      float eye_ratio = c.eye_ratio[i];
      if (reflection.light_density > 0) {
        const float known = reflection.about(-c.direction(i)).follow_ratio;
        eye_ratio *= (1 + sent.follow_ratio) / (1 + known);
      }
      const float by_points = 1 / (1 + eye_rays_of(patch) * c.lobe_density[i] * eye_ratio);
      weight = Rgb(c.f[0][i], c.f[1][i], c.f[2][i]) * sent.radiance *
               (geometry_of(*point, i) * by_points * factor);
    }
    const uint32_t primary = member_of(group, c.member[i]);
    const SurfaceInteraction& si = primaries_->interaction(primary);
    const Vec3 d = c.direction(i);
    const bool is_lamp = c.point[i] == LightPoint::kLambertian;
    if (is_probing_ && is_lamp && !is_black(weight)) note_lamp(i, primary);
    const bool may_be_behind = has_bent_normals && !is_lamp;
    const Ray ray = may_be_behind
                        ? si.shadow_ray_to(light_.local_points.points[c.point[i]].end_of_ray(d))
                        : si.shadow_ray(d, c.distance[i]);
    push_shadow_ray(ray, weight, c.cell[i], group.patch, sum);
  }
}

}  // namespace kinome
