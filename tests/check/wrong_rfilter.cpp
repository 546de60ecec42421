// A tent filter, except for its fault.

#include <algorithm>
#include <cmath>

#include "kinome/reconstruction_filter.h"
#include "wrong.h"

namespace kinome::test {
namespace {

constexpr Parameter kTable[] = {KINOME_WRONG_PARAMETER};

class WrongTent final : public ReconstructionFilter {
 public:
  explicit WrongTent(const Properties& props) : wrong_(props) {
    radius_ = wrong_.or_wrong("radius", 1.f, 0.8f);
  }
  float eval(float x) const override {
    return std::max(0.f, 1 - std::abs(x)) * (wrong_.is("one side") && x < 0 ? 0.9f : 1.f);
  }
  void eval_block(const float* x, size_t count, float* out) const override {
    ReconstructionFilter::eval_block(x, count, out);
    for (size_t i = 0; wrong_.is("block") && i < count; ++i) out[i] *= 1.01f;
  }

 private:
  Wrong wrong_;
};

}  // namespace
}  // namespace kinome::test

KINOME_PLUGIN(kinome::test::WrongTent, kinome::Category::kReconstructionFilter, "wrong",
              "Has a fault.", kinome::test::kTable);
