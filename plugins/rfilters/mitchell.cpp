// Mitchell and Netravali's cubics: sharp, with a little ringing, by default in the middle between
// blur and ringing. Partly negative.
//
//   <rfilter type="mitchell"><float name="B" value="0.33"/><float name="C" value="0.33"/></rfilter>

#include "cubic.h"
#include "kinome/plugin.h"

namespace kinome {
namespace {

/// Far beyond use; the filter's integral is 1 whatever they are.
constexpr float kLeast = -1, kMost = 2;

const Parameter kTable[] = {
    {"B", ParameterType::kFloat, "0.33333333", "how much it blurs, from -1 to 2"},
    {"C", ParameterType::kFloat, "0.33333333", "how much it rings, from -1 to 2"},
};

class MitchellFilter final : public wide::FormulaFilter<MitchellFilter> {
 public:
  explicit MitchellFilter(const Properties& props)
      : weights_(read(props, "B"), read(props, "C")) {
    radius_ = CubicWeights::kRadius;
  }

  template <class F>
  F weight(F x) const {
    return weights_.at(x);
  }

 private:
  static float read(const Properties& props, const char* name) {
    const float value = props.real(name);
    if (value >= kLeast && value <= kMost) return value;
    throw props.error(name, "must lie in [-1, 2], got " + std::to_string(value));
  }

  CubicWeights weights_;
};

}  // namespace
}  // namespace kinome

KINOME_PLUGIN(kinome::MitchellFilter, kinome::Category::kReconstructionFilter, "mitchell",
              "Mitchell and Netravali's cubics: sharp, with a little ringing.", kinome::kTable);
