// Box of one pixel: a sample counts for the pixel that holds it, and for no other. The fastest
// filter, and the one to compare variances with, since pixels stay independent.
//
//   <rfilter type="box"/>

#include "kinome/plugin.h"
#include "kinome/wide/reconstruction_filter.h"

namespace kinome {
namespace {

class BoxFilter final : public wide::FormulaFilter<BoxFilter> {
 public:
  explicit BoxFilter(const Properties&) { radius_ = 0.5f; }

  template <class F>
  F weight(F x) const {
    using namespace wide::formulas;
    return select(abs(x) <= radius_, F(1.f), F(0.f));
  }
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::BoxFilter, kinome::Category::kReconstructionFilter, "box",
              "Box of one pixel: every sample counts for its own pixel alone.", {});
