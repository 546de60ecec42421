// Box of one pixel: a sample counts for the pixel that holds it, and for no other. The fastest
// filter, and the one to compare variances with, since pixels stay independent.
//
//   <rfilter type="box"/>

#include "kinome/plugin.h"
#include "kinome/reconstruction_filter.h"
#include "kinome/wide/vectors.h"

namespace kinome {
namespace {

class BoxFilter : public ReconstructionFilter {
 public:
  explicit BoxFilter(const Properties&) { radius_ = 0.5f; }
  float eval(float x) const override { return weight(x); }
  void eval_block(const float* x, size_t count, float* out) const override {
    wide::for_lanes(count, [&](size_t i) { weight(wide::Float::load(x + i)).store(out + i); });
  }

 private:
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
