// Windowed sinc: the sharpest, with visible ringing at strong edges. Partly negative.
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

constexpr uint32_t kMostLobes = 32;

const Parameter kTable[] = {
    {"lobes", ParameterType::kInteger, "3",
     "of the sinc, from 1 to 32: the filter's radius in pixels"},
};

class LanczosFilter final : public wide::FormulaFilter<LanczosFilter> {
 public:
  explicit LanczosFilter(const Properties& props) {
    radius_ = static_cast<float>(props.integer("lobes", 1, kMostLobes));
  }

  template <class F>
  F weight(F position) const {
    using namespace wide::formulas;
    // Nearer to 0, both sines lie within rounding of their arguments.
    constexpr float kNearest = 1e-4f;
    const F x = kPi * max(abs(position), F(kNearest));
    const F value = sin(x) * sin(x / radius_) * radius_ / (x * x);
    return select(abs(position) < radius_, value, F(0.f));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::LanczosFilter, kinome::Category::kReconstructionFilter, "lanczos",
              "Windowed sinc: the sharpest, with visible ringing.", kinome::kTable);
