#include "clustered/product/strata/diffuse_strata.h"

#include <algorithm>
#include <iterator>

namespace kinome {
namespace {

/// Distance of prefetching, in rays. Points of cells and surface points don't all fit into the
/// nearest cache.
constexpr size_t kRayPrefetchDistance = 8;

}  // namespace

bool DiffuseStrata::applies(const GroupView& group) const {
  return light_.has_distant() && group.has(Lobe::kDiffuse) && group.group.albedo > 0;
}

Rgb DiffuseStrata::add(const GroupView& view, Strata& strata) {
  const Group& group = view.group;
  const simd::PatchCells& cells = prepared_.get(group.patch, view.patch, view.visibility).cells;
  Rgb control(0.f);
  std::fill(std::begin(flux_), std::end(flux_), 0.f);
  std::fill(std::begin(straddling_), std::end(straddling_), 0.f);
  if (cells.above + cells.mixed == 0) return control;
  const size_t first = mixed_visibility_.size();
  mixed_visibility_.resize(first + cells.mixed);
  const Strata::Columns columns =
      strata.append(Strata::Kind::kDiffuse, view.index, cells.above + cells.mixed, first);
  simd::diffuse_strata(cells, group_normal(light_.cells, group.normal, group.cosine),
                       group.albedo * kInvPi, columns.weights, columns.block_sums,
                       mixed_visibility_.data() + first, flux_, straddling_);
  for (int c = 0; c < 3; ++c) {
    control[c] = kInvPi * (group.albedo_normal[c].x * flux_[c * 3] +
                           group.albedo_normal[c].y * flux_[c * 3 + 1] +
                           group.albedo_normal[c].z * flux_[c * 3 + 2] +
                           group.reflectance[c] * straddling_[c]);
  }
  return control;
}

void DiffuseStrata::split(const GroupView& view, const UnitSums& sums) const {
  for (uint32_t j = 0; j < view.group.count; ++j) {
    const uint32_t primary = view.primary(j);
    const Vec3 normal = view.primaries.normal(primary);
    Rgb flux;
    for (int c = 0; c < 3; ++c) {
      const Vec3 of_channel(flux_[c * 3], flux_[c * 3 + 1], flux_[c * 3 + 2]);
      flux[c] = glm::dot(normal, of_channel) + straddling_[c];
    }
    sums.of(primary) += kInvPi * view.primaries.diffuse(primary) * flux;
  }
}

void DiffuseStrata::shoot(const GroupView& view, const SegmentHits& segment, uint32_t turn,
                          const Answers& answers, ShadowRays& rays) {
  const Group& group = view.group;
  const Patch& patch = view.patch;
  const TilePrimaries& primaries = view.primaries;
  const PreparedPatch& prepared = prepared_.get(group.patch, patch, view.visibility);
  const std::span<const Comb::Hit> hits = segment.hits;
  const float* const table = patch.form.transmittance;
  const auto count = static_cast<float>(group.count);
  const uint32_t* const ids = prepared.cells.ids();
  const auto point_of = [&](size_t j) -> const CellPoint& {
    return light_.points.pick(ids[hits[j].stratum], hits[j].remainder);
  };
  const auto member_at = [&](size_t j) {
    return view.pick(turn + static_cast<uint32_t>(segment.before + j) * kPlastic);
  };
  shots_.resize(0);
  for (size_t j = 0; j < hits.size(); ++j) {
    if (j + kRayPrefetchDistance < hits.size()) {
      __builtin_prefetch(&point_of(j + kRayPrefetchDistance));
      primaries.prefetch(view.primary(member_at(j + kRayPrefetchDistance)));
    }
    const uint32_t stratum = hits[j].stratum;
    const uint32_t cell = ids[stratum];
    const CellPoint& point = point_of(j);
    const uint32_t member = member_at(j);
    const uint32_t primary = view.primary(member);
    const float factor = count * segment.step / segment.weights[stratum];
    float v = view.visibility.v[cell];
    if (!prepared.transmittance.empty()) v *= prepared.transmittance[cell];
    if (stratum >= prepared.cells.above) {
      v = mixed_visibility_[segment.segment.first + stratum - prepared.cells.above];
    }
    const float cosine = glm::dot(primaries.normal(primary), point.d);
    const Rgb light = primaries.diffuse(primary) * (kInvPi * factor) * point.weight;
    const Rgb lambert = cosine * light;
    if (answers.sums) {
      // Control terms of cells at the horizon (v < 0) use the patch's normal.
      answers.sums.of(primary) -= v < 0 ? -v * std::max(glm::dot(patch.normal, point.d), 0.f) * light
                            : v * lambert;
    }
    if (patch.is_described) {
      float t = table ? wide::tabulated(table, cosine) : 1.f;
      if (patch.form.has_perturbed_normal)
        t *= perturbed_normal_factor_at(primaries, primary, point.d);
      if (cosine > 0) {
        rays.push(primaries.place(primary), point.d, {lambert * t, cell, group.patch, primary},
                  answers);
      }
    } else {
      const size_t shot = shots_.size();
      shots_.resize(shot + 1);
      shots_.member[shot] = member;
      shots_.put(shot, cell, point.d, point.weight * factor);
    }
  }
  if (!patch.is_described) evaluate_and_shoot(view, answers, rays);
}

void DiffuseStrata::evaluate_and_shoot(const GroupView& view, const Answers& answers,
                                       ShadowRays& rays) {
  Candidates& s = shots_;
  if (s.size() == 0) return;
  values_.ask(view, Lobe::kDiffuse, s.directions(0), s.lobe_columns(0).f);
  for (size_t j = 0; j < s.size(); ++j) {
    rays.push(view.place(s.member[j]), s.direction(j),
              {s.radiance[j] * s.f_of(j), s.cell[j], view.group.patch, view.primary(s.member[j])},
              answers);
  }
}

DiffuseStrata::PatchPlan DiffuseStrata::plan(const Patch& patch, const Visibility& visibility) {
  PatchPlan plan;
  if (!light_.has_distant()) return plan;
  if (!any(patch.bsdf->lobes() & Lobe::kDiffuse) || !(mean_of(patch.diffuse) > 0)) return plan;
  prepare_patch(light_, patch, visibility, planned_, 0);
  const simd::PatchCells& cells = planned_.cells;
  mixed_visibility_.resize(cells.mixed);
  planned_strata_.clear();
  const Strata::Columns columns =
      planned_strata_.append(Strata::Kind::kDiffuse, 0, cells.above + cells.mixed, 0);
  float straddling[3];
  const simd::GroupNormal normal =
      group_normal(light_.cells, patch.normal, std::max(patch.cone_cosine, 0.9987f));
  plan.uncertainty =
      simd::diffuse_strata(cells, normal, mean_of(patch.diffuse) * kInvPi, columns.weights,
                           columns.block_sums, mixed_visibility_.data(), plan.control, straddling);
  // Converted to a vector flux, because forecasts multiply it by normals near the patch's.
  for (int k = 0; k < 9; ++k) plan.control[k] += straddling[k / 3] * patch.normal[k % 3];
  return plan;
}

}  // namespace kinome
