#include "energy.h"
#include "kinome/plugin.h"
#include "kinome/wide/near_zero.h"

/// Modified Phong reflection, normalised, after Lafortune and Willems 1994 and Mitsuba 0.6:
///
///     f = kd / pi + ks (n + 2) / (2 pi) max(0, wo . R)^n,   R = wi mirrored at the normal.
///
/// (Åkerlund 2008, eq. 3.5 omits the normalisation, a different convention.) The lobe is sampled
/// with density (n + 1) / (2 pi) (wo . R)^n; samples below the horizon are lost.
///
///     <bsdf type="phong">
///       <rgb name="diffuse_reflectance" value="0.3 0.3 0.5"/>
///       <float name="specular_reflectance" value="0.3"/>
///       <float name="exponent" value="100"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    {"exponent", ParameterType::kUnitlessTexture, "30", "exponent n of the lobe, at least 0"},
    KINOME_REFLECTANCE_PAIR_PARAMETERS,
};

class Phong final : public PairBsdf<Phong> {
 public:
  explicit Phong(const Properties& props)
      : PairBsdf(props), exponent_(nonnegative_texture(props, "exponent")) {}

  auto inputs() const {
    return std::tie(reflectances_.diffuse_input(), reflectances_.specular_input(), exponent_);
  }
  template <class F, class Fn>
  void with_lobes(Lobe mask, const Fn& fn) const {
    fn([this, mask](const VecOf<F>& wi, const RgbOf<F>& diffuse, const RgbOf<F>& specular,
                    const F& exponent) {
      return Lobes<F>(reflectances_, mask, wi, diffuse, specular, exponent);
    });
  }

 private:
  template <class F>
  class Lobes {
   public:
    Lobes(const ReflectancePair& pair, Lobe mask, const VecOf<F>& wi, const RgbOf<F>& diffuse,
          const RgbOf<F>& specular, const F& exponent)
        : has_glossy_(any(mask & Lobe::kGlossy)),
          glossy_probability_(pair.glossy_probability(mask)),
          mirrored_(mirrored(wi)),
          n_(exponent) {
      diffuse_ = any(mask & Lobe::kDiffuse) ? pair.scale() * diffuse * kInvPi : RgbOf<F>(0.f);
      glossy_ = pair.scale() * specular * ((exponent + 2.f) * 0.5f * kInvPi);
    }

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const F cosine = max(wo.z, F(0.f));
      const float diffuse_pdf = (1 - glossy_probability_) * kInvPi;
      if (!has_glossy_) return {diffuse_ * cosine, diffuse_pdf * cosine};
      // cos alpha = 1 - s. The dot product would lose digits, an error that a large n amplifies.
      const VecOf<F> difference = mirrored_ - wo;
      const F s = 0.5f * dot(difference, difference);
      F lobe = choose(wo.z > 0.f && s < 1.f, [&] { return exp(n_ * log1p(-s)); },
                      [] { return F(0.f); });
      // Smaller values are 0, because the density could round to zero before f does.
      lobe = select(lobe > 1e-20f, lobe, F(0.f));
      return {(diffuse_ + glossy_ * lobe) * cosine,
              diffuse_pdf * cosine + glossy_probability_ * (n_ + 1.f) * 0.5f * kInvPi * lobe};
    }

    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const {
      return choose(u1 < glossy_probability_, [&] { return glossy_sample(u2); },
                    [&] { return diffuse_sample<F>(*this, u2); });
    }

   private:
    BsdfSampleOf<F> glossy_sample(const Vec2Of<F>& u2) const {
      const VecOf<F> local = warp::square_to_cosine_power<VecOf<F>>(u2, n_);
      const VecOf<F> wo = normalize(FrameOf<VecOf<F>>::from_normal(mirrored_).to_world(local));
      return weighted_sample<F>(*this, wo, lobe_number(Lobe::kGlossy));
    }

    bool has_glossy_;
    float glossy_probability_;
    VecOf<F> mirrored_;
    F n_;
    RgbOf<F> diffuse_, glossy_;
  };

  NumberInput exponent_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Phong, kinome::Category::kBsdf, "phong",
              "Normalised Phong lobe over a diffuse base, as in Mitsuba 0.6.", kinome::kParameters);
