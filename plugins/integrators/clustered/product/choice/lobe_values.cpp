#include "clustered/product/choice/lobe_values.h"

#include <algorithm>

#include "transport/surfaces/shading.h"

namespace kinome {
namespace {

/// Minimum share of the rays of each lobe if the BSDF has a diffuse and a glossy lobe.
constexpr float kMinLobeShare = 0.2f;
/// Number of directions in one call of Bsdf::shade_block.
constexpr size_t kMaxDirections = 512;

}  // namespace

LobeValues::LobeValues()
    : arena_(kMaxDirections),
      points_(arena_.points()),
      wo_(arena_.three()),
      answer_(transport::make_answer(arena_)) {}

float diffuse_share(const Patch& patch) {
  const bool is_glossy = any(patch.bsdf->lobes() & Lobe::kGlossy);
  const float diffuse = any(patch.bsdf->lobes() & Lobe::kDiffuse) ? mean_of(patch.diffuse) : 0.f;
  if (!is_glossy) return 1;
  if (!(diffuse > 0)) return 0;
  return std::clamp(diffuse / (diffuse + patch.glossy_reflectance), kMinLobeShare,
                    1 - kMinLobeShare);
}

namespace {

/// Copies points number[0], number[1] ... of `from` to `to`.
void copy_points(const SurfaceBlock& from, const uint32_t* number, size_t count, SurfaceBlock& to) {
  to.count = count;
  transport::for_each_column(from, to, [&](const auto* values, auto* copies) {
    for (size_t i = 0; i < count; ++i) copies[i] = values[number[i]];
  });
}

}  // namespace

void LobeValues::ask(const GroupView& group, Lobe lobes, const Directions& to, float* const f[3]) {
  BsdfQuery query;
  query.wo = wo_;
  query.lobes = lobes;
  uint32_t number[kMaxDirections];
  for (size_t first = 0; first < to.count; first += kMaxDirections) {
    const size_t count = std::min(to.count - first, kMaxDirections);
    const uint32_t* const member = to.member + first;
    for (size_t i = 0; i < count; ++i) number[i] = group.point_ids[member[i]];
    copy_points(group.primaries.points(), number, count, points_);
    for (size_t i = 0; i < count; ++i) {
      const Vec3 d(to.dx[first + i], to.dy[first + i], to.dz[first + i]);
      wo_.set(i, group.frame(member[i]).to_local(d));
    }
    group.patch.bsdf->shade_block(points_, query, answer_);
    std::copy_n(answer_.f.x, count, f[0] + first);
    std::copy_n(answer_.f.y, count, f[1] + first);
    std::copy_n(answer_.f.z, count, f[2] + first);
  }
}

void LobeValues::evaluate_with_density(const GroupView& group, Lobe lobes, const Directions& to,
                                       const LobeColumns& out) {
  simd::lobe_density(group.patch.lobe, group.points(), to.member, to.dx, to.dy, to.dz, to.count,
                     out.density);
  ask(group, lobes, to, out.f);
}

void LobeValues::glossy(const GroupView& group, const Directions& to, const LobeColumns& out) {
  const Patch& patch = group.patch;
  if (!patch.is_described || !is_microfacet(patch.form)) {
    evaluate_with_density(group, Lobe::kGlossy, to, out);
    return;
  }
  const BsdfForm& form = patch.form;
  const TilePrimaries& primaries = group.primaries;
  simd::evaluate_microfacets(kind_of(form), microfacet_of(form),
                             patch.is_uniform ? nullptr : &primaries.microfacets(), patch.lobe,
                             group.points(), to.member, to.dx, to.dy, to.dz, to.count, out);
  if (form.has_perturbed_normal) {
    simd::multiply_turned_factors(primaries.turned(), group.points(), to.member, to.dx, to.dy, to.dz,
                                  to.count, out.f);
  }
}

void LobeValues::all(const GroupView& group, const Directions& to, const LobeColumns& out) {
  const Patch& patch = group.patch;
  const float share = diffuse_share(patch);
  if (patch.is_described) {
    if (group.has(Lobe::kGlossy) && patch.form.glossy != BsdfForm::Glossy::kNone) {
      glossy(group, to, out);
    } else {
      for (float* const v : {out.f[0], out.f[1], out.f[2], out.density}) {
        std::fill_n(v, to.count, 0.f);
      }
    }
    if (group.has(Lobe::kDiffuse)) {
      const TilePrimaries& primaries = group.primaries;
      simd::add_diffuse({primaries.diffuse_columns(), patch.form.transmittance,
                         patch.form.has_perturbed_normal ? &primaries.turned() : nullptr},
                        group.points(), to.member, to.dx, to.dy, to.dz, to.count, out.f);
    }
  } else {
    evaluate_with_density(group, Lobe::kDiffuse | Lobe::kGlossy, to, out);
  }
  simd::mix_densities(share, group.points(), to.member, to.dx, to.dy, to.dz, to.count, out.density);
}

}  // namespace kinome
