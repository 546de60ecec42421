#include "kinome/plugin.h"
#include "kinome/wide/phase.h"

/// The same radiance in all directions.
///
///     <phase type="isotropic"/>
namespace kinome {
namespace {

class Isotropic final : public wide::DeflectionPhase<Isotropic> {
 public:
  explicit Isotropic(const Properties&) {}

  template <class F>
  F value(const wide::Deflection<F>& /*at*/) const {
    return 0.25f * kInvPi;
  }
  template <class F>
  wide::Deflection<F> draw(const F& u) const {
    return {2.f * (1.f - u), 2.f * u};
  }

  std::array<HgLobe, 2> lobes() const override { return {HgLobe{0, 1}, HgLobe{0, 0}}; }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Isotropic, kinome::Category::kPhase, "isotropic",
              "Scatters light uniformly in all directions.", {});
