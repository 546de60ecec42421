#include "clustered/product/lobe_values.h"

#include <algorithm>

namespace kinome {
namespace {

/// Where there is a diffuse and a glossy lobe, each gets at least this share of the rays.
constexpr float kLeastLobeShare = 0.2f;

}  // namespace

float diffuse_share(const Patch& patch) {
  const bool is_glossy = any(patch.bsdf->lobes() & Lobe::kGlossy);
  const float diffuse = any(patch.bsdf->lobes() & Lobe::kDiffuse) ? mean_of(patch.diffuse) : 0.f;
  if (!is_glossy) return 1;
  if (!(diffuse > 0)) return 0;
  return std::clamp(diffuse / (diffuse + patch.glossy_reflectance), kLeastLobeShare,
                    1 - kLeastLobeShare);
}

/// Each point's directions together: its parameters are read once.
void LobeValues::ask(const GroupView& group, Lobe lobes, const Directions& to, float* const f[3]) {
  const uint32_t members = group.group.count;
  first_.assign(members + 1, 0);
  for (size_t j = 0; j < to.count; ++j) ++first_[to.member[j] + 1];
  for (size_t k = 0; k < members; ++k) first_[k + 1] += first_[k];
  order_.resize(to.count);
  for (auto* const v : {&x_, &y_, &z_, &r_, &g_, &b_}) {
    if (v->size() < to.count) v->resize(to.count);
  }
  for (size_t j = 0; j < to.count; ++j) {
    const uint32_t at = first_[to.member[j]]++;
    order_[at] = static_cast<uint32_t>(j);
    const Vec3 d = group.frame(to.member[j]).to_local({to.dx[j], to.dy[j], to.dz[j]});
    x_[at] = d.x;
    y_[at] = d.y;
    z_[at] = d.z;
  }
  size_t begin = 0;
  for (uint32_t k = 0; k < members; ++k) {
    const size_t end = first_[k];
    if (end == begin) continue;
    const SurfaceInteraction si = group.interaction(k);
    si.shape->bsdf().eval_pdf(si, lobes, {&x_[begin], &y_[begin], &z_[begin], end - begin},
                              {&r_[begin], &g_[begin], &b_[begin], nullptr});
    begin = end;
  }
  for (size_t at = 0; at < to.count; ++at) {
    const uint32_t j = order_[at];
    f[0][j] = r_[at];
    f[1][j] = g_[at];
    f[2][j] = b_[at];
  }
}

void LobeValues::ask_with_density(const GroupView& group, Lobe lobes, const Directions& to,
                                  const LobeColumns& out) {
  simd::lobe_density(group.patch.lobe, group.points(), to.member, to.dx, to.dy, to.dz, to.count,
                     out.density);
  ask(group, lobes, to, out.f);
}

void LobeValues::glossy(const GroupView& group, const Directions& to, const LobeColumns& out) {
  const Patch& patch = group.patch;
  if (!patch.is_described || !is_microfacet(patch.form)) {
    ask_with_density(group, Lobe::kGlossy, to, out);
    return;
  }
  const BsdfForm& form = patch.form;
  const TilePrimaries& primaries = group.primaries;
  simd::evaluate_microfacets(kind_of(form), microfacet_of(form),
                             patch.is_uniform ? nullptr : &primaries.microfacets(), patch.lobe,
                             group.points(), to.member, to.dx, to.dy, to.dz, to.count,
                             {{out.f[0], out.f[1], out.f[2]}, out.density});
  if (form.is_turned) {
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
    if (group.has(Lobe::kDiffuse)) add_diffuse(group, to, out.f);
  } else {
    ask_with_density(group, Lobe::kDiffuse | Lobe::kGlossy, to, out);
  }
  for (size_t i = 0; i < to.count; ++i) {
    const Vec3& n = group.normal(to.member[i]);
    const float cosine = std::max(0.f, n.x * to.dx[i] + n.y * to.dy[i] + n.z * to.dz[i]);
    out.density[i] = share * kInvPi * cosine + (1 - share) * out.density[i];
  }
}

void LobeValues::add_diffuse(const GroupView& group, const Directions& to, float* const f[3]) {
  const BsdfForm& form = group.patch.form;
  const TilePrimaries& primaries = group.primaries;
  const float* const table = form.transmittance;
  for (size_t i = 0; i < to.count; ++i) {
    const uint32_t primary = group.primary(to.member[i]);
    const Vec3 d(to.dx[i], to.dy[i], to.dz[i]);
    const float cosine = glm::dot(primaries.normal(primary), d);
    if (!(cosine > 0)) continue;
    float factor = kInvPi * cosine;
    if (table) factor *= interpolate_transmittance(table, cosine);
    if (form.is_turned) factor *= turned_factor(primaries, primary, d);
    for (int k = 0; k < 3; ++k) f[k][i] += factor * primaries.diffuse(primary)[k];
  }
}

}  // namespace kinome
