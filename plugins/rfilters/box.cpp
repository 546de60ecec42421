// Box of one pixel: a sample counts for the pixel that holds it, and for no other. The fastest
// filter, and the one to compare variances with, since pixels stay independent.
//
//   <rfilter type="box"/>

#include <cmath>

#include "kinome/plugin.h"
#include "kinome/reconstruction_filter.h"

namespace kinome {
namespace {

class BoxFilter : public ReconstructionFilter {
 public:
  explicit BoxFilter(const Properties&) { radius_ = 0.5f; }
  float eval(float x) const override { return std::abs(x) <= radius_ ? 1.f : 0.f; }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::BoxFilter, kinome::Category::kReconstructionFilter, "box",
              "Box of one pixel: every sample counts for its own pixel alone.", {});
