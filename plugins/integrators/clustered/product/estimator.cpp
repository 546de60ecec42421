#include "clustered/product/estimator.h"

#include <algorithm>
#include <cmath>

#include "clustered/product/spread.h"

namespace kinome {
namespace {

/// Shadow rays of one call to Embree: what fits the caches.
constexpr size_t kBatch = 2048;
/// Normals of a sharp lobe's group lie within 1 - cos < kSharpSpread alpha².
constexpr float kSharpSpread = 0.5f;
constexpr size_t kMaxGroups = 64;

/// Of a cone's half angle; beyond a right angle all cells may straddle a horizon.
inline float cone_sine(float cosine) {
  return cosine > 0 ? safe_sqrt(1 - std::min(cosine * cosine, 1.f)) : 2.f;
}

}  // namespace

CellLight::CellLight(const DistantCells& distant, const Emitter* sky, CellPoints distant_points,
                     const LocalLight* local_light, LocalPoints points_of_local)
    : cells(distant),
      environment(sky),
      points(std::move(distant_points)),
      local(local_light),
      local_points(std::move(points_of_local)) {
  columns.count = cells.padded_size();
  for (int k = 0; k < 8; ++k) columns.edges[k] = cells.edges()[k].data();
  for (int k = 0; k < 3; ++k) {
    columns.axis[k] = cells.axis()[k].data();
    columns.importance_flux[k] = cells.importance_flux()[k].data();
  }
  for (int k = 0; k < 9; ++k) columns.vector_flux[k] = points.vector_flux[k].data();
  columns.radius = cells.radius().data();
  columns.flux = cells.flux().data();
}

Estimator::Estimator(const CellLight& light) : light_(light) {
  importance_.resize(light.columns.count);
  importance_blocks_.resize(light.columns.count / simd::kCellLanes);
  rays_.resize(kBatch);
  pending_.resize(kBatch);
  lit_.resize(kBatch);
}

void Estimator::begin_tile(const Scene& scene, const TilePrimaries& primaries,
                           std::vector<Patch>& patches, std::span<const Visibility> visibility,
                           uint64_t seed, RenderCounters& counters) {
  scene_ = &scene;
  primaries_ = &primaries;
  patches_ = &patches;
  visibility_ = visibility;
  counters_ = &counters;
  auto& stages = counters.stage_seconds;
  stages_ = {&stages["strata"], &stages["candidates"], &stages["comb"], &stages["shadow"],
             &stages["eye rays"]};
  if (prepared_.size() < patches.size()) prepared_.resize(patches.size());
  for (Prepared& prepared : prepared_) prepared.ready = false;
  if (!has_local() || patches.empty()) return;
  choice_.choose(*light_.local, light_.local_points, patches, visibility.first(patches.size()),
                 light_.first_local(), primaries.size(), seed);
  if (eye_rays_.empty()) eye_rates_.clear();
  tile_rates_ = eye_rates_.size();
  eye_rates_.insert(eye_rates_.end(), choice_.rates().begin(), choice_.rates().end());
}

const Estimator::Prepared& Estimator::prepare(int32_t index) {
  Prepared& prepared = prepared_[index];
  if (prepared.ready) return prepared;
  prepared.ready = true;
  prepare_patch((*patches_)[index], visibility_[index], prepared);
  return prepared;
}

void Estimator::prepare_patch(const Patch& patch, const Visibility& visibility,
                              Prepared& prepared) const {
  prepared.transmittance.clear();
  if (patch.transmittance()) find_transmittance(patch, prepared.transmittance);
  const Vec3 local = light_.cells.to_local(patch.normal);
  simd::classify_cells(
      light_.columns, &local.x, cone_sine(patch.cone_cosine), visibility.knowledge(),
      prepared.transmittance.empty() ? nullptr : prepared.transmittance.data(), prepared.cells);
}

/// Of each cell's mean direction.
void Estimator::find_transmittance(const Patch& patch, std::vector<float>& transmittance) const {
  const float* const table = patch.transmittance();
  const auto& axis = light_.cells.axis();
  transmittance.resize(light_.columns.count);
  for (size_t c = 0; c < transmittance.size(); ++c) {
    transmittance[c] =
        interpolate_transmittance(table, patch.normal.x * axis[0][c] + patch.normal.y * axis[1][c] +
                                             patch.normal.z * axis[2][c]);
  }
}

Estimator::PatchPlan Estimator::plan_patch(const Patch& patch, const Visibility& visibility) {
  PatchPlan plan;
  if (light_.columns.count == 0) return plan;
  if (!any(patch.bsdf->lobes() & Lobe::kDiffuse) || !(mean_of(patch.diffuse) > 0)) return plan;
  prepare_patch(patch, visibility, planned_);
  const simd::PatchCells& cells = planned_.cells;
  const size_t size = cells.above + cells.mixed;
  weights_.resize(size);
  block_sums_.resize(size / simd::kCellLanes);
  mixed_visibility_.resize(cells.mixed);
  plan.uncertainty =
      simd::diffuse_strata(cells, group_normal(patch.normal, std::max(patch.cone_cosine, 0.9987f)),
                           mean_of(patch.diffuse) * kInvPi, weights_.data(), block_sums_.data(),
                           mixed_visibility_.data(), plan.control);
  return plan;
}

simd::GroupNormal Estimator::group_normal(const Vec3& n, float cosine) const {
  const Vec3 local = light_.cells.to_local(n);
  return {{n.x, n.y, n.z}, {local.x, local.y, local.z}, cone_sine(cosine)};
}

void Estimator::add_to_group(uint32_t primary) {
  const int32_t patch = primaries_->patch[primary];
  const Vec3& n = primaries_->normal[primary];
  int32_t group = first_group_[patch];
  if (group >= 0 && is_sharp((*patches_)[patch])) {
    float best = -2;
    for (size_t k = 0; k < groups_.size(); ++k) {
      if (groups_[k].patch != patch) continue;
      const float cosine = glm::dot(normalized(groups_[k].normal, n), n);
      if (cosine <= best) continue;
      best = cosine;
      group = static_cast<int32_t>(k);
    }
    const bool fits = best > 1 - kSharpSpread * (*patches_)[patch].alpha2();
    if (!fits && groups_.size() < kMaxGroups) group = -1;
  }
  if (group < 0) {
    group = static_cast<int32_t>(groups_.size());
    if (first_group_[patch] < 0) first_group_[patch] = group;
    groups_.push_back({});
    groups_.back().patch = patch;
  }
  group_of_.push_back(group);
  Group& g = groups_[group];
  const Rgb& albedo = primaries_->diffuse[primary];
  ++g.count;
  g.normal += n;
  g.viewer += primaries_->interaction(primary).frame.to_world(primaries_->interaction(primary).wi);
  for (int c = 0; c < 3; ++c) g.albedo_normal[c] += albedo[c] * n;
  g.albedo += mean_of(albedo);
}

void Estimator::make_groups(const Unit& unit) {
  groups_.clear();
  group_of_.clear();
  first_group_.assign(patches_->size(), -1);
  for (uint32_t i = unit.first; i < unit.end; ++i) {
    if (primaries_->patch[i] < 0) {
      group_of_.push_back(-1);
    } else {
      add_to_group(i);
    }
  }
  uint32_t first = 0;
  for (Group& group : groups_) {
    group.first = first;
    first += group.count;
    group.count = 0;
    const Patch& patch = (*patches_)[group.patch];
    group.normal = normalized(group.normal, patch.normal);
    group.viewer = normalized(group.viewer, patch.viewer);
  }
  order_.resize(first);
  for (uint32_t i = unit.first; i < unit.end; ++i) {
    const int32_t k = group_of_[i - unit.first];
    if (k < 0) continue;
    Group& group = groups_[k];
    order_[group.first + group.count++] = i;
    group.cosine = std::min(group.cosine, glm::dot(group.normal, primaries_->normal[i]));
  }
}

void Estimator::begin_unit(const Unit& unit) {
  make_groups(unit);
  segments_.clear();
  weights_.clear();
  block_sums_.clear();
  mixed_visibility_.clear();
  candidates_.resize(0);
}

void Estimator::add_diffuse(uint32_t index, Rgb& control) {
  const Group& group = groups_[index];
  const Patch& patch = (*patches_)[group.patch];
  if (light_.columns.count == 0) return;
  if (!any(patch.bsdf->lobes() & Lobe::kDiffuse) || !(group.albedo > 0)) return;
  const StageScope timer(innermost_stage_, *stages_.strata);
  const simd::PatchCells& cells = prepare(group.patch).cells;
  const Segment segment{Strata::kDiffuse, index, weights_.size(), cells.above + cells.mixed,
                        mixed_visibility_.size()};
  if (segment.size == 0) return;
  weights_.resize(segment.begin + segment.size);
  block_sums_.resize(weights_.size() / simd::kCellLanes);
  mixed_visibility_.resize(segment.other + cells.mixed);
  float flux[9];
  simd::diffuse_strata(cells, group_normal(group.normal, group.cosine), group.albedo * kInvPi,
                       &weights_[segment.begin], &block_sums_[segment.begin / simd::kCellLanes],
                       mixed_visibility_.data() + segment.other, flux);
  for (int c = 0; c < 3; ++c) {
    control[c] += kInvPi * (group.albedo_normal[c].x * flux[c * 3] +
                            group.albedo_normal[c].y * flux[c * 3 + 1] +
                            group.albedo_normal[c].z * flux[c * 3 + 2]);
  }
  segments_.push_back(segment);
}

void Estimator::estimate(const Unit& unit, Rgb& sum) {
  if (is_probing_) flush();
  is_probing_ = false;
  begin_unit(unit);
  if (groups_.empty()) return;
  Rgb control(0.f);
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    add_diffuse(g, control);
    add_glossy(g, unit, control);
    if (has_local()) add_local(g, unit, control, {});
  }
  sum += control;
  comb_unit(unit, &sum);
  const uint64_t seed = hash_words(unit.seed, 3);
  if (has_local()) {
    for (const Group& group : groups_) send_eye_rays(group, hash_words(unit.seed, 5), &sum);
    for (const uint32_t i : order_) send_mirrored(i, seed, &sum);
    return;
  }
  for (const uint32_t i : order_) {
    const auto mirrored = mirror(i, seed);
    if (mirrored) push_ray(i, mirrored->d, mirrored->radiance, 0, &sum);
  }
}

void Estimator::probe(const Unit& unit, std::span<PointPlan> points,
                      std::span<std::vector<VisibilityRecord>> records) {
  if (!is_probing_) flush();
  is_probing_ = true;
  double* const untold = &untold_seconds_;
  stages_ = {untold, untold, untold, untold, untold};
  records_ = records.data();
  probed_ = points;
  begin_unit(unit);
  if (groups_.empty()) return;
  Rgb control(0.f);
  for (uint32_t g = 0; g < groups_.size(); ++g) {
    add_diffuse(g, control);
    probe_glossy(g, unit, points);
    if (has_local()) add_local(g, unit, control, points);
  }
  comb_unit(unit, nullptr);
  const uint64_t seed = hash_words(unit.seed, 3);
  for (const uint32_t i : order_) {
    const auto mirrored = mirror(i, seed);
    if (mirrored) points[i].mirrored = mean_of(mirrored->radiance);
  }
}

}  // namespace kinome
