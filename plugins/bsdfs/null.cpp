#include "batch.h"
#include "kinome/plugin.h"

/// An invisible surface: all light goes straight through, for example at the boundary of a medium.
/// As in Mitsuba's `path`, it counts as a path vertex, and blocks the light of emitters without
/// area (`point`, `directional`, …). In `volpath`, it does neither.
///
///     <bsdf type="null"/>
namespace kinome {
namespace {

class Null final : public wide::FormulaBsdf<Null> {
 public:
  static constexpr bool kSeenFromBehind = true;
  static constexpr bool kPassesStraight = true;

  explicit Null(const Properties&) {
    lobes_ = Lobe::kDelta;
    transmits_ = true;
    has_null_lobe_ = true;
    is_invisible_ = true;
  }

  template <class F>
  struct Lobes {
    VecOf<F> wi;

    BsdfValueOf<F> value(const VecOf<F>& /*wo*/) const { return {RgbOf<F>(0.f), 0.f}; }
    BsdfSampleOf<F> sample(const F& /*u1*/, const Vec2Of<F>& /*u2*/) const {
      return {-wi, 1.f, RgbOf<F>(1.f), lobe_number(Lobe::kDelta | Lobe::kNull)};
    }
    wide::NullTransmissionOf<F> null_transmission() const { return {RgbOf<F>(1.f), 1.f}; }
  };
  auto inputs() const { return std::tuple<>(); }
  template <class F, class Fn>
  void with_lobes(Lobe /*mask*/, const Fn& fn) const {
    fn([](const VecOf<F>& wi) { return Lobes<F>{wi}; });
  }

  LobeReflectance reflectance(const SurfaceInteraction&) const override { return {}; }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Null, kinome::Category::kBsdf, "null",
              "An invisible surface: light goes straight through.", {});
