#include "kinome/plugin.h"
#include "principled_lobes.h"

/// Disney's principled BSDF for thin sheets such as leaves, paper and panes, with the lobes and
/// parameters of Mitsuba 3. Transmission doesn't refract: it is diffuse, or a microfacet reflection
/// that is mirrored to the other side. Both sides are the same.
///
///     <bsdf type="principledthin">
///       <rgb name="base_color" value="0.2 0.5 0.1"/>
///       <float name="diff_trans" value="0.8"/><float name="roughness" value="0.4"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    KINOME_PRINCIPLED_PARAMETERS,
    {"diff_trans", ParameterType::kUnitlessTexture, "0",
     "from 0 (all diffuse light is reflected) to 2 (all is transmitted)"},
    {"eta", ParameterType::kUnitlessTexture, "1.5",
     "index of refraction inside divided by the index outside"},
    {"diffuse_reflectance_sampling_rate", ParameterType::kFloat, "1",
     "relative sampling rate of diffuse reflection"},
    {"diffuse_transmittance_sampling_rate", ParameterType::kFloat, "1",
     "relative sampling rate of diffuse transmission"},
    {"specular_reflectance_sampling_rate", ParameterType::kFloat, "1",
     "relative sampling rate of glossy reflection"},
    {"specular_transmittance_sampling_rate", ParameterType::kFloat, "1",
     "relative sampling rate of glossy transmission"},
};

class PrincipledThin final : public wide::FormulaBsdf<PrincipledThin> {
 public:
  static constexpr bool kSeenFromBehind = true;

  explicit PrincipledThin(const Properties& props)
      : common_(props),
        diff_trans_(share_texture(props, "diff_trans", 2)),
        eta_(eta_texture(props)),
        diffuse_rates_{nonnegative_number(props, "diffuse_reflectance_sampling_rate"),
                       nonnegative_number(props, "diffuse_transmittance_sampling_rate")},
        glossy_rates_{nonnegative_number(props, "specular_reflectance_sampling_rate"),
                      nonnegative_number(props, "specular_transmittance_sampling_rate")} {
    const bool is_glossy = common_.spec_trans->max() > 0;
    transmits_ = has_rough_transmission_ = is_glossy || diff_trans_->max() > 0;
    lobes_ = (is_glossy ? Lobe::kGlossy : Lobe::kNone) |
             (common_.spec_trans->min() < 1 ? Lobe::kDiffuse : Lobe::kNone);
  }

  auto inputs() const { return std::tuple_cat(common_.tied(), std::tie(diff_trans_, eta_)); }
  template <class F, class Fn>
  void with_lobes(Lobe mask, const Fn& fn) const {
    fn([this, mask](const VecOf<F>& wi, const RgbOf<F>& base_color, const F& roughness,
                    const F& anisotropic, const F& spec_trans, const F& spec_tint, const F& sheen,
                    const F& sheen_tint, const F& flatness, const F& diff_trans, const F& eta) {
      return Lobes<F>(*this, mask, wi,
                      {{base_color, roughness, anisotropic, clamped_share(spec_trans), spec_tint,
                        sheen, sheen_tint, flatness},
                       clamped_share(0.5f * diff_trans),
                       eta});
    });
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return common_.base_color.at(si); }
  /// Sum of both sides, because light arrives from both.
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const Rgb base = common_.base_color.at(si);
    const float glossy = clamped_share(common_.spec_trans.at(si));
    const float mirrored = fresnel_dielectric(std::min(std::abs(si.wi.z), 1.f), eta_.at(si));
    const auto bounded = [](const Rgb& c) { return glm::min(c, Rgb(1.f)); };
    // Sheen reflects little except at grazing angles.
    return {bounded((1 - glossy) * (base + Rgb(0.1f * common_.sheen.at(si)))),
            bounded(glossy * (Rgb(mirrored + 1e-3f) + (1 - mirrored) * base))};
  }
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return si.frame_toward_viewer();
  }

 private:
  /// Sampling rates of reflection and transmission.
  struct Rates {
    float reflected, through;
  };

  static std::shared_ptr<Texture> eta_texture(const Properties& props) {
    auto eta = props.texture("eta");
    if (!(eta->min() >= 1e-3f && eta->max() <= 1e3f)) {
      throw props.error("eta", "must be between 0.001 and 1000, got " +
                                   format_number(eta->min() >= 1e-3f ? eta->max() : eta->min()));
    }
    return eta;
  }

  template <class F>
  struct Point : principled::PointParameters<F> {
    F diff_trans, eta;
  };

  template <class F>
  class Lobes {
   public:
    Lobes(const PrincipledThin& bsdf, Lobe mask, const VecOf<F>& wi, const Point<F>& at)
        : bsdf_(bsdf),
          has_glossy_(any(mask & Lobe::kGlossy)),
          has_diffuse_(any(mask & Lobe::kDiffuse)),
          at_(at),
          is_front_(wi.z > 0.f),
          wi_(above(wi)),
          mirror_(microfacets(at, at.roughness, wi_)),
          // Thin glass scatters less the lower its index (Burley 2015, figure 15).
          through_(microfacets(at, (0.65f * at.eta - 0.35f) * at.roughness, wi_)) {
      choose_probabilities();
    }

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const VecOf<F> out = above(wo);
      const auto goes_through = out.z < 0.f;
      const VecOf<F> on_this_side(out.x, out.y, abs(out.z));
      BsdfValueOf<F> value{RgbOf<F>(0.f), F(0.f)};
      if (has_diffuse_) add_diffuse(on_this_side, goes_through, value);
      if (has_glossy_) add_glossy(out, on_this_side, goes_through, value);
      return value;
    }

    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const {
      // In the order: glossy reflection and transmission, diffuse reflection and transmission.
      const auto is_mirrored = u1 < mirror_probability_;
      F rest = u1 - mirror_probability_;
      const auto is_glossy = is_mirrored || rest < through_probability_;
      rest -= through_probability_;
      const auto goes_through =
          (is_glossy && !is_mirrored) || (!is_glossy && !(rest < diffuse_probability_));
      VecOf<F> wo = warp::square_to_cosine_hemisphere<VecOf<F>>(u2);
      if (has_glossy_) {
        wo = select(is_mirrored, mirror_.sample(u2), select(is_glossy, through_.sample(u2), wo));
      }
      const VecOf<F> on_this_side = wo;
      wo.z = select(goes_through, -wo.z, wo.z);
      // Reflections below the horizon are invalid, also after mirroring to the other side.
      const auto is_valid = on_this_side.z > 0.f &&
                            (!(is_glossy && goes_through) || leaves_microfacet(wo, on_this_side));
      BsdfSampleOf<F> sample =
          weighted_sample<F>(*this, above(wo),
                             select(is_glossy, IntOf<F>(lobe_number(Lobe::kGlossy)),
                                    IntOf<F>(lobe_number(Lobe::kDiffuse))));
      sample.pdf = select(is_valid, sample.pdf, F(0.f));
      return sample;
    }

   private:
    using Reflection = RoughReflection<MicrofacetType::kGgx, F>;
    static Reflection microfacets(const Point<F>& at, const F& roughness, const VecOf<F>& wi) {
      const auto [alpha_u, alpha_v] = principled::alphas(roughness, at.anisotropic);
      return {alpha_u, alpha_v, true, wi};
    }

    /// Maps to and from coordinates in which wi is above the surface, by negation as in Mitsuba.
    VecOf<F> above(const VecOf<F>& v) const { return select(is_front_, v, -v); }

    void choose_probabilities() {
      F mirror = 0.f, through = 0.f, diffuse = 0.f, diffuse_through = 0.f;
      if (has_glossy_) {
        mirror = 0.5f * bsdf_.glossy_rates_.reflected * at_.spec_trans;
        through = 0.5f * bsdf_.glossy_rates_.through * at_.spec_trans;
      }
      if (has_diffuse_) {
        const F share = 1.f - at_.spec_trans;
        diffuse = bsdf_.diffuse_rates_.reflected * share * (1.f - at_.diff_trans);
        diffuse_through = bsdf_.diffuse_rates_.through * share * at_.diff_trans;
      }
      const F sum = mirror + through + diffuse + diffuse_through;
      const F inverse = select(sum > 0.f, 1.f / sum, F(0.f));
      mirror_probability_ = mirror * inverse;
      through_probability_ = through * inverse;
      diffuse_probability_ = diffuse * inverse;
      diffuse_through_probability_ = diffuse_through * inverse;
    }

    void add_diffuse(const VecOf<F>& out, const MaskOf<F>& goes_through,
                     BsdfValueOf<F>& value) const {
      const VecOf<F> sum = wi_ + out;
      const F cos_d = min(0.5f * sqrt(dot(sum, sum)), F(1.f));
      const F pdf = warp::cosine_hemisphere_pdf(out.z);
      const RgbOf<F> reflected =
          principled::diffuse(at_.roughness, at_.flatness, wi_.z, out.z, cos_d) * at_.base_color +
          at_.sheen * principled::sheen(at_.base_color, at_.sheen_tint, out.z, cos_d);
      value.f +=
          (1.f - at_.spec_trans) * select(goes_through, (at_.diff_trans * pdf) * at_.base_color,
                                          (1.f - at_.diff_trans) * reflected);
      value.pdf += pdf * select(goes_through, diffuse_through_probability_, diffuse_probability_);
    }

    void add_glossy(const VecOf<F>& out, const VecOf<F>& on_this_side,
                    const MaskOf<F>& goes_through, BsdfValueOf<F>& value) const {
      const auto mirrored = mirror_(on_this_side), through = through_(on_this_side);
      const auto is_through = goes_through && leaves_microfacet(out, on_this_side);
      const F fresnel = fresnel_dielectric(mirrored.cos_half, at_.eta);
      value.f +=
          at_.spec_trans *
          select(goes_through, select(is_through, ((1.f - fresnel) * through.dg) * at_.base_color),
                 mirrored.dg * reflectance(fresnel, mirrored.cos_half));
      value.pdf += select(goes_through, select(is_through, through_probability_ * through.pdf),
                          mirror_probability_ * mirrored.pdf);
    }

    /// Transmitted light must leave on the other side of the microfacet, too.
    MaskOf<F> leaves_microfacet(const VecOf<F>& out, const VecOf<F>& on_this_side) const {
      return dot(out, wi_ + on_this_side) < 0.f;
    }

    RgbOf<F> reflectance(const F& fresnel, const F& cos_half) const {
      const F sin2_t = (1.f - sqr(cos_half)) / sqr(at_.eta);
      const F cosine = select(at_.eta > 1.f, cos_half, safe_sqrt(1.f - sin2_t));
      const RgbOf<F> tinted = principled::towards_white(
          principled::schlick_r0(at_.eta) * principled::tint(at_.base_color),
          principled::schlick_weight(cosine));
      return RgbOf<F>(fresnel * (1.f - at_.spec_tint)) + at_.spec_tint * tinted;
    }

    const PrincipledThin& bsdf_;
    bool has_glossy_, has_diffuse_;
    Point<F> at_;
    MaskOf<F> is_front_;
    VecOf<F> wi_;
    Reflection mirror_, through_;
    F mirror_probability_, through_probability_, diffuse_probability_, diffuse_through_probability_;
  };

  principled::Inputs common_;
  NumberInput diff_trans_, eta_;
  Rates diffuse_rates_, glossy_rates_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::PrincipledThin, kinome::Category::kBsdf, "principledthin",
              "Disney's principled BSDF for thin sheets, which transmit light without refraction.",
              kinome::kParameters);
