#pragma once

#include "batch.h"
#include "dielectric_index.h"
#include "rough_boundary.h"
#include "roughness.h"

namespace kinome {

/// Parameters of rough dielectric boundaries.
#define KINOME_ROUGH_DIELECTRIC_PARAMETERS \
  KINOME_SMOOTH_DIELECTRIC_PARAMETERS("inside", "outside"), KINOME_MICROFACET_PARAMETERS

/// Boundary of microfacets between two dielectrics: see roughdielectric.cpp for its formulas.
class RoughDielectric : public wide::FormulaBsdf<RoughDielectric> {
 public:
  static constexpr bool kSeenFromBehind = true;

  explicit RoughDielectric(const Properties& props)
      : reflectance_(reflectance_texture(props, "specular_reflectance")),
        transmittance_(reflectance_texture(props, "specular_transmittance")),
        alpha_u_(alpha_texture(props, "alpha_u", "alpha_v")),
        alpha_v_(alpha_texture(props, "alpha_v", "alpha_u")),
        type_(static_cast<MicrofacetType>(props.choice("distribution"))),
        sample_visible_(props.boolean("sample_visible")) {
    relative_index_ = bending_ior(props);
    lobes_ = Lobe::kGlossy;
    transmits_ = has_rough_transmission_ = true;
  }

  auto inputs() const { return std::tie(reflectance_, transmittance_, alpha_u_, alpha_v_); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    with_microfacet_type(type_, [&](auto type) {
      fn([this](const VecOf<F>& wi, const RgbOf<F>& reflectance, const RgbOf<F>& transmittance,
                const F& alpha_u, const F& alpha_v) {
        return Lobes<F, decltype(type)::value>{
            {alpha_u, alpha_v, sample_visible_, wi, relative_index_}, reflectance, transmittance};
      });
    });
  }

  /// Sum of both sides, because light arrives from both.
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const float mirrored =
        dielectric_boundary(std::clamp(si.wi.z, -1.f, 1.f), relative_index_).reflectance;
    return {Rgb(0.f), mirrored * reflectance_.at(si) + (1 - mirrored) * transmittance_.at(si)};
  }
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return si.frame_toward_viewer();
  }

 private:
  template <class F, MicrofacetType kType>
  struct Lobes {
    RoughBoundary<kType, F> boundary;
    RgbOf<F> reflectance, transmittance;

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const auto v = boundary(wo);
      const F mirrored = boundary.boundary(v.cos_half).reflectance;
      const F share = select(v.goes_through, 1.f - mirrored, mirrored);
      return {select(v.goes_through, transmittance, reflectance) * (share * v.dg), share * v.pdf};
    }
    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const {
      const auto facet = boundary.sample(u2);
      const auto goes_through = !(u1 < facet.boundary.reflectance);
      const VecOf<F> wo = select(goes_through, boundary.refracted(facet), boundary.mirrored(facet));
      BsdfSampleOf<F> sample = weighted_sample<F>(*this, wo, IntOf<F>(lobe_number(Lobe::kGlossy)));
      sample.pdf = select(boundary.is_on_side(wo, goes_through), sample.pdf, F(0.f));
      return sample;
    }
  };

  ColorInput reflectance_, transmittance_;
  NumberInput alpha_u_, alpha_v_;
  MicrofacetType type_;
  bool sample_visible_;
};

}  // namespace kinome
