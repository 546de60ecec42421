// Tent: max(0, 1 - |x| / radius).
//
//   <rfilter type="tent"><float name="radius" value="1"/></rfilter>

#include "kinome/plugin.h"
#include "kinome/wide/reconstruction_filter.h"

namespace kinome {
namespace {

/// Narrower filters would miss samples at a pixel's edges. A pixel without other samples would be
/// black.
constexpr float kMinRadius = 0.51f, kMaxRadius = 64;

const Parameter kTable[] = {
    {"radius", ParameterType::kFloat, "1", "radius in pixels, from 0.51 to 64"},
};

class TentFilter final : public wide::FormulaFilter<TentFilter> {
 public:
  explicit TentFilter(const Properties& props) {
    radius_ = props.real("radius", "must be between 0.51 and 64 pixels",
                         [](float r) { return r >= kMinRadius && r <= kMaxRadius; });
  }

  template <class F>
  F weight(F x) const {
    using namespace wide::formulas;
    return max(F(0.f), 1.f - abs(x) / radius_);
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::TentFilter, kinome::Category::kReconstructionFilter, "tent",
              "Tent: decreases linearly to zero at its radius.", kinome::kTable);
