// The reflector of minnaert.cpp as a wide plugin, which is faster. Its formulas are templates of a
// number type F: float for one point, and wide::Float for a vector of points.

#include <kinome/plugin.h>
#include <kinome/warp.h>
#include <kinome/wide/bsdf.h>
#include <kinome/wide/near_zero.h>

namespace {
using namespace kinome;
using namespace wide::formulas;

constexpr Parameter kParameters[] = {
    {"albedo", ParameterType::kReflectanceTexture, "0.5", "Fraction reflected at normal incidence."},
    {"k", ParameterType::kFloat, "2", "Exponent of the darkening, at least 1 (none)."},
};

class WideMinnaert final : public wide::FormulaBsdf<WideMinnaert> {
 public:
  explicit WideMinnaert(const Properties& props)
      : albedo_(props.texture("albedo")), k_(props.real("k")) {
    if (!(k_ >= 1)) throw props.error("k", "must be at least 1, got " + std::to_string(k_));
    lobes_ = Lobe::kDiffuse;
  }

  template <class F>
  struct Lobes {
    RgbOf<F> reflected;  ///< albedo toward the viewer under uniform light
    F k;

    wide::BsdfValueOf<F> value(const VecOf<F>& wo) const {
      const F pdf = (k + 1.f) * (0.5f * kInvPi) * pow(max(wo.z, F(0.f)), k);
      return {reflected * pdf, pdf};
    }
    wide::BsdfSampleOf<F> sample(const F& /*u1*/, const Vec2Of<F>& u2) const {
      const VecOf<F> wo = warp::square_to_cosine_power<VecOf<F>>(u2, k);
      return wide::weighted_sample<F>(*this, wo, wide::lobe_number(Lobe::kDiffuse));
    }
  };
  auto inputs() const { return std::tie(albedo_); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([k = k_](const VecOf<F>& wi, const RgbOf<F>& albedo) {
      return Lobes<F>{albedo * pow(wi.z, F(k - 1)), k};
    });
  }

  LobeReflectance reflectance(const SurfaceInteraction& si) const override {
    return {albedo_.at(si.uv), Rgb(0.f)};
  }

 private:
  wide::ColorInput albedo_;
  float k_;
};

}  // namespace

KINOME_PLUGIN(WideMinnaert, Category::kBsdf, "wide_minnaert",
              "Minnaert's reflector, for " KINOME_ABI_ISA, kParameters);
