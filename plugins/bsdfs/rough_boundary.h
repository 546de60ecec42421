#pragma once

#include "kinome/wide/fresnel.h"
#include "kinome/wide/microfacet.h"

namespace kinome {

using namespace wide::formulas;

/// Microfacets of a boundary between two dielectrics, for viewers on either side: D and G of
/// reflection and refraction, and the densities of sampling them (Walter et al. 2007, "Microfacet
/// Models for Refraction through Rough Surfaces"). Callers apply the Fresnel terms, and choose
/// between reflection and refraction with probabilities of their own.
template <MicrofacetType kType, class F>
class RoughBoundary {
 public:
  using Vector = VecOf<F>;

  /// wi is in the shading frame; all values are zero if wi.z is 0. eta is the interior index
  /// divided by the exterior one. It must not be 1: without refraction, the half vector is
  /// undefined.
  RoughBoundary(const F& alpha_u, const F& alpha_v, bool sample_visible, const Vector& wi,
                float eta)
      : eta_(eta),
        is_outside_(wi.z > 0.f),
        wi_(above(wi)),
        visible_(sample_visible),
        index_(select(is_outside_, F(eta), F(1 / eta))),
        microfacet_(alpha_u, alpha_v),
        sampled_(alpha_u * sampled_scale(), alpha_v * sampled_scale()),
        viewer_g1_(microfacet_.viewer_g1(microfacet_.times_alpha2(wi_), wi_.z)),
        density_part_(microfacet_.smith_g1_exact(wi_) / wi_.z) {}

  struct Value {
    F dg;        ///< f |cos(theta_o)| of radiance, without the Fresnel term
    F pdf;       ///< per solid angle of wo, given that reflection (refraction) was chosen
    F cos_half;  ///< cosine of wi with the microfacet's normal, > 0 where dg is
    MaskOf<F> goes_through;
  };
  /// Returns zeros if no microfacet scatters light from wo to wi.
  Value operator()(const Vector& wo) const {
    const Vector out = above(wo);
    const auto goes_through = out.z < 0.f;
    const Vector sum = wi_ + select(goes_through, index_, F(1.f)) * out;
    const Vector h = select(sum.z < 0.f, -sum, sum);                        // towards wi's side
    const F length2 = dot(h, h), cos_i = dot(wi_, h), cos_o = dot(out, h);  // times |h|
    const F over_alpha2 = microfacet_.over_alpha2(h);
    const F d = microfacet_.d_along(over_alpha2, h.z) * sqr(length2);
    // Each direction must be on the same side of the microfacet as of the surface.
    const auto is_valid = wi_.z > 0.f && cos_i > 0.f && cos_o * out.z > 0.f && length2 > 1e-12f &&
                          d * h.z > 1e-20f;
    const F g = microfacet_.smith_g1(microfacet_.times_alpha2(out), abs(out.z)) * viewer_g1_;
    // Jacobian of refraction divided by the Jacobian of reflection, 1 / (4 cos_i). The squared
    // index of the Jacobian cancels in f, because radiance scales by its inverse.
    const F bent = 4.f * cos_i * abs(cos_o) / sqr(length2);
    const F dg = d * g * select(goes_through, bent, F(1.f));
    const F pdf = density(h, length2, cos_i, d) *
                  select(goes_through, sqr(index_) * bent, F(1.f));
    return {select(is_valid, dg, F(0.f)), select(is_valid, min(pdf, F(1e18f)), F(0.f)),
            select(is_valid, min(cos_i / sqrt(length2), F(1.f)), F(0.f)), goes_through};
  }

  /// Reflection and refraction at a microfacet whose normal has this cosine with wi.
  DielectricBoundary<F> boundary(const F& cosine) const {
    return dielectric_boundary(select(is_outside_, cosine, -cosine), eta_);
  }

  /// A microfacet that wi hits. Callers must reject directions on the wrong side of the surface;
  /// see is_on_side.
  struct Facet {
    Vector normal;
    F cosine;
    DielectricBoundary<F> boundary;
  };
  Facet sample(const Vec2Of<F>& u) const {
    const Vector m = visible_ ? microfacet_.sample_visible(wi_, u) : sampled_.sample_all(u);
    const F cosine = dot(wi_, m);
    return {m, cosine, boundary(cosine)};
  }
  Vector mirrored(const Facet& facet) const {
    return above(normalize(mirrored_at(wi_, facet.normal)));
  }
  Vector refracted(const Facet& facet) const {
    const F ratio = facet.boundary.eta_ti;
    return above(
        normalize((ratio * facet.cosine - facet.boundary.cos_t) * facet.normal - ratio * wi_));
  }
  /// True if wo is on the side of the surface that reflection (or refraction) must leave on.
  MaskOf<F> is_on_side(const Vector& wo, MaskOf<F> is_refracted) const {
    const F z = above(wo).z;
    return (is_refracted && z < 0.f) || (!is_refracted && z > 0.f);
  }

 private:
  /// Maps to and from coordinates in which wi is above the surface.
  Vector above(const Vector& v) const { return {v.x, v.y, select(is_outside_, v.z, -v.z)}; }

  /// Factor of alpha for sampling all normals, which keeps weights low (Walter et al. 2007, 5.3).
  F sampled_scale() const {
    return visible_ ? F(1.f) : 1.2f - 0.2f * sqrt(min(wi_.z, F(1.f)));
  }

  /// Density of the reflection at the normal along h.
  F density(const Vector& h, const F& length2, const F& cos_i, const F& d) const {
    if (visible_) return 0.25f * density_part_ * d;
    const F all = sampled_.d_along(sampled_.over_alpha2(h), h.z) * sqr(length2);
    return 0.25f * all * h.z / cos_i;
  }

  float eta_;
  MaskOf<F> is_outside_;
  Vector wi_;
  bool visible_;
  F index_;  ///< index of refraction of the other side divided by that of wi's side
  Microfacet<kType, F> microfacet_, sampled_;
  F viewer_g1_, density_part_;
};

}  // namespace kinome
