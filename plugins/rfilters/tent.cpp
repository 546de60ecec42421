// Tent: max(0, 1 - |x| / radius).
//
//   <rfilter type="tent"><float name="radius" value="1"/></rfilter>

#include <algorithm>
#include <cmath>

#include "kinome/plugin.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {
namespace {

constexpr float kMaxRadius = 64;

const Parameter kTable[] = {
    {"radius", ParameterType::kFloat, "1", "half width in pixels, from 0.5 to 64"},
};

class TentFilter : public ReconstructionFilter {
 public:
  explicit TentFilter(const Properties& props) {
    radius_ = props.real("radius");
    // Narrower ones would miss the samples in a pixel's corners.
    if (!(radius_ >= 0.5f && radius_ <= kMaxRadius)) {
      throw props.error("radius", "must lie in [0.5, 64] pixels, got " + std::to_string(radius_));
    }
  }
  float eval(float x) const override { return std::max(0.f, 1 - std::abs(x) / radius_); }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::TentFilter, kinome::Category::kReconstructionFilter, "tent",
              "Tent: linear fall-off to zero at its radius.", kinome::kTable);
