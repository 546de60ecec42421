#include "clustered/product/strata/local_strata.h"

#include <algorithm>
#include <cmath>

namespace kinome {
namespace {

/// Eye rays per primary, relative to the share of light that they would find if every primary sent
/// one.
constexpr float kEyeRayFactor = 12;
/// Minimum number of eye rays per primary. It bounds the weight of a very near light point.
constexpr float kMinEyeRays = 1 / 8.f;
/// Additional eye rays per primary, relative to the share of light from points that aren't
/// Lambertian. If such a surface reflects a lamp, an eye ray may find light far brighter than any
/// that the pilot has seen.
constexpr float kLobeEyeRayFactor = 10;

}  // namespace

void LocalStrata::Columns::resize(size_t size) {
  Candidates::resize(size);
  if (point.size() >= member.size()) return;
  point.resize(member.size());
  distance.resize(member.size());
  eye_ratio.resize(member.size());
  group.resize(member.size());
}

void LocalStrata::Columns::add_lamp(uint32_t of_member, uint32_t of_cell, const Vec3& d, float far,
                                    const Rgb& light, uint32_t of_group) {
  const size_t i = size();
  resize(i + 1);
  put(i, of_cell, d, light);
  member[i] = of_member;
  point[i] = LightPoint::kLambertian;
  distance[i] = far;
  eye_ratio[i] = 0;
  group[i] = static_cast<uint8_t>(of_group);
}

/// Returns the light point of a candidate; nullptr for a lamp.
const LightPoint* LocalStrata::point_of(size_t i) const {
  const uint32_t point = candidates_.point[i];
  return point == LightPoint::kLambertian ? nullptr : &light_.local_points.points[point];
}

/// Adds candidates toward a block of the tile's light points for each member.
void LocalStrata::connect_points(const GroupView& group, uint32_t first_block) {
  Columns& c = candidates_;
  for (uint32_t j = 0; j < group.group.count; ++j) {
    const LocalChoice::Block block = choice_.block(first_block + group.primary(j));
    const size_t first = c.size();
    c.resize(first + block.size);
    if (block.size == 0) continue;
    const SurfaceInteraction si = group.place(j);
    simd::connect_points(
        block.columns, {{si.p.x, si.p.y, si.p.z}, {si.n.x, si.n.y, si.n.z}, si.p_error}, block.size,
        {&c.dx[first], &c.dy[first], &c.dz[first], &c.distance[first], &c.radiance[first].x,
         &c.eye_ratio[first]});
    for (uint32_t i = 0; i < block.size; ++i) {
      c.member[first + i] = j;
      c.cell[first + i] = light_.first_local() + block.cell[i];
      c.point[first + i] = block.point[i];
    }
    if (light_.groups) std::copy_n(block.group, block.size, &c.group[first]);
    if (!light_.local_points.reflections.empty()) add_reflections(block, first);
  }
}

/// Sets radiance and eye_ratio of candidates toward points that aren't Lambertian. The block's
/// candidates start at `first`.
void LocalStrata::add_reflections(const LocalChoice::Block& block, size_t first) {
  Columns& c = candidates_;
  for (size_t i = first; i < c.size(); ++i) {
    const uint32_t k = static_cast<uint32_t>(i - first), reflection = block.reflection[k];
    if (reflection == LightPoint::kLambertian || is_black(c.radiance[i])) continue;
    const Vec3 d = c.direction(i), geometric = block.geometric(k);
    const Reflection::Sent sent = light_.local_points.reflections[reflection].toward(-d);
    const float geometry = std::abs(glm::dot(geometric, d)) / sqr(c.distance[i]);
    c.radiance[i] = sent.radiance * (geometry * block.weight[k]);
    c.eye_ratio[i] *= 1 + sent.follow_ratio;
  }
}

/// Adds candidates toward a block of the tile's lamps for each member.
void LocalStrata::connect_lamps(const GroupView& group, const Numbers& numbers) {
  Columns& c = candidates_;
  for (uint32_t j = 0; j < group.group.count; ++j) {
    const uint32_t primary = group.primary(j);
    const uint64_t own = hash_words(numbers.lamps, primary);
    const SurfaceInteraction si = group.place(j);
    uint32_t number = 0;
    for (const LocalChoice::Lamp& lamp : choice_.lamps(numbers.block + primary)) {
      number += 2;
      const Vec2 u(random_float(own, number), random_float(own, number + 1));
      const auto light = lamp.emitter->sample_direct(si.p, u);
      if (!light || !(light->pdf > 0) || is_black(light->radiance)) continue;
      c.add_lamp(j, light_.first_local() + lamp.cell, light->d, light->distance,
                 light->radiance * (lamp.weight / light->pdf), lamp.group);
    }
  }
}

Rgb LocalStrata::add(const GroupView& group, float eye_rays, const Numbers& numbers,
                     Strata& strata) {
  Columns& c = candidates_;
  first_ = c.size();
  connect_points(group, numbers.block);
  end_points_ = c.size();
  connect_lamps(group, numbers);
  // Padding: black lamps.
  while (c.size() % simd::kLobeLanes != 0) {
    c.add_lamp(0, light_.first_local(), group.normal(0), 1, Rgb(0.f));
  }
  const size_t size = c.size() - first_;
  if (size == 0) return Rgb(0.f);
  values_.all(group, c.directions(first_), c.lobe_columns(first_));
  const Strata::Columns columns = strata.append(Strata::Kind::kLocal, group.index, size, first_);
  float control[3];
  simd::weigh_connections(
      {c.weight_columns(first_, columns.weights), &c.lobe_density[first_], &c.eye_ratio[first_]},
      {eye_rays, {group.visibility.v.data(), group.visibility.sigma.data()}}, size, control,
      columns.block_sums);
  return {control[0], control[1], control[2]};
}

void LocalStrata::split(const GroupView& group, const Rgb& control, const UnitSums& sums) const {
  const Columns& c = candidates_;
  if (!light_.groups) return split_control(group, c, first_, control, sums);
  for (size_t i = first_; i < c.size(); ++i) {
    Rgb* const row = sums.is_split ? &sums.of(group.primary(c.member[i])) : sums.first;
    row[c.group[i]] += group.visibility.v[c.cell[i]] * c.weight_of(i);
  }
}

void LocalStrata::plan(const GroupView& group, Patch& patch, std::span<PointPlan> points) const {
  const Columns& c = candidates_;
  if (c.size() == first_) return;
  double sum = 0, of_lamps = 0, of_lobes = 0, all = 0, variance = 0;
  double row_sum = 0, row_squares = 0, row = 0;
  for (size_t i = first_; i < c.size(); ++i) {
    const double w = mean_of(c.weight_of(i));
    sum += w;
    // Eye rays can't find lamps.
    if (i < end_points_) all += w * (1. + c.lobe_density[i] * c.eye_ratio[i]);
    if (i < end_points_ && point_of(i)->reflection != LightPoint::kLambertian) of_lobes += w;
    if (i >= end_points_) {
      of_lamps += w;
      points[group.primary(c.member[i])].lamps += static_cast<float>(w);
      continue;
    }
    row_sum += w;
    row_squares += w * w;
    row += 1;
    if (i + 1 == end_points_ || c.member[i + 1] != c.member[i]) {
      variance += std::max(0., row * row_squares - row_sum * row_sum);
      row_sum = row_squares = row = 0;
    }
  }
  const uint32_t members = group.group.count;
  const double count = members;
  const float share = static_cast<float>(members) / static_cast<float>(patch.count);
  const float by_lobes = sum > 0 ? static_cast<float>(of_lobes / sum) : 0.f;
  const auto mean = static_cast<float>(sum / count);
  const auto extended = static_cast<float>((sum - of_lamps) / count);
  const double spread = variance / count;
  const float by_eye = all > 0 ? static_cast<float>(1 - (sum - of_lamps) / all) : 1.f;
  patch.eye_rays += share * std::clamp(kEyeRayFactor * by_eye + kLobeEyeRayFactor * by_lobes,
                                       kMinEyeRays, 1.f);
  patch.glossy += mean * share;
  for (uint32_t j = 0; j < members; ++j) {
    PointPlan& point = points[group.primary(j)];
    point.glossy += extended;
    point.glossy_variance += spread;
  }
}

/// Number of surfaces that a shadow ray to this light point may pass straight; 0 for a lamp.
uint32_t LocalStrata::max_passes(uint32_t point) const {
  if (point == LightPoint::kLambertian) return 0;
  return passes_left(light_.local->max_depth(), 2 + light_.local_points.points[point].edges);
}

void LocalStrata::shoot(const GroupView& group, const SegmentHits& segment,
                        const Answers& answers, ShadowRays& rays) const {
  const Columns& c = candidates_;
  const bool has_bent_normals = light_.local_points.has_bent_normals;
  for (const Comb::Hit& hit : segment.hits) {
    const size_t i = segment.segment.first + hit.stratum;
    const float factor = segment.step / segment.weights[hit.stratum];
    const Rgb weight = c.weight_of(i) * factor;
    const uint32_t primary = group.primary(c.member[i]);
    Answers own = answers;
    own.sums = of_candidate(answers.sums, i);
    if (own.sums) own.sums.of(primary) -= group.visibility.v[c.cell[i]] * weight;
    const bool is_lamp = c.point[i] == LightPoint::kLambertian;
    const SurfaceInteraction si = group.primaries.place(primary);
    const Vec3 d = c.direction(i);
    ShadowRays::Lit lit;
    if (answers.points && is_lamp && !is_black(weight)) {
      PointPlan& plan = answers.points[primary];
      const float radiance = mean_of(c.weight_of(i));
      plan.lamps -= radiance;
      lit = {plan.lit, radiance};
    }
    Vec3 toward = d;
    float distance = c.distance[i];
    if (has_bent_normals && !is_lamp) {
      const Vec3 to = point_of(i)->end_of_ray(d) - si.p;
      distance = glm::length(to);
      toward = to / std::max(distance, 1e-30f);
    }
    rays.push(si, toward, distance,
              {weight, c.cell[i], group.group.patch, primary, max_passes(c.point[i])}, own, lit);
  }
}

}  // namespace kinome
