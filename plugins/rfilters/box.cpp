// Box of one pixel: each sample contributes only to its own pixel. This is the fastest filter. It
// suits comparisons of variance, because the errors of different pixels are independent.
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
              "Box of one pixel: each sample contributes only to its own pixel.", {});
