// Windowed sinc: the sharpest filter, with visible ringing at strong edges. Has negative lobes.
//
//     sinc(x) sinc(x / lobes),   sinc(x) = sin(pi x) / (pi x)
//
//   <rfilter type="lanczos"><integer name="lobes" value="3"/></rfilter>

#include <cmath>

#include "kinome/plugin.h"
#include "kinome/wide/functions.h"
#include "kinome/wide/reconstruction_filter.h"

namespace kinome {
namespace {

constexpr uint32_t kMaxLobes = 32;

const Parameter kTable[] = {
    {"lobes", ParameterType::kInteger, "3",
     "number of lobes of the sinc, from 1 to 32; also the radius in pixels"},
};

class LanczosFilter final : public wide::FormulaFilter<LanczosFilter> {
 public:
  explicit LanczosFilter(const Properties& props) {
    radius_ = static_cast<float>(props.integer("lobes", 1, kMaxLobes));
  }

  template <class F>
  F weight(F position) const {
    using namespace wide::formulas;
    // Below this, both sines equal their arguments up to rounding.
    constexpr float kMinPosition = 1e-4f;
    const F x = kPi * max(abs(position), F(kMinPosition));
    const F value = sin(x) * sin(x / radius_) * radius_ / (x * x);
    return select(abs(position) < radius_, value, F(0.f));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::LanczosFilter, kinome::Category::kReconstructionFilter, "lanczos",
              "Windowed sinc: the sharpest filter, with visible ringing.", kinome::kTable);
