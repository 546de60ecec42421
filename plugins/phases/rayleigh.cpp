#include "kinome/plugin.h"
#include "kinome/wide/phase.h"
#include "lobes.h"

/// Scattering by particles much smaller than the wavelength, such as air: 3 / (16 pi) (1 + cos²).
///
///     <phase type="rayleigh"/>
namespace kinome {
namespace {

class Rayleigh final : public wide::DeflectionPhase<Rayleigh> {
 public:
  explicit Rayleigh(const Properties&) {}

  template <class F>
  F value(const wide::Deflection<F>& at) const {
    const F cosine = 0.5f * (at.plus - at.minus);
    return F(3 * kInvPi / 16) * (1.f + cosine * cosine);
  }
  /// Solves cos³ + 3 cos = 8 u - 4: cos = r - 1 / r with r³ = z + sqrt(z² + 1) and z = 4 u - 2. The
  /// positive solution for |z| avoids cancellation in r.
  template <class F>
  wide::Deflection<F> draw(const F& u) const {
    using namespace wide::formulas;
    using std::abs, std::copysign, std::pow, std::sqrt;
    const F z = 4.f * u - 2.f, a = abs(z);
    const F r = pow(a + sqrt(a * a + 1.f), F(1 / 3.f));
    const F cosine = copysign(r - 1.f / r, z);
    return {1.f - cosine, 1.f + cosine};
  }

  std::array<HgLobe, 2> lobes() const override { return lobes_of_moments(0, 0.1f); }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::Rayleigh, kinome::Category::kPhase, "rayleigh",
              "Scattering by particles much smaller than the wavelength.", {});
