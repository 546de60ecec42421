#include "kinome/plugin.h"
#include "principled_lobes.h"
#include "rough_boundary.h"

/// Disney's principled BSDF with the lobes and parameters of Mitsuba 3: a diffuse base with sheen,
/// metal, glass, and a clear coat. base_color is the colour of the base, the metal and the glass;
/// metallic and spec_trans mix the three. The back is black if spec_trans is 0 (nest the BSDF in
/// `twosided`); otherwise it is the inside of glass.
///
///     <bsdf type="principled">
///       <rgb name="base_color" value="0.8 0.2 0.1"/>
///       <float name="metallic" value="0.3"/><float name="roughness" value="0.3"/>
///       <float name="clearcoat" value="1"/><float name="clearcoat_gloss" value="0.9"/>
///     </bsdf>
namespace kinome {
namespace {

constexpr Parameter kParameters[] = {
    KINOME_PRINCIPLED_PARAMETERS,
    {"metallic", ParameterType::kUnitlessTexture, "0", "weight of the metal, in [0,1]"},
    {"clearcoat", ParameterType::kUnitlessTexture, "0", "strength of a second, clear coat"},
    {"clearcoat_gloss", ParameterType::kUnitlessTexture, "0",
     "gloss of the clear coat, from 0 (satin) to 1 (glossy)"},
    {"eta", ParameterType::kFloat, nullptr,
     "index of refraction inside divided by the index outside"},
    {"specular", ParameterType::kFloat, "0.5",
     "alternative to eta: eta is 2 / (1 - sqrt(0.08 specular)) - 1"},
    {"diffuse_reflectance_sampling_rate", ParameterType::kFloat, "1",
     "relative sampling rate of the diffuse base"},
    {"main_specular_sampling_rate", ParameterType::kFloat, "1",
     "relative sampling rate of metal and glass"},
    {"clearcoat_sampling_rate", ParameterType::kFloat, "1",
     "relative sampling rate of the clear coat"},
};

class Principled final : public wide::FormulaBsdf<Principled> {
 public:
  static constexpr bool kSeenFromBehind = true;

  explicit Principled(const Properties& props)
      : common_(props),
        metallic_(share_texture(props, "metallic")),
        clearcoat_(nonnegative_texture(props, "clearcoat")),
        clearcoat_gloss_(share_texture(props, "clearcoat_gloss")),
        diffuse_rate_(nonnegative_number(props, "diffuse_reflectance_sampling_rate")),
        main_rate_(nonnegative_number(props, "main_specular_sampling_rate")),
        clearcoat_rate_(nonnegative_number(props, "clearcoat_sampling_rate")) {
    transmits_ = has_rough_transmission_ = common_.spec_trans->max() > 0 && metallic_->min() < 1;
    eta_ = read_eta(props, transmits_);
    if (transmits_) relative_index_ = eta_;
    lobes_ = metallic_->min() < 1 ? Lobe::kDiffuse | Lobe::kGlossy : Lobe::kGlossy;
  }

  auto inputs() const {
    return std::tuple_cat(common_.tied(), std::tie(metallic_, clearcoat_, clearcoat_gloss_));
  }
  template <class F, class Fn>
  void with_lobes(Lobe mask, const Fn& fn) const {
    fn([this, mask](const VecOf<F>& wi, const RgbOf<F>& base_color, const F& roughness,
                    const F& anisotropic, const F& spec_trans, const F& spec_tint, const F& sheen,
                    const F& sheen_tint, const F& flatness, const F& metallic, const F& clearcoat,
                    const F& clearcoat_gloss) {
      return Lobes<F>(*this, mask, wi,
                      {{base_color, roughness, anisotropic, clamped_share(spec_trans), spec_tint,
                        sheen, sheen_tint, flatness},
                       clamped_share(metallic),
                       clearcoat,
                       clamped_share(clearcoat_gloss)});
    });
  }

  Rgb albedo(const SurfaceInteraction& si) const override { return common_.base_color.at(si); }
  /// Estimates the reflectance from the cosine of si.wi.
  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    const Rgb base = common_.base_color.at(si);
    const float metallic = clamped_share(metallic_.at(si));
    const float spec_trans = clamped_share(common_.spec_trans.at(si));
    const float glass = (1 - metallic) * spec_trans;
    const float cosine = std::clamp(si.wi.z, -1.f, 1.f);
    const float mirrored = dielectric_boundary(cosine, eta_).reflectance;
    const Rgb through = glass * (1 - mirrored) * glm::sqrt(glm::max(base, Rgb(0.f)));
    const auto bounded = [](const Rgb& c) { return glm::min(c, Rgb(1.f)); };
    if (!(cosine > 0)) return {Rgb(0.f), bounded(Rgb(glass * mirrored) + through)};
    // Sheen and coat reflect little except at grazing angles.
    return {bounded((1 - metallic) * ((1 - spec_trans) * base + Rgb(0.1f * common_.sheen.at(si)))),
            bounded((1 - metallic) * Rgb(mirrored) + metallic * base + through +
                    Rgb(0.01f * clearcoat_.at(si) + 0.01f * mirrored))};
  }
  /// Glass is two-sided.
  Frame reflection_frame(const SurfaceInteraction& si) const override {
    return transmits_ ? si.frame_toward_viewer() : si.frame;
  }

 private:
  static float read_eta(const Properties& props, bool transmits) {
    float eta = 0;
    if (props.has("eta")) {
      props.exclude("specular", "eta");
      eta = props.real("eta", "must be between 0.001 and 1000",
                       [](float e) { return e >= 1e-3f && e <= 1e3f; });
    } else {
      const float specular = props.real("specular", "must be between 0 and 12",
                                        [](float s) { return s >= 0 && s <= 12; });
      eta = 2 / (1 - std::sqrt(0.08f * (transmits && specular == 0 ? 1e-3f : specular))) - 1;
    }
    // Without refraction, the half vector of transmission is undefined. Mitsuba uses 1.001, too.
    return transmits && std::abs(eta - 1) < 1e-4f ? 1.001f : eta;
  }

  template <class F>
  struct Point : principled::PointParameters<F> {
    F metallic, clearcoat, clearcoat_gloss;
  };

  template <class F>
  class Lobes {
   public:
    Lobes(const Principled& bsdf, Lobe mask, const VecOf<F>& wi, const Point<F>& at)
        : bsdf_(bsdf),
          has_glossy_(any(mask & Lobe::kGlossy)),
          has_diffuse_(any(mask & Lobe::kDiffuse)),
          wi_(wi),
          at_(at),
          is_front_(wi.z > 0.f),
          base_((1.f - at.metallic) * (1.f - at.spec_trans)),
          glass_((1.f - at.metallic) * at.spec_trans),
          boundary_(make_boundary(at, wi, bsdf.eta_)),
          coat_(principled::Gtr1<F>::of_gloss(at.clearcoat_gloss)) {
      choose_probabilities();
    }

    BsdfValueOf<F> value(const VecOf<F>& wo) const {
      BsdfValueOf<F> value{RgbOf<F>(0.f), F(0.f)};
      const auto is_reflected = is_front_ && wo.z > 0.f;
      if (has_diffuse_) add_diffuse(wo, is_reflected, value);
      if (has_glossy_) add_glossy(wo, is_reflected, value);
      return value;
    }

    BsdfSampleOf<F> sample(const F& u1, const Vec2Of<F>& u2) const {
      const auto is_diffuse = u1 < diffuse_probability_;
      const F rest = u1 - diffuse_probability_;
      const auto is_coat = !is_diffuse && rest < coat_probability_;
      VecOf<F> wo = warp::square_to_cosine_hemisphere<VecOf<F>>(u2);
      MaskOf<F> goes_through = u1 < 0.f;  // false in all lanes
      if (has_glossy_) {
        const auto facet = boundary_.sample(u2);
        goes_through = !is_diffuse && !is_coat &&
                       rest - coat_probability_ < through_probability(facet.boundary.reflectance);
        wo = select(
            is_diffuse, wo,
            select(is_coat, mirrored_at(wi_, coat_.sample(u2)),
                   select(goes_through, boundary_.refracted(facet), boundary_.mirrored(facet))));
      }
      BsdfSampleOf<F> sample =
          weighted_sample<F>(*this, wo,
                             select(is_diffuse, IntOf<F>(lobe_number(Lobe::kDiffuse)),
                                    IntOf<F>(lobe_number(Lobe::kGlossy))));
      sample.pdf = select(boundary_.is_on_side(wo, goes_through), sample.pdf, F(0.f));
      return sample;
    }

   private:
    static RoughBoundary<MicrofacetType::kGgx, F> make_boundary(const Point<F>& at,
                                                                const VecOf<F>& wi, float eta) {
      const auto [alpha_u, alpha_v] = principled::alphas(at.roughness, at.anisotropic);
      return {alpha_u, alpha_v, true, wi, eta};
    }

    /// Sets the lobes' probabilities by rough estimates of their reflectance. Only glass is visible
    /// from behind.
    void choose_probabilities() {
      F diffuse = 0.f, main = 0.f, coat = 0.f;
      if (has_diffuse_) {
        // Must not be 0 if the lobe reflects: there may be sheen without a base, or a rate of 0.
        const F min_weight = 5e-4f * (base_ + (1.f - at_.metallic) * at_.sheen);
        diffuse = select(is_front_, max(base_ * bsdf_.diffuse_rate_, min_weight));
      }
      if (has_glossy_) {
        main = select(is_front_, F(bsdf_.main_rate_), glass_);
        coat = select(is_front_, (0.25f * bsdf_.clearcoat_rate_) * at_.clearcoat);
      }
      const F sum = diffuse + main + coat;
      // If all weights are 0, a lobe may reflect nevertheless.
      const F otherwise = select(is_front_, F(1.f));
      const auto is_any = sum > 0.f;
      diffuse_probability_ = select(is_any, diffuse / sum, has_glossy_ ? F(0.f) : otherwise);
      main_probability_ = select(is_any, main / sum, has_glossy_ ? otherwise : F(0.f));
      coat_probability_ = select(is_any, coat / sum);
    }

    /// Probability that the main lobe is sampled and its microfacet, with the given reflectance,
    /// refracts. The rest of main_probability_ reflects.
    F through_probability(const F& reflectance) const {
      const F share = 1.f - reflectance;
      return main_probability_ * select(is_front_, glass_ * share, share);
    }

    void add_diffuse(const VecOf<F>& wo, const MaskOf<F>& is_reflected,
                     BsdfValueOf<F>& value) const {
      const VecOf<F> sum = wi_ + wo;
      const F cos_d = min(0.5f * sqrt(dot(sum, sum)), F(1.f));
      const F diffuse =
          base_ * principled::diffuse(at_.roughness, at_.flatness, wi_.z, wo.z, cos_d);
      const F sheen = at_.sheen * (1.f - at_.metallic);
      value.f += select(is_reflected,
                        at_.base_color * diffuse +
                            sheen * principled::sheen(at_.base_color, at_.sheen_tint, wo.z, cos_d));
      value.pdf += select(is_reflected, diffuse_probability_ * warp::cosine_hemisphere_pdf(wo.z));
    }

    void add_glossy(const VecOf<F>& wo, const MaskOf<F>& is_reflected,
                    BsdfValueOf<F>& value) const {
      const auto v = boundary_(wo);
      const auto fresnel = boundary_.boundary(v.cos_half);
      const F through = through_probability(fresnel.reflectance);
      value.f +=
          select(v.goes_through, transmittance(fresnel), reflectance(fresnel, v.cos_half)) * v.dg;
      value.pdf += select(v.goes_through, through, main_probability_ - through) * v.pdf;

      const auto has_coat = is_reflected && v.cos_half > 0.f;
      const VecOf<F> h = normalize(wi_ + wo);
      const F d = coat_.d(h.z);
      const F g = coat_g1(wi_.z) * coat_g1(wo.z);
      value.f += RgbOf<F>(
          select(has_coat, 0.25f * at_.clearcoat * wo.z * d * g *
                               principled::towards_white(0.04f, weight_of(fresnel, v.cos_half))));
      value.pdf +=
          select(has_coat, coat_probability_ * min(d * h.z / (4.f * v.cos_half), F(kMaxPdf)));
    }

    /// Schlick's weight of the cosine in the medium with the lower index.
    F weight_of(const DielectricBoundary<F>& fresnel, const F& cos_half) const {
      return principled::schlick_weight(select(fresnel.eta_ti < 1.f, cos_half, fresnel.cos_t));
    }

    RgbOf<F> reflectance(const DielectricBoundary<F>& fresnel, const F& cos_half) const {
      const F weight = weight_of(fresnel, cos_half);
      const RgbOf<F> tinted = principled::towards_white(
          principled::schlick_r0(F(bsdf_.eta_)) * principled::tint(at_.base_color), weight);
      const F dielectric = 1.f - at_.metallic;
      const RgbOf<F> front = RgbOf<F>(dielectric * (1.f - at_.spec_tint) * fresnel.reflectance) +
                             at_.metallic * principled::towards_white(at_.base_color, weight) +
                             dielectric * at_.spec_tint * tinted;
      // As in Mitsuba, metal reflects nothing where a dielectric wouldn't.
      return select(fresnel.reflectance > 0.f,
                    select(is_front_, front, RgbOf<F>(glass_ * fresnel.reflectance)));
    }

    RgbOf<F> transmittance(const DielectricBoundary<F>& fresnel) const {
      const RgbOf<F>& c = at_.base_color;
      return glass_ * (1.f - fresnel.reflectance) *
             RgbOf<F>(safe_sqrt(c.x), safe_sqrt(c.y), safe_sqrt(c.z));
    }

    /// Smith's masking of the coat: GGX with alpha 0.25 for any gloss.
    static F coat_g1(const F& cosine) {
      const F cos2 = sqr(cosine);
      return 2.f * cosine / (cosine + sqrt(cos2 + 0.0625f * max(1.f - cos2, F(0.f))));
    }

    const Principled& bsdf_;
    bool has_glossy_, has_diffuse_;
    VecOf<F> wi_;
    Point<F> at_;
    MaskOf<F> is_front_;
    F base_, glass_;  ///< weights of the diffuse base and of glass
    RoughBoundary<MicrofacetType::kGgx, F> boundary_;
    principled::Gtr1<F> coat_;
    F diffuse_probability_, main_probability_, coat_probability_;
  };

  principled::Inputs common_;
  NumberInput metallic_, clearcoat_, clearcoat_gloss_;
  float diffuse_rate_, main_rate_, clearcoat_rate_;
  float eta_ = 1;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Principled, kinome::Category::kBsdf, "principled",
              "Disney's principled BSDF: diffuse, metal, glass, sheen and a clear coat.",
              kinome::kParameters);
